"""A look beyond the orders compared, without draws: a wider range may hold a better model."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from bayescal.comparison.families.candidates.joint import Gaussian
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.finding import Finding, overturns
from bayescal.comparison.key import PINHOLE
from bayescal.errors import InputError

# Orders tried above the highest compared, of polynomials and of a pinhole's radial terms.
MORE, MORE_RADIAL = 3, 2
# Odds against the most probable model beyond which a further one is excluded.
EXCLUDED = 19.0

# From family and position, and the orders wanted, to its candidates.
Listing = Callable[[str, str, Sequence[tuple[int, ...]]], Iterable[Gaussian]]


def beyond_compared(models: Sequence[JointModel], listing: Listing) -> Iterator[Finding]:
    """Find models with orders above those compared that would win, or can't be excluded.

    Looked at are those next to the best of each family and position, where it lies at the edge of
    its range, by closed forms and Laplace approximations. Beside a single model, of which it is not
    said how sure it is, only one that would win matters.
    """
    found = {
        one.key: one.approximate
        for family, position, orders in _next(models)
        for one in _determined(family, position, orders, listing)
    }
    if not found:
        return
    best = max(found, key=lambda key: found[key])
    gain = found[best] - models[0].log_evidence
    if gain < (0.0 if len(models) == 1 else -math.log(EXCLUDED)):
        return
    factor = f"2 ln B = {round(2 * gain, 1) + 0.0:.1f} against {models[0].key}"
    says = "would win" if gain > 0 else "can't be excluded"
    yield overturns(
        "edge",
        f"{best}, beyond the orders compared, {says} ({factor}): compare more orders",
        f"{best}, which was not compared, {says}",
    )


def _next(models: Sequence[JointModel]) -> Iterator[tuple[str, str, list[tuple[int, ...]]]]:
    """Name families, positions, and the orders next to the best where it lies at the edge."""
    kinds = dict.fromkeys((m.key.family, m.key.position) for m in models)
    for family, position in kinds:
        own = [m.key.orders for m in models if (m.key.family, m.key.position) == (family, position)]
        best, more = own[0], MORE_RADIAL if family == PINHOLE else MORE
        orders = [
            (*best[:i], order + step, *best[i + 1 :])
            for i, order in enumerate(best)
            if order == max(one[i] for one in own)
            for step in range(1, more + 1)
        ]
        if orders:
            yield family, position, orders


def _determined(
    family: str, position: str, orders: Sequence[tuple[int, ...]], listing: Listing
) -> Iterator[Gaussian]:
    """List the candidates that the points determine."""
    for one in orders:
        with contextlib.suppress(InputError):
            yield from listing(family, position, [one])
