"""Each view left out in turn, and the views in two halves: refits, not weights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.calibration.density import Problem
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut

REFITS = 2  # Gauss-Newton steps from the fit to all views


def leave_views_out(problem: Problem) -> tuple[LeaveOneOut, Array] | None:
    """Predict each view from the others under the same error model.

    ln p(view | others) is the difference of two evidences, both by linear algebra; with the
    lens's coordinates without each view, ``(n_views, dimension)``. None for fewer than three
    views.
    """
    n = problem.data.n_views
    if n < 3:
        return None
    densities, lenses = [], []
    for view in range(n):
        rest = refitted(problem, np.delete(np.arange(n), view))
        densities.append(problem.laplace.log_evidence - rest.laplace.log_evidence)
        lenses.append(rest.x + rest.laplace.mean)
    left_out = LeaveOneOut(np.array(densities), refitted=tuple(range(n)))
    return left_out, np.array(lenses)


def refitted(problem: Problem, views: IntArray) -> Problem:
    """Fit a lens to some of the views, from where it is."""
    found = problem.only(views)
    for _ in range(REFITS):
        step = found.laplace.mean
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
