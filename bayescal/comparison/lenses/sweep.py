"""Candidates judged, each from the fits of those it contains, and the sweep through them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from bayescal.calibration.error_grid import ErrorGrid, Node
from bayescal.calibration.error_model import Geometry
from bayescal.calibration.judge import LensEvidence, Setting, length_of_pixel, lens_evidence
from bayescal.calibration.laplace import Level
from bayescal.calibration.least_squares import Fit, carried, least_squares, rms
from bayescal.calibration.lens_model import LensModel
from bayescal.calibration.observations import Observations
from bayescal.calibration.start import start_fit
from bayescal.comparison.lenses.candidates import (
    LARGEST_FISHEYE,
    LARGEST_RADIAL,
    SURE_FISHEYE,
    SURE_RADIAL,
    Candidate,
    fisheye_candidate,
    named_candidates,
    other_candidates,
    radial_candidates,
    rational_candidate,
)
from bayescal.comparison.lenses.results import JudgedLens, Request
from bayescal.errors import InputError
from bayescal.points.views.views import Views

WORSE = 1e-9  # relative: a nested fit worse than its sub-model's by this is a failure
FIRST: tuple[Node, ...] = ((0, 0, 0, 0), (3, 3, 3, 3))


Progress = Callable[[str], None]


class Judge:
    """Judges candidates, each from the fits of those it contains.

    Parameters
    ----------
    views : Views
    size : tuple of float
        Of the image, px.
    request : Request
    progress : callable
        Called with the key of each candidate that is begun.
    """

    def __init__(
        self, views: Views, size: tuple[float, float], request: Request, progress: Progress
    ) -> None:
        self.request, self.size, self.progress = request, size, progress
        self.data = Observations.from_views(views, size)
        self.judged: dict[str, JudgedLens] = {}
        self.impossible: list[str] = []
        self.failures: list[str] = []
        self.nodes = FIRST
        self._setting: Setting | None = None
        self._fits: dict[str, tuple[LensModel, Fit]] = {}
        self.rng = np.random.default_rng(request.seed)

    def setting(self) -> Setting:
        """Give what all share; the length of a pixel on the target comes from the first lens."""
        if self._setting is None:
            raise InputError("calibrate: no lens can see all points of these views")
        return self._setting

    def judge(self, candidate: Candidate) -> JudgedLens | None:
        """Judge a candidate; None where it can't see some point."""
        if candidate.key in self.judged:
            return self.judged[candidate.key]
        self.progress(candidate.key)
        request = self.request
        model = candidate.model(self.size, square=request.square, centred=request.centred)
        fit = self._fit(candidate, model)
        if not math.isfinite(fit.sum_of_squares):
            self.impossible.append(candidate.key)
            return None
        self._fits[candidate.key] = model, fit
        if self._setting is None:
            self._begin(model, fit)
        setting = self.setting()
        evidence = lens_evidence(
            model, fit, setting, self.nodes, self.rng.spawn(1)[0], request.draws
        )
        self.nodes = tuple(dict.fromkeys((*FIRST[:1], *evidence.errors.nodes[:1])))
        found = self._row(candidate, model, fit, evidence)
        self.judged[candidate.key] = found
        return found

    def _row(
        self, candidate: Candidate, model: LensModel, fit: Fit, evidence: LensEvidence
    ) -> JudgedLens:
        """Put the least-squares fit's criteria beside the evidence."""
        sigma, data = self.request.sigma, self.data
        n, k = data.n_points, model.dimension + 6 * data.n_views
        chi2 = None
        if sigma is not None:
            chi2 = fit.sum_of_squares / sigma**2
            log_likelihood = -0.5 * chi2 - 2 * n * math.log(sigma)
        else:
            k += 1
            log_likelihood = -n * (math.log(fit.sum_of_squares / (2 * n)) + 1)
        log_likelihood += data.log_weight - n * math.log(2 * math.pi)
        aic, bic = (-2 * log_likelihood + k * each for each in (2, math.log(n)))
        spread = rms(data, fit.sum_of_squares)
        return JudgedLens(candidate, model, fit, spread, k, chi2, aic, bic, evidence)

    def _begin(self, model: LensModel, fit: Fit) -> None:
        geometry = Geometry(self.data)
        independent = self.request.independent
        grid = ErrorGrid.of(geometry)
        if independent:
            grid = replace(grid, correlated=False, offsets=False)
            self.nodes = FIRST[:1]
        elif not grid.offsets:
            self.nodes = (FIRST[0], (3, 3, 0, 0))
        unit = length_of_pixel(model, self.data, fit)
        bow = self.data.planar and not independent
        self._setting = Setting(self.data, geometry, grid, unit, Level(self.request.sigma), bow)

    def _fit(self, candidate: Candidate, model: LensModel) -> Fit:
        """Least squares from every sub-model's fit, or from nothing where there is none."""
        tried: list[Fit] = []
        below: list[Fit] = []
        for key in candidate.parents:
            if key not in self._fits:
                continue
            old, fit = self._fits[key]
            below.append(fit)
            tried.append(least_squares(model, self.data, carried(old, fit.x, model), fit.poses))
        if not tried or not math.isfinite(min(f.sum_of_squares for f in tried)):
            tried.append(start_fit(model, self.data))
        best = min(tried, key=lambda f: f.sum_of_squares)
        lowest = min((f.sum_of_squares for f in below), default=math.inf)
        if best.sum_of_squares > lowest * (1 + WORSE):
            again = start_fit(model, self.data)
            best = min(best, again, key=lambda f: f.sum_of_squares)
            if best.sum_of_squares > lowest * (1 + WORSE):
                self.failures.append(candidate.key)
        return best

    def sweep(self) -> None:
        """Judge what is asked for, or go through the families while their evidence rises."""
        if self.request.lenses is not None:
            for candidate in named_candidates(self.request.lenses):
                self.judge(candidate)
            return
        self._rising(radial_candidates, SURE_RADIAL, LARGEST_RADIAL)
        self._rising(lambda order: [fisheye_candidate(order)], SURE_FISHEYE, LARGEST_FISHEYE)
        if "radial 3 + p" in self._fits:
            self.judge(rational_candidate())
        for candidate in other_candidates():
            self.judge(candidate)

    def _rising(self, of_order: Callable[[int], Sequence[Candidate]], sure: int, most: int) -> None:
        best = -math.inf
        for order in range(most + 1):
            found = [self.judge(candidate) for candidate in of_order(order)]
            values = [f.evidence.log_evidence for f in found if f is not None]
            top = max(values, default=-math.inf)
            if order > sure and top <= best:
                break
            best = max(best, top)


def image_size(views: Views) -> tuple[tuple[float, float], tuple[str, ...]]:
    """Size of the image, px, and a note where it had to be assumed."""
    if views.width is not None and views.height is not None:
        return (float(views.width), float(views.height)), ()
    low, high = views.pixels.min(axis=0), views.pixels.max(axis=0)
    # Points spread over an image leave about the same margin on both sides.
    width, height = (math.ceil(v) for v in low.clip(0) + high + 1)
    note = f"{width} by {height} px is assumed, from where the points are"
    return (float(width), float(height)), (note,)
