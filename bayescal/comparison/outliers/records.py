"""Which points are bad on one axis: each point's residual, influence and probability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, finite
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.outliers.rejection import Rejection, RejectionRule, point_tests, reject
from bayescal.linear.design_fit import FULL_LEVERAGE, DesignFit
from bayescal.polynomials.axis_data import AxisData

# A point is called bad above this posterior probability.
BAD = 0.5


@dataclass(frozen=True)
class PointRecord:
    """What is known of one point on one axis.

    Attributes
    ----------
    index : int
        From 0.
    measured : float
        px.
    predicted, predicted_sd : float
        By the mixture, which does not follow the points it calls bad: posterior mean and
        sd of the model there, px.
    residual : float
        Measured less least squares, px.
    standardised : float or None
        Residual over its own standard deviation, sigma taken from the other points;
        None for a point that alone fixes a coefficient.
    leverage : float
        0 to 1.
    cook : float or None
        Cook's distance; None where `standardised` is.
    rejected_at : tuple of int
        Orders at which the chi-squared test removes it.
    bad_probability : float
        That it is bad, posterior, under the mixture.
    weight : float
        Share of a good point's precision that Student-t noise leaves it, posterior mean.
    order_without : int
        The order that wins without it, under Gaussian noise.
    log_bayes_factor_without : float or None
        ln B, without it, of the order that wins with it against the best other one; None
        where one order is all there is.
    """

    index: int
    label: str
    measured: float
    predicted: float
    predicted_sd: float
    residual: float
    standardised: float | None
    leverage: float
    cook: float | None
    rejected_at: tuple[int, ...]
    bad_probability: float
    weight: float
    order_without: int
    log_bayes_factor_without: float | None

    @property
    def off(self) -> float:
        """Measured less predicted by the mixture, px."""
        return self.measured - self.predicted

    @property
    def bad(self) -> bool:
        """Whether it is more probably bad than good."""
        return self.bad_probability > BAD


@dataclass(frozen=True, eq=False)
class RobustView:
    """What the robust noise models say of every point.

    Attributes
    ----------
    predicted, predicted_sd : Array
        Of the mixture, ``(n_points,)``, px.
    bad_probability, weight : Array
        Of the mixture and of Student-t noise, ``(n_points,)``.
    """

    predicted: Array
    predicted_sd: Array
    bad_probability: Array
    weight: Array


@dataclass(frozen=True)
class Elimination:
    """The chi-squared elimination of an axis at every order compared."""

    by_order: dict[int, Rejection]

    @property
    def highest(self) -> Rejection:
        """At the highest order, whose residuals hold least of what a model can't follow."""
        return self.by_order[max(self.by_order)]

    def rejected_at(self, point: int) -> tuple[int, ...]:
        """Orders at which a point is removed."""
        return tuple(k for k, found in self.by_order.items() if point in found.removed)


def eliminate(data: AxisData, orders: Sequence[int], rule: RejectionRule) -> Elimination:
    """Remove bad points by a chi-squared test, at each order by itself.

    Parameters
    ----------
    data : AxisData
        With deviations only where they are used; the rule's sigma is a factor on them.
    """
    own = data.deviations
    return Elimination(
        {k: reject(data.design(k) / own[:, None], data.t / own, rule) for k in orders}
    )


def point_records(
    data: AxisData,
    elimination: Elimination,
    order: int,
    loo: Mapping[int, LeaveOneOut],
    log_evidence: Mapping[int, float],
    robust: RobustView,
) -> tuple[PointRecord, ...]:
    """Collect what is known of every point, the most suspicious first.

    Parameters
    ----------
    order : int
        Whose residuals are shown.
    loo : mapping of int to LeaveOneOut
        By order, under Gaussian noise.
    log_evidence : mapping of int to float
        By order, of all points, under Gaussian noise.
    robust : RobustView
        Of the same order.
    """
    fit = elimination.by_order[order].before
    tests = point_tests(fit, elimination.by_order[order].rule.sigma)
    residuals = fit.residuals * data.deviations
    cook = cooks_distance(fit)
    orders = list(log_evidence)
    left = np.array([log_evidence[k] - loo[k].pointwise for k in orders])
    best = left.argmax(axis=0)
    winner = orders.index(max(orders, key=lambda k: (log_evidence[k], -k)))
    lead = left[winner] - np.delete(left, winner, axis=0).max(axis=0, initial=-np.inf)
    records = [
        PointRecord(
            i,
            data.labels[i],
            float(data.t[i]),
            float(robust.predicted[i]),
            float(robust.predicted_sd[i]),
            float(residuals[i]),
            None if tests is None else finite(tests.standardised[i]),
            float(fit.leverages[i]),
            finite(cook[i]),
            elimination.rejected_at(i),
            float(robust.bad_probability[i]),
            float(robust.weight[i]),
            orders[best[i]],
            finite(lead[i]),
        )
        for i in range(len(data))
    ]
    return tuple(
        sorted(records, key=lambda p: (-round(p.bad_probability, 3), -abs(p.standardised or 0.0)))
    )


def cooks_distance(fit: DesignFit) -> Array:
    """Cook's distance of every point, ``(n_points,)``; NaN where a point has no residual.

    D = e^2 h / (p s^2 (1 - h)^2) (Cook 1977, Technometrics 19, 15).
    """
    out = np.full(len(fit), np.nan)
    if fit.exact or fit.dof < 1:
        return out
    usable = fit.leverages < FULL_LEVERAGE
    h, e = fit.leverages[usable], fit.residuals[usable]
    out[usable] = e**2 * h / (fit.n_coefficients * fit.rss / fit.dof * (1 - h) ** 2)
    return out
