"""Leave-one-out of every order, and what the choice of another one would change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut, paired_difference
from bayescal.comparison.defence.results import Prediction, Worth
from bayescal.comparison.orders.result import OrderResult
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design

PREDICTED = 2000  # draws that predictions are compared by


def predictions(
    data: AxisData,
    results: Sequence[OrderResult],
    psis: Mapping[int, LeaveOneOut | None],
    groups: Mapping[int, float | None],
) -> dict[int, Prediction]:
    """Compare the orders' leave-one-outs, with those from draws and by group beside them."""
    known = {r.order: r.loo for r in results if r.loo is not None}
    if not known:
        return {}
    best = max(known.values(), key=lambda loo: loo.elpd)
    out = {}
    for k, loo in known.items():
        found = psis.get(k)
        worst = () if found is None else tuple(data.labels[i] for i in found.unreliable)
        out[k] = Prediction(loo, *paired_difference(loo, best), groups.get(k), found, worst)
    return out


def worth(
    data: AxisData, results: Mapping[int, OrderResult], order: int, others: Sequence[int]
) -> tuple[Worth, ...]:
    """Say how far each other order's prediction is from the recommended one's."""
    return tuple(_worth(data, results, order, k) for k in others if k != order)


def _worth(data: AxisData, results: Mapping[int, OrderResult], order: int, other: int) -> Worth:
    s = np.linspace(-1, 1, 401)
    curves = {k: _curve(results[k], k, s) for k in (order, other)}
    difference = np.abs(curves[other][0] - curves[order][0])
    place = int(difference.argmax())
    sd = float(curves[max(order, other)][1][place])
    at = data.domain.middle + data.domain.half_range * float(s[place])
    return Worth(other, float(difference[place]), sd, at)


def _curve(result: OrderResult, order: int, s: Array) -> tuple[Array, Array]:
    """Posterior mean and sd of the prediction over the domain, ``(n_places,)``, px."""
    design, exact = legendre_design(s, order), result.exact
    if exact is not None:
        return design @ exact.mean, np.linalg.norm(design @ exact.root, axis=1)
    amplitudes = result.posterior.chain.theta[..., : order + 1].reshape(-1, order + 1)
    drawn = amplitudes[:: max(1, len(amplitudes) // PREDICTED)] @ design.T
    return drawn.mean(axis=0), drawn.std(axis=0, ddof=1)
