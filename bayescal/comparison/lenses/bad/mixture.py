"""Lenses weighed over sets of bad points: each about the set that is most probable under it.

All lenses are judged without one common set, so that their residuals can be compared. Where
another set is more probable under a lens, as under one too simple to have points where they are,
the lens is weighed without that set too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bayescal.calibration.fitting.least_squares import Fit, least_squares
from bayescal.calibration.fitting.start import start_fit
from bayescal.calibration.judging.bad_points import BadPoints, about, search
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.judge import LensEvidence, Setting, Weighed, lens_evidence
from bayescal.calibration.model.error_grid import Averaged
from bayescal.calibration.model.error_model import INDEPENDENT, Geometry
from bayescal.calibration.model.lens_model import LensModel

TURNS = 3  # of weighing a lens without the set that it makes most probable
FIRST_TURNS = 8
# How far searches look beyond the best set: of all points, at least, at most.
FIRST = (0.1, 10, 200)
AHEAD = (0.05, 10, 50)
DRAWS = 100  # importance draws, of which nothing is used

Marks = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Mixed:
    """What a lens is weighed by where points may be bad.

    Attributes
    ----------
    sets : BadPoints
        A set of bad points, and those about it.
    common : bool
        Whether it is the set without which all lenses are judged.
    log_evidence, error : float
        Without the points of that set, nat.
    warnings : tuple of str
        Of that evidence.
    """

    sets: BadPoints
    common: bool
    log_evidence: float
    error: float
    warnings: tuple[str, ...]

    @property
    def total(self) -> float:
        """Log evidence over all these sets, nat."""
        return self.log_evidence + self.sets.log_share


@dataclass(frozen=True, eq=False)
class Mixing:
    """What lenses share where points may be bad.

    Attributes
    ----------
    whole : Setting
        Of all points.
    common : ndarray of bool
        Points without which all lenses are judged, ``(n_views, n_places)``.
    """

    whole: Setting
    common: Marks


def without(whole: Setting, points: Marks) -> Setting:
    """Leave points out of what all lenses share."""
    data = whole.data.without(points)
    return replace(whole, data=data, geometry=Geometry(data))


def first_set(models: Sequence[LensModel], whole: Setting, points: Marks) -> Marks:
    """Find bad points before any lens is judged, by the best fit of lenses with many terms.

    Parameters
    ----------
    points : ndarray of bool
        Where to begin, ``(n_views, n_places)``.
    """
    fits = [start_fit(model, whole.data.without(points)) for model in models]
    if not np.isfinite([fit.sum_of_squares for fit in fits]).any():
        return points
    ahead = _ahead(FIRST, whole)
    for _ in range(FIRST_TURNS):
        data = whole.data.without(points)
        fits = [least_squares(m, data, f.x, f.poses) for m, f in zip(models, fits, strict=True)]
        model, fit = min(zip(models, fits, strict=True), key=lambda pair: pair[1].sum_of_squares)
        problem = Problem(model, whole.data, fit.x, fit.poses, INDEPENDENT, None, whole.level)
        before, points = points, search(problem, points, ahead)
        ahead = _ahead(AHEAD, whole)  # what hid is found
        if (points == before).all():
            break
    for _ in range(TURNS):
        found = _weighed(model, fit, whole, points, None, np.random.default_rng(0), DRAWS)
        problem = LensEvidence.of(found, model, whole).problem
        before, points = points, search(problem, points, ahead)
        if (points == before).all():
            break
    return points


def mixed(
    model: LensModel,
    fit: Fit,
    evidence: LensEvidence,
    mixing: Mixing,
    rng: np.random.Generator,
    draws: int,
) -> Mixed:
    """Weigh a lens over the sets about the common one, or about its own if that is better.

    Parameters
    ----------
    evidence : LensEvidence
        Without the common set.
    """
    whole, common = mixing.whole, mixing.common
    errors, problem = evidence.errors, evidence.problem
    problem = whole.problem(problem.model, problem.x, problem.poses, errors.nodes[0])
    estimate = evidence.estimate
    best = Mixed(
        about(problem, common), True, evidence.log_evidence, estimate.error, estimate.warnings
    )
    if not np.isfinite(estimate.error):
        return best
    ahead = _ahead(AHEAD, whole)
    tried, sets = [common], best.sets
    for _ in range(TURNS):
        points = search(problem, tried[-1], ahead)
        if not ((points ^ tried[-1]) & ~sets.doubtful).any():
            break  # summed over already
        found = _weighed(model, fit, whole, points, errors, rng, draws)
        problem, errors = LensEvidence.of(found, model, whole).problem, found.errors
        sets = about(problem, points)
        own = Mixed(sets, False, found.log_evidence, found.estimate.error, found.estimate.warnings)
        if np.isfinite(own.error):
            best = max(best, own, key=lambda one: one.total)
        tried.append(points)
    return best


def _ahead(limits: tuple[float, int, int], whole: Setting) -> int:
    share, least, most = limits
    return int(np.clip(round(share * whole.data.n_points), least, most))


def _weighed(
    model: LensModel,
    fit: Fit,
    whole: Setting,
    points: Marks,
    like: Averaged | None,
    rng: np.random.Generator,
    draws: int,
) -> Weighed:
    """Weigh a lens without some points."""
    setting = without(whole, points)
    fit = least_squares(model, setting.data, fit.x, fit.poses)
    return lens_evidence(model, [(fit.x, fit.poses)], setting, like, rng, draws)
