"""Each view left out in turn, and the views in two halves: refits, not weights."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.calibration.density import Problem
from bayescal.calibration.laplace import Laplace, laplace
from bayescal.calibration.reduction import eliminate
from bayescal.calibration.strengths import COARSE, Strengths, strengths
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut

REFITS = 2  # Gauss-Newton steps from the fit to all views
FAR = 0.3  # posterior deviations: without a view so influential residuals are linearised anew


class Rest(NamedTuple):
    """How much is left without a view."""

    n_points: int
    n_views: int
    log_weight: float


def leave_views_out(problem: Problem) -> tuple[LeaveOneOut, Array] | None:
    """Predict each view from the others under the same error model.

    ln p(view | others) is the difference of two evidences, both by linear algebra; with the
    lens's coordinates without each view, ``(n_views, dimension)``. None for fewer than three
    views.
    """
    n = problem.data.n_views
    if n < 3:
        return None
    prior = strengths(problem.model).only(problem.laplace.likely)
    whole = problem.laplace_over(prior)
    sd = np.sqrt(np.diag(whole.covariance))
    densities, lenses = [], []
    for view in range(n):
        x, rest = problem.x, _without(problem, view, prior)
        if np.abs((rest.mean - whole.mean) / sd).max() > FAR:
            again = refitted(problem, np.delete(np.arange(n), view))
            x, rest = again.x, again.laplace_over(prior)
        densities.append(whole.log_evidence - rest.log_evidence)
        lenses.append(x + rest.mean)
    left_out = LeaveOneOut(np.array(densities), refitted=tuple(range(n)))
    return left_out, np.array(lenses)


def _without(problem: Problem, view: int, prior: Strengths) -> Laplace:
    """Posterior without a view: its normal equations are taken from those of all."""
    data, shared = problem.data, problem.shared
    sums = problem.views.without(view, problem.stack, data, shared)
    log_weight = float(np.log(data.weight[view, data.seen[view]]).sum())
    rest = Rest(
        data.n_points - int(data.counts[view]), data.n_views - 1, data.log_weight - log_weight
    )
    log_det = shared.log_det - (0.0 if shared.inverse is None else float(shared.log_dets[view]))
    return laplace(eliminate(sums, problem.root), problem.x, rest, prior, log_det, problem.level)


def refitted(problem: Problem, views: IntArray) -> Problem:
    """Fit a lens to some of the views, from where it is."""
    found = problem.only(views)
    prior = strengths(problem.model, COARSE)
    for _ in range(REFITS):
        step = found.laplace_over(prior).mean
        moved = replace(found, x=found.x + step, poses=found.poses_at(found.x + step))
        if not moved.stack.possible:
            break
        found = moved
    return found


def halves(problem: Problem) -> tuple[Array, ...]:
    """Coordinates of the lens fitted to every second view and to the others, if six or more."""
    n = problem.data.n_views
    if n < 6:
        return ()
    return tuple(refitted(problem, np.arange(first, n, 2)).x for first in (0, 1))


def jackknife(lenses: Array) -> Array:
    """Covariance of a lens's coordinates by the jackknife over views, ``(d, d)``."""
    n = len(lenses)
    gap = lenses - lenses.mean(axis=0)
    return np.asarray((n - 1) / n * gap.T @ gap)
