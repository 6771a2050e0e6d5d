"""The sweep through lenses: which are candidates, each fitted from those it contains."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import Fit, carried, least_squares
from bayescal.calibration.fitting.stacking import Poses
from bayescal.calibration.fitting.start import start_fit
from bayescal.calibration.fitting.view_levels import view_levels
from bayescal.calibration.judging.bad_points import marked
from bayescal.calibration.judging.judge import Setting
from bayescal.calibration.judging.laplace import Level
from bayescal.calibration.model.error_grid import Averaged
from bayescal.calibration.model.error_model import Geometry
from bayescal.calibration.model.lens_model import SHAPE, LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.comparison.lenses.bad.mixture import Marks, Mixing, first_set
from bayescal.comparison.lenses.candidates import (
    LARGEST_FISHEYE,
    LARGEST_RADIAL,
    SURE_FISHEYE,
    SURE_RADIAL,
    Candidate,
    LensKey,
    fisheye_candidate,
    named_candidates,
    other_candidates,
    radial_candidates,
    rational_candidate,
)
from bayescal.comparison.lenses.fitted import FittedLens
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.store import Once, now
from bayescal.points.views.views import Views

FLEXIBLE = ("radial 3 + p", "fisheye 3")  # lenses that show how noisy views are
WORSE = 1e-9  # relative: a nested fit worse than its sub-model's by this is a failure
FAR = 1.2  # times the residuals of a flexible lens: a fit that leaves more is begun anew


class Sweep:
    """Fits of lenses, each begun from those it contains: iterated, the candidates to judge.

    Which candidates follow depends on what has been said of those before: each must be judged
    before the next is asked for.

    Parameters
    ----------
    level : Level
        What is known of sigma.
    once : callable, optional
        Has what takes long from where it is kept.
    bad : tuple of int, optional
        Places of bad points, without which lenses are judged, where there may be such; found by
        flexible lenses by default.
    tag : str, optional
        Told to what is kept, where lenses are judged again.

    Attributes
    ----------
    setting : Setting
        What all lenses share.
    bad : tuple of int
        Places of the points without which lenses are judged.
    mixing : Mixing or None
        The same of all points, where some may be bad.
    impossible : list of str
        Lenses that can't see some point.
    failures : list of str
        Lenses whose fit stayed worse than that of one they contain.
    """

    def __init__(
        self,
        views: Views,
        request: LensRequest,
        level: Level,
        once: Once = now,
        bad: tuple[int, ...] | None = None,
        tag: str = "",
    ) -> None:
        self.request, self._once, self._tag = request, once, tag
        self.data = Observations.from_views(views, image_size(views))
        if request.mixture and bad is None:
            bad = once("bad points", tuple[int, ...], partial(self._first_bad, level))
        self.bad = bad or ()
        points = marked(self.bad, self.data.which.shape)
        if request.per_view:
            levels = once(f"noise of views{tag}", Array, partial(self._levels, points))
            self.data = self.data.with_levels(levels)
        whole, kept = self.data, self.data.without(points) if self.bad else self.data
        self.setting = Setting.of(kept, level, independent=request.independent)
        self.mixing: Mixing | None = None
        if request.mixture:
            every = replace(self.setting, data=whole, geometry=Geometry(whole))
            self.mixing = Mixing(every, points)
        self.data = kept
        self.impossible: list[str] = []
        self.failures: list[str] = []
        self._fits: dict[str, tuple[LensModel, Fit]] = {}
        self._found: dict[str, JudgedLens] = {}

    def _levels(self, points: Marks) -> Array:
        return view_levels(self.data.without(points), self._models(FLEXIBLE))

    def _first_bad(self, level: Level) -> tuple[int, ...]:
        """Find bad points by lenses that have terms enough; the noise of views without them."""
        models, data = self._models(FLEXIBLE), self.data
        points = marked((), data.which.shape)
        for levelled in (False, True)[: 1 + self.request.per_view]:
            if levelled:
                data = data.with_levels(self._levels(points))
            whole = Setting.of(data, level, independent=self.request.independent)
            points = first_set(models, whole, points)
        return tuple(np.flatnonzero(points).tolist())

    def _models(self, names: Sequence[str]) -> list[LensModel]:
        return [self._model(candidate) for candidate in named_candidates(names)]

    def _model(self, candidate: Candidate) -> LensModel:
        request = self.request
        return candidate.model(self.data.size, square=request.square, centred=request.centred)

    def __iter__(self) -> Iterator[FittedLens]:
        """Go through what is asked for, or through the families while their evidence rises."""
        if self.request.lenses is not None:
            yield from self._fitted(named_candidates(self.request.lenses))
            return
        yield from self._rising(radial_candidates, SURE_RADIAL, LARGEST_RADIAL)
        yield from self._rising(
            lambda order: [fisheye_candidate(order)], SURE_FISHEYE, LARGEST_FISHEYE
        )
        if "radial 3 + p" in self._fits:
            yield from self._fitted([rational_candidate()])
        yield from self._fitted(other_candidates())

    def _rising(
        self, of_order: Callable[[int], Sequence[Candidate]], sure: int, most: int
    ) -> Iterator[FittedLens]:
        best = -math.inf
        for order in range(most + 1):
            candidates = of_order(order)
            yield from self._fitted(candidates)
            top = max(self._evidence(c.name) for c in candidates)
            if order > sure and top <= best:
                break
            best = max(best, top)

    def _fitted(self, candidates: Iterable[Candidate]) -> Iterator[FittedLens]:
        """Fit candidates, leaving out those that can't see some point."""
        for candidate in candidates:
            model = self._model(candidate)
            below = self._below(candidate, model)
            lowest = min((f.sum_of_squares for f in below), default=math.inf) * (1 + WORSE)
            name = f"{LensKey(name=candidate.name).file()} fit{self._tag}"
            fit = self._once(name, Fit, partial(self._fit, model, below, lowest))
            if fit.sum_of_squares > lowest:
                self.failures.append(candidate.name)
            if not math.isfinite(fit.sum_of_squares):
                self.impossible.append(candidate.name)
                continue
            self._fits[candidate.name] = model, fit
            yield FittedLens(
                candidate,
                model,
                fit,
                tuple(self._modes(candidate, model)),
                self.setting,
                self._like(fit),
                self.request.draws,
                self._highest,
                self.mixing,
                self._tag,
                self._judged,
            )

    def _judged(self, found: JudgedLens) -> None:
        self._found[found.name] = found

    def _evidence(self, name: str) -> float:
        """Log evidence of a lens; -inf where its posterior was not found."""
        found = self._found.get(name)
        met = found is not None and math.isfinite(found.log_evidence_error)
        return found.log_evidence if found is not None and met else -math.inf

    @property
    def _highest(self) -> float:
        """Largest log evidence so far, bad points apart."""
        found = (j.evidence for j in self._found.values())
        met = (e.log_evidence for e in found if math.isfinite(e.estimate.error))
        return max(met, default=-math.inf)

    def _parents(self, candidate: Candidate) -> list[JudgedLens]:
        """Lenses that a lens contains, the likeliest first."""
        known = [self._found[name] for name in candidate.parents if name in self._found]
        return sorted(known, key=lambda j: -self._evidence(j.name))

    def _modes(self, candidate: Candidate, model: LensModel) -> Iterator[tuple[Array, Poses]]:
        for parent in self._parents(candidate):
            mode = parent.evidence.problem
            yield carried(mode.model, mode.x, self.setting.model(model)), mode.poses

    def _like(self, fit: Fit) -> Averaged | None:
        """Error models of the lens whose residuals are nearest: what makes them is the same."""

        def apart(found: JudgedLens) -> float:
            return abs(found.fit.sum_of_squares - fit.sum_of_squares)

        nearest = min(self._found.values(), key=apart, default=None)
        return None if nearest is None else nearest.evidence.errors

    def _below(self, candidate: Candidate, model: LensModel) -> tuple[Fit, ...]:
        """Fits of the lenses that a lens contains, in its coordinates."""
        found = [self._fits[name] for name in candidate.parents if name in self._fits]
        return tuple(replace(fit, x=carried(old, fit.x, model)) for old, fit in found)

    def _fit(self, model: LensModel, below: Sequence[Fit], lowest: float) -> Fit:
        """Least squares from every sub-model's fit; begun anew where that leaves much.

        A lens without sub-models begins from the poses of the flexible lens that fits best.
        """
        begin = [(fit.x, fit.poses) for fit in below] or [self._placed(model)]
        tried = [least_squares(model, self.data, *each) for each in begin]
        found = min((f.sum_of_squares for f in tried), default=math.inf)
        # A lens without coefficients, placed by one that has them, has nowhere else to go.
        # One with a shape has a curved valley: its own start may lead to a lower place.
        local = SHAPE in model.lens.groups or (bool(model.lens.names) and self._far(found))
        if not math.isfinite(found) or found > lowest or local:
            tried.extend(self._anew(model))
        return min(tried, key=lambda f: f.sum_of_squares)

    def _placed(self, model: LensModel) -> tuple[Array, Poses]:
        """Coordinates and poses of a lens at its start, placed as a flexible one."""
        flexible, fit = min(self._flexible, key=lambda pair: pair[1].sum_of_squares)
        intrinsics, _, _ = flexible.physical(fit.x)
        return model.coordinates(intrinsics, np.array(model.lens.start)), fit.poses

    def _far(self, sum_of_squares: float) -> bool:
        """Whether a fit leaves so much that it may be of a local optimum."""
        least = min(fit.sum_of_squares for _, fit in self._flexible)
        return sum_of_squares > FAR**2 * least

    def _anew(self, model: LensModel) -> Iterator[Fit]:
        """Fits from nothing: of the lens, and from flexible ones that contain it.

        Where a coefficient may not grow, since the lens would fold, others lead around.
        """
        yield start_fit(model, self.data)
        for larger, fit in self._flexible:
            if set(model.lens.names) < set(larger.lens.names) and math.isfinite(fit.sum_of_squares):
                x = carried(larger, fit.x, model)
                yield least_squares(model, self.data, x, fit.poses)

    @cached_property
    def _flexible(self) -> list[tuple[LensModel, Fit]]:
        return [(m, start_fit(m, self.data)) for m in self._models(FLEXIBLE)]


def image_size(views: Views) -> tuple[float, float]:
    """Size of the image, px; where it is not known, from where the points are."""
    if views.image_size is not None:
        width, height = views.image_size
        return float(width), float(height)
    low, high = views.pixels.min(axis=0), views.pixels.max(axis=0)
    # Points spread over an image leave about the same margin on both sides.
    width, height = (math.ceil(v) for v in low.clip(0) + high + 1)
    return float(width), float(height)


def size_notes(views: Views) -> tuple[str, ...]:
    """Say that the size of the image had to be assumed, where it had."""
    if views.image_size is not None:
        return ()
    width, height = image_size(views)
    return (f"{width:g} by {height:g} px is assumed, from where the points are",)
