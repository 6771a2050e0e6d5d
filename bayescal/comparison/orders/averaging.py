"""Predictions averaged over orders: what the choice of one order leaves out of its intervals.

With probabilities p_k, means m_k and standard deviations s_k of the orders' predictions, the
average has mean m = sum p_k m_k and variance sum p_k s_k^2 + sum p_k (m_k - m)^2: within orders,
and between them (Hoeting et al. 1999, Statist. Sci. 14, 382).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.evidence import probabilities
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.result import OrderResult
from bayescal.errors import InputError
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.polynomials.basis import Domain, legendre_design
from bayescal.rounding import significant

# Places of the domain whose predictions are shown: its edges, its middle and half-way.
PLACES = (-1.0, -0.5, 0.0, 0.5, 1.0)
# Where one order alone was fitted, it is averaged with the others up to this one or itself.
USUAL = 5
# Share of the averaged standard deviation below which the part between orders is not spoken of.
SPOKEN = 0.1


@dataclass(frozen=True, eq=False)
class AveragedPrediction:
    """The prediction of a pixel under one order, and averaged over orders.

    Attributes
    ----------
    order : int
        The recommended order, or the one asked for.
    weights : dict of int to float
        Probability of each order averaged over.
    x : Array
        Regressor values, ``(n_places,)``.
    chosen, chosen_sd : Array
        Under the one order, ``(n_places,)``, px.
    mean, sd : Array
        Averaged over orders, ``(n_places,)``, px.
    between : Array
        The part of `sd` between orders, ``(n_places,)``, px.
    suffix : str
        Unit behind a number, with its space.
    """

    order: int
    weights: dict[int, float]
    x: Array
    chosen: Array
    chosen_sd: Array
    mean: Array
    sd: Array
    between: Array
    suffix: str = " px"


def averaged_prediction(
    domain: Domain,
    posteriors: Mapping[int, ExactPosterior],
    probability: Mapping[int, float],
    order: int,
    suffix: str = " px",
) -> AveragedPrediction:
    """Average the orders' predictions at five places of the domain.

    Parameters
    ----------
    domain : Domain
        Of the regressor.
    posteriors : mapping of int to ExactPosterior
        By order.
    probability : mapping of int to float
        Of each of them, summing to 1.
    order : int
        The one whose prediction stands beside.
    suffix : str, optional
        Unit behind a prediction, with its space.
    """
    s = np.array(PLACES)
    means, sds = {}, {}
    for k, exact in posteriors.items():
        design = legendre_design(s, k)
        means[k] = design @ exact.mean
        sds[k] = np.linalg.norm(design @ exact.root, axis=1)
    weights = np.array([probability[k] for k in posteriors])
    table = np.array([means[k] for k in posteriors])
    mean = weights @ table
    between = weights @ (table - mean) ** 2
    within = weights @ np.array([sds[k] ** 2 for k in posteriors])
    return AveragedPrediction(
        order,
        {k: float(probability[k]) for k in posteriors},
        domain.middle + domain.half_range * s,
        means[order],
        sds[order],
        mean,
        np.sqrt(within + between),
        np.sqrt(between),
        suffix,
    )


def averaged_over(
    axis: Axis, results: Sequence[OrderResult], order: int | None
) -> AveragedPrediction | None:
    """Average over the orders compared, or, of one order fitted alone, over the usual ones.

    Parameters
    ----------
    order : int or None
        The one whose prediction stands beside.

    Returns
    -------
    AveragedPrediction or None
        None where orders have no evidence in closed form, or there is only one.
    """
    exact = {r.order: r.exact for r in results if r.exact is not None}
    if order is None or len(exact) < len(results) or not axis.rule.of_order(order).proper:
        return None
    if len(results) == 1:
        highest = min(max(order, USUAL), axis.data.distinct - 1, axis.data.n - 1)
        try:
            wider = axis.up_to(highest)
            for k in range(1, highest + 1):
                if k != order:
                    exact[k] = exact_posterior(wider.linear(k))
        except InputError:  # points or stated prior do not reach so far
            return None
    if len(exact) < 2:
        return None
    exact = dict(sorted(exact.items()))
    weights = probabilities([e.log_integral for e in exact.values()])
    chances = dict(zip(exact, weights, strict=True))
    return averaged_prediction(axis.data.domain, exact, chances, order, axis.data.suffix)


def averaged_words(found: AveragedPrediction | None) -> str:
    """Say what the choice of an order leaves out of its intervals, where that is worth a word."""
    if found is None:
        return ""
    ends = [0, -1]
    at = max(ends, key=lambda i: float(found.sd[i]))
    sd, between, own = (float(v[at]) for v in (found.sd, found.between, found.chosen_sd))
    if between < SPOKEN * sd:
        return ""
    px = found.suffix
    low, high = min(found.weights), max(found.weights)
    return (
        f"Averaged over orders {low} to {high}, the prediction at the domain's edge has an sd of "
        f"{significant(sd)}{px}, {significant(between)}{px} of it between orders, where order "
        f"{found.order} alone has {significant(own)}{px}."
    )
