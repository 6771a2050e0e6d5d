"""Each view left out in turn, and the views in two halves: refits, not weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.calibration.fitting.reduction import eliminate
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.laplace import LOG_POSE, Forms, Laplace, degrees, laplace
from bayescal.calibration.model.strengths import Strengths, strengths
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut

REFITS = 4  # Gauss-Newton steps at most
FAR = 0.5  # posterior deviations: farther off residuals are linearised anew
CLOSE = 0.01  # deviations: halves of the views are fitted until a step is as short


def leave_views_out(problem: Problem) -> tuple[LeaveOneOut, Array] | None:
    """Predict each view from the others under the same error model.

    ln p(view | others) is the difference of two evidences, both by linear algebra, to some
    hundredths of a nat; with the lens's coordinates without each view, ``(n_views, dimension)``.
    None for fewer than three views.
    """
    n = problem.data.n_views
    if n < 3:
        return None
    prior = strengths(problem.model).only(problem.laplace.likely())
    whole = problem.laplace_over(prior)
    sd = np.sqrt(np.diag(whole.covariance))
    densities, lenses = [], []
    for view, rest in enumerate(laplace(_without(problem), problem.x, prior, problem.level)):
        x = problem.x
        if np.abs((rest.mean - whole.mean) / sd).max() > FAR:
            others = np.delete(np.arange(n), view)
            again, rest = refitted(problem, others, prior, rest.mean, FAR)
            x = again.x
        densities.append(whole.log_evidence - rest.log_evidence)
        lenses.append(x + rest.mean)
    left_out = LeaveOneOut(np.array(densities), refitted=tuple(range(n)))
    return left_out, np.array(lenses)


def _without(problem: Problem) -> Forms:
    """Take the normal equations of each view from those of all."""
    data, shared, n = problem.data, problem.shared, problem.data.n_views
    reduced = [
        eliminate(problem.views.without(v, problem.stack, data, shared), problem.root)
        for v in range(n)
    ]
    own = np.where(data.seen[..., None], data.weight, 1.0)
    log_det = np.array([r.log_det for r in reduced])
    log_det += shared.log_det - (0.0 if shared.inverse is None else shared.log_dets)
    fixed = data.log_weight - np.log(own).sum(axis=(1, 2)) - log_det / 2 + (n - 1) * LOG_POSE
    return Forms.of(
        np.array([r.gram for r in reduced]), degrees(data) - (2 * data.counts - 6), fixed
    )


def refitted(
    problem: Problem,
    views: IntArray,
    prior: Strengths,
    step: Array | float = 0.0,
    close: float = CLOSE,
) -> tuple[Problem, Laplace]:
    """Fit a lens to some of the views, and give its posterior from where residuals are linear.

    Parameters
    ----------
    prior : Strengths
        Combinations of strengths that matter.
    step : Array or float, optional
        From where it is to where the fit begins, ``(dimension,)``.
    close : float, optional
        Length of the step from there that ends the fit, posterior deviations.
    """
    found = problem.moved(step).only(views)
    if not found.stack.possible:
        found = problem.only(views)
    rest = found.laplace_over(prior)
    for _ in range(REFITS):
        if np.abs(rest.mean / np.sqrt(np.diag(rest.covariance))).max() < close:
            break
        moved = found.moved(rest.mean)
        if not moved.stack.possible:
            break
        found, rest = moved, moved.laplace_over(prior)
    return found, rest


@dataclass(frozen=True, eq=False)
class Split:
    """A lens fitted to either half of the views.

    Attributes
    ----------
    apart : Array
        Coordinates of the one fit less those of the other, ``(dimension,)``.
    covariance : Array
        What noise lets that be: both posteriors', ``(dimension, dimension)``.
    """

    apart: Array
    covariance: Array


def halves(problem: Problem) -> tuple[Split, ...]:
    """Split six or more views: every second and the others; the first half and the rest."""
    views = np.arange(problem.data.n_views)
    if len(views) < 6:
        return ()
    prior = problem.likely_strengths
    splits = []
    for one in (views % 2 == 0, views < len(views) // 2):
        fits = [refitted(problem, views[half], prior) for half in (one, ~one)]
        (first, own), (second, other) = fits
        splits.append(Split(first.x - second.x, own.covariance + other.covariance))
    return tuple(splits)


def jackknife(lenses: Array) -> Array:
    """Covariance of a lens's coordinates by the jackknife over views, ``(d, d)``."""
    n = len(lenses)
    gap = lenses - lenses.mean(axis=0)
    return np.asarray((n - 1) / n * gap.T @ gap)
