"""Orders beyond the compared range, and whether one of them would win."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bayescal.comparison.evidence import probabilities
from bayescal.errors import InputError
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import Factorisation, factorise
from bayescal.linear.model import LinearModel
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule

BEYOND = 3


@dataclass(frozen=True)
class Beyond:
    """Orders above the compared range.

    Attributes
    ----------
    probability : dict of int to float
        Of every order, compared and beyond, were all of them candidates.
    winner : int or None
        The order beyond that would win; None where none does.
    orders : tuple of int
        The orders beyond that were tried.
    """

    probability: dict[int, float]
    winner: int | None
    orders: tuple[int, ...]


def beyond(
    data: AxisData,
    log_evidence: Mapping[int, float],
    noise: NoiseLevel,
    rule: PriorRule,
) -> Beyond:
    """Ask whether up to three orders above the compared range would win.

    Parameters
    ----------
    log_evidence : mapping of int to float
        Of the orders compared.
    """
    more, factors = orders_beyond(data, max(log_evidence), rule)
    evidence = dict(log_evidence)
    if factors is not None:
        for k in more:
            model = LinearModel(factors, k, noise, rule.of_order(k), data.symbol)
            evidence[k] = exact_posterior(model).log_integral
    return beyond_of(evidence, more)


def orders_beyond(
    data: AxisData, highest: int, rule: PriorRule
) -> tuple[tuple[int, ...], Factorisation | None]:
    """Find the orders above the compared range that these points determine, up to three.

    Returns
    -------
    factors : Factorisation or None
        At the highest of them; None where there is none.
    """
    limit = min(data.distinct, data.n) - 1
    if rule.reach is not None:
        limit = min(limit, rule.reach)
    more = range(highest + 1, min(highest + BEYOND, limit) + 1)
    while more:
        try:
            return tuple(more), factorise(data, more[-1])
        except InputError:  # these points don't determine it
            more = more[:-1]
    return (), None


def beyond_of(log_evidence: Mapping[int, float], more: tuple[int, ...]) -> Beyond:
    """Say which order wins with the orders beyond compared too.

    Parameters
    ----------
    log_evidence : mapping of int to float
        Of every order, compared and beyond.
    more : tuple of int
        Those beyond.
    """
    chance = dict(zip(log_evidence, probabilities(list(log_evidence.values())), strict=True))
    best = max(chance, key=lambda k: (chance[k], -k))
    return Beyond(chance, best if best in more else None, more)
