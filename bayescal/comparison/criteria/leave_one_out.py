"""Leave-one-out of an order: exact, however many its points are, and what is compared of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, IntArray, frozen
from bayescal.comparison.criteria.leaving import Leaving
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.polynomials.axis_data import AxisData


@dataclass(frozen=True, eq=False)
class LeaveOneOut:
    """Expected log pointwise predictive density (elpd), however its terms were computed.

    Attributes
    ----------
    pointwise : Array
        ln p(unit i | all other units), ``(n_units,)``: a unit is a pixel value of one axis, or r
        and c of a point together.
    p_eff : float or None
        Effective number of parameters: in-sample log predictive density less elpd.
    refitted : tuple of int
        Units whose removal needed a fit or an evidence of its own.
    pareto_k : Array or None
        Shape of each unit's weights where the terms come from draws, ``(n_units,)``: inf where
        there is none, -inf of those refitted; None where the terms are exact.
    k_limit : float or None
        Good below it; fewer draws can judge thinner tails only.
    mcse : float
        Monte Carlo standard error of elpd.
    """

    pointwise: Array
    p_eff: float | None = None
    refitted: tuple[int, ...] = ()
    pareto_k: Array | None = None
    k_limit: float | None = None
    mcse: float = 0.0

    @property
    def elpd(self) -> float:
        """Sum of the terms."""
        return float(self.pointwise.sum())

    @property
    def se(self) -> float:
        """Its standard error: sqrt(n) times the sd (n - 1) of the terms."""
        return _se(self.pointwise)

    @property
    def largest_k(self) -> float | None:
        """Largest Pareto k of those that draws tell of; None where the terms are exact."""
        if self.pareto_k is None:
            return None
        largest = float(self.pareto_k.max())
        return 0.0 if largest == -math.inf else largest

    @property
    def unreliable(self) -> tuple[int, ...]:
        """Units whose Pareto k is not good, the worst first."""
        if self.pareto_k is None or self.k_limit is None:
            return ()
        order = np.argsort(-self.pareto_k, kind="stable")
        return tuple(int(i) for i in order if not self.pareto_k[i] < self.k_limit)

    @property
    def reliable(self) -> bool:
        """Whether it is exact, or every unit's Pareto k is good."""
        return not self.unreliable


def leave_one_out(data: AxisData, exact: ExactPosterior) -> LeaveOneOut | None:
    """Exact leave-one-out of one order; sigma and tau averaged.

    Parameters
    ----------
    data : AxisData
        The points that `exact` was made from.

    Returns
    -------
    LeaveOneOut or None
        None where the posterior without a point does not exist (a flat prior and no
        degree of freedom to spare).
    """
    design, sd = data.design(exact.model.order), data.deviations
    found = Leaving.of(exact, design, sd).terms(design, data.t, sd)
    if found is None:
        return None
    out, inside, moved = found
    if moved.any():
        out[moved] = exact.log_integral - _refitted(data, exact, np.flatnonzero(moved))
    again = tuple(np.flatnonzero(moved).tolist())
    return LeaveOneOut(frozen(out), float(inside.sum() - out.sum()), again)


@dataclass(frozen=True)
class TotalLeaveOneOut:
    """Exact leave-one-out of points too many for a term of each to be kept.

    Attributes
    ----------
    elpd, se, p_eff : float
        As of `LeaveOneOut`.
    refitted : int
        How many points needed a fit of their own.
    """

    elpd: float
    se: float
    p_eff: float
    refitted: int


def _refitted(data: AxisData, exact: ExactPosterior, points: IntArray) -> Array:
    """Log evidence without each of some points."""
    model = exact.model
    members = np.zeros((len(points), len(data)))
    members[np.arange(len(points)), points] = 1
    sets = Rows.of(data, model.order).without(members)
    return log_evidences(sets.reduced(model.order), model.noise, model.prior, FINE)


def paired_difference(one: LeaveOneOut, other: LeaveOneOut) -> tuple[float, float]:
    """Difference of elpd, `one` less `other`, and its paired standard error."""
    difference = one.pointwise - other.pointwise
    return float(difference.sum()), _se(difference)


def _se(terms: Array) -> float:
    """Give the standard error of a sum: sqrt(n) times the sd (n - 1) of its terms."""
    n = len(terms)
    return math.sqrt(n) * float(terms.std(ddof=1)) if n > 1 else math.nan
