"""Points that the error model can't explain: looked for, and again without what they spoil.

Gross errors pull at the lens, and choose an error model and a lens of their own. Once points are
found, lens and error model are chosen again without them, and all points are looked at under
these, until the same ones are found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bayescal.calibration.fitting.least_squares import Fit, least_squares
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.free_points import FreePoint, FreePoints
from bayescal.calibration.judging.judge import LensEvidence, Setting, lens_evidence
from bayescal.calibration.model.error_model import Geometry
from bayescal.comparison.lenses.off_point import GrossError
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.points.views.views import Views

LEVEL = 0.01  # of finding any point at all where none is off (Bonferroni)
MOST = 100  # points that are looked for
TURNS = 3
FEWEST = 6  # points of a view that are left to place it
DRAWS = 100  # importance draws, of which nothing is used


def gross_errors(
    lenses: Sequence[JudgedLens], setting: Setting, views: Views
) -> tuple[GrossError, ...]:
    """Find points that are off, the least probable first, each without those before it.

    Parameters
    ----------
    lenses : sequence of JudgedLens
        The most probable first.
    """
    found = search(lenses[0].evidence.problem)
    for _ in range(TURNS):
        again = _chosen_without(found, lenses, setting) if found else None
        if again is None:
            break
        before, found = found, search(again)
        if {(p.view, p.place) for p in before} == {(p.view, p.place) for p in found}:
            break
    return tuple(_named(point, views) for point in found)


def search(problem: Problem) -> list[FreePoint]:
    """Find points that are off under a settled problem; p-values times those left to look at."""
    free = FreePoints(problem)
    found: list[FreePoint] = []
    while len(found) < MOST and (worst := free.least_probable()) is not None:
        log_p = worst.log_p + math.log(free.left.sum())
        if log_p >= math.log(LEVEL):
            break
        found.append(replace(worst, log_p=log_p))
        free.release(worst.view, worst.place)
    return found


def _chosen_without(
    found: Sequence[FreePoint], lenses: Sequence[JudgedLens], setting: Setting
) -> Problem | None:
    """Choose lens (by BIC) and error model without points, which are then put back.

    None where a view has too few others to be placed by.
    """
    data = setting.data
    weight = data.weight.copy()
    weight[[p.view for p in found], [p.place for p in found]] = 0
    kept = replace(data, weight=weight)
    needed = np.where(kept.counts < data.counts, np.maximum(FEWEST, data.counts / 2), 0)
    if (kept.counts < needed).any():
        return None

    def bic(pair: tuple[JudgedLens, Fit]) -> float:
        judged, fit = pair
        if setting.level.sigma is not None:
            misfit = fit.sum_of_squares / setting.level.sigma**2
        else:
            misfit = 2 * kept.n_points * math.log(max(fit.sum_of_squares, np.finfo(float).tiny))
        return misfit + judged.model.dimension * math.log(kept.n_points)

    fits = [(j, least_squares(j.model, kept, j.fit.x, j.fit.poses)) for j in lenses]
    best, fit = min(fits, key=bic)
    without = replace(setting, data=kept, geometry=Geometry(kept))
    begin, rng = [(fit.x, fit.poses)], np.random.default_rng(0)
    settled = lens_evidence(best.model, begin, without, None, rng, DRAWS)
    return LensEvidence.of(settled, best.model, setting).problem


def _named(found: FreePoint, views: Views) -> GrossError:
    point = views.slices[found.view].start + found.place
    return GrossError(
        point,
        views.names[found.view],
        views.label(point),
        views.place(point),
        found.shift,
        math.exp(found.log_p),
    )
