"""One lens model judged: its fit, the error models it supports, and its evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.reduction import Sums, eliminate_independent, reduce
from bayescal.calibration.fitting.stacking import Poses
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.evidence import adapted, ceiling, height, settled, weighed
from bayescal.calibration.judging.expansion import Expansion, expanded, near
from bayescal.calibration.judging.laplace import Forms, Laplace, Level, constant, degrees, laplace
from bayescal.calibration.model.error_grid import (
    INDEPENDENT,
    Averaged,
    ErrorGrid,
    Node,
    carried_over,
    follow,
)
from bayescal.calibration.model.error_model import Geometry, Shared
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.inference.estimate import EvidenceEstimate

TURNS = 4  # of the most probable error model and its mode at most
NEARLY = 1.0  # nat: nodes looked at before residuals are linearised about the best
AT_ONCE = 2_000_000  # numbers of offsets' precisions: 16 MB
FEWEST = 20  # effective draws: fewer tell nothing
UNMET = "its posterior was not found; the likelihood at its fit bounds its evidence from above"
BEYOND, FEWER = 10.0, 4  # nat below another lens from where on so many times fewer draws are made
KEPT = 64  # normal equations held at a time: up to some MB each


@dataclass(frozen=True, eq=False)
class Setting:
    """What all lens models of a set of views share.

    Attributes
    ----------
    unit : float
        Length on the target that makes 1 px, diagonals (`Geometry.pixel`).
    bow : bool
        Whether the target may bow.
    """

    data: Observations
    geometry: Geometry
    grid: ErrorGrid
    unit: float
    level: Level
    bow: bool

    @classmethod
    def of(cls, data: Observations, level: Level, *, independent: bool) -> Setting:
        """Offer every error model that the data can tell of, or none but independent noise."""
        geometry = Geometry(data)
        grid = ErrorGrid.of(geometry)
        if independent:
            grid = replace(grid, correlated=False, offsets=False)
        bow = data.planar and not independent
        return cls(data, geometry, grid, geometry.pixel, level, bow)

    def model(self, model: LensModel) -> LensModel:
        """Give a lens, told without bow, the bow that its target may have."""
        return model.bowed if self.bow else model

    def problem(self, model: LensModel, x: Array, poses: Poses, node: Node) -> Problem:
        """Put a lens and poses under an error model."""
        return Problem(model, self.data, x, poses, *self._errors(node), self.level)

    def under(self, problem: Problem, node: Node) -> Problem:
        """Put a problem under another error model, linearised as it is."""
        return problem.under(*self._errors(node))

    def _errors(self, node: Node) -> tuple[Shared, Array | None]:
        error = self.grid.error(node)
        return self.geometry.shared(error), self.geometry.offset_root(error, self.unit)


@dataclass(frozen=True, eq=False)
class Weighed:
    """What is found of a lens, and enough to have its evidence again.

    Attributes
    ----------
    x : Array
        Its mode under the most probable error model, ``(dimension,)``.
    """

    errors: Averaged
    x: Array
    poses: Poses
    estimate: EvidenceEstimate
    log_evidence: float


@dataclass(frozen=True, eq=False)
class LensEvidence:
    """A lens model's evidence, averaged over the error models.

    Attributes
    ----------
    problem : Problem
        Under the most probable error model, settled.
    estimate : EvidenceEstimate
        Under that error model.
    log_evidence : float
        Averaged over the error models.
    """

    errors: Averaged
    problem: Problem
    estimate: EvidenceEstimate
    log_evidence: float

    @classmethod
    def of(cls, found: Weighed, model: LensModel, setting: Setting) -> LensEvidence:
        """Put a lens, told without bow, where it was found."""
        problem = setting.problem(setting.model(model), found.x, found.poses, found.errors.nodes[0])
        return cls(found.errors, problem, found.estimate, found.log_evidence)

    @cached_property
    def density(self) -> Problem | Expansion:
        """What draws are made of: the problem's expansion where it is near.

        Found anew for the lens that is drawn: its terms are too large to be kept of all lenses.
        """
        return near(self.problem)


def lens_evidence(
    model: LensModel,
    begin: Sequence[tuple[Array, Poses]],
    setting: Setting,
    like: Averaged | None,
    rng: np.random.Generator,
    draws: int,
    highest: float = -math.inf,
) -> Weighed:
    """Compare the error models under a lens, and weigh the lens under the best of them.

    Parameters
    ----------
    model : LensModel
        Without bow.
    begin : sequence of (Array, Poses)
        Coordinates, with bow or without, and poses of its least squares, and of the modes of
        lenses that it contains: coefficients that cancel each other fit best where the posterior
        is not.
    like : Averaged or None
        Error models of a lens whose residuals are near to those of this one.
    draws : int
        Importance draws; fewer of a lens far below the best.
    highest : float, optional
        Largest log evidence of the lenses before.
    """
    start = setting.grid.starts if like is None else (INDEPENDENT, like.nodes[0])
    node = start[-1]
    reference = settled(max((_at(model, *each, setting, node) for each in begin), key=height))
    comparer = _Comparer(reference, setting)
    errors = None if like is None else carried_over(setting.grid, comparer, like)
    if errors is None:
        for _ in range(TURNS):
            best = follow(setting.grid, comparer, (*start, node), NEARLY).nodes[0]
            if best == node:
                break
            # Once more from where that error model has its mode: residuals were linear elsewhere.
            node, reference = best, settled(setting.under(reference, best))
            comparer = _Comparer(reference, setting)
        errors = follow(setting.grid, comparer, (*start, node))
    if errors.nodes[0] != node:
        reference = settled(setting.under(reference, errors.nodes[0]))
    density, far = expanded(reference), highest - BEYOND
    if errors.log_evidence < far:
        estimate, _, _ = weighed(density, rng, draws // FEWER)
        found = _found(errors, reference, estimate, setting)
        if found.log_evidence < far and math.isfinite(found.estimate.error):
            return found
    estimate, _, _ = weighed(density, rng, draws)
    return _found(errors, reference, estimate, setting)


def sought(found: LensEvidence, setting: Setting, rng: np.random.Generator, draws: int) -> Weighed:
    """Weigh a lens again whose posterior is far from the normal that was taken for it."""
    return _found(found.errors, found.problem, adapted(found.problem, rng, draws), setting)


def _found(
    errors: Averaged, reference: Problem, estimate: EvidenceEstimate, setting: Setting
) -> Weighed:
    """Average over the error models; where hardly a draw met the posterior, bound it."""
    top = ceiling(reference)
    if estimate.log_evidence > top or estimate.effective_fraction * estimate.draws < FEWEST:
        estimate = replace(estimate, log_evidence=top, error=math.inf, warnings=(UNMET,))
        return Weighed(errors, reference.x, reference.poses, estimate, top)
    # What the most probable error model lacks by linear algebra, the others lack too.
    share = math.log(errors.weights[0]) - setting.grid.log_prior(errors.nodes[0])
    total = estimate.log_evidence - share
    return Weighed(errors, reference.x, reference.poses, estimate, total)


def _at(model: LensModel, x: Array, poses: Poses, setting: Setting, node: Node) -> Problem:
    bowed = setting.model(model)
    return setting.problem(bowed, np.pad(x, (0, bowed.dimension - len(x))), poses, node)


class _Comparer:
    """Evidence of error models by linear algebra about one lens and its poses."""

    def __init__(self, reference: Problem, setting: Setting) -> None:
        self.reference, self.setting = reference, setting
        self.sums = lru_cache(maxsize=KEPT)(self._sums)
        self._known: dict[Node, float] = {}

    def _sums(self, correlated: int, length: int) -> tuple[Shared, Sums]:
        geometry, grid = self.setting.geometry, self.setting.grid
        shared = geometry.shared(grid.error((correlated, length, 0, 0)))
        reference = self.reference
        if shared is reference.shared and (reference.root is not None) == grid.offsets:
            views = reference.views
        else:
            views = reduce(reference.stack, self.setting.data, shared, offsets=grid.offsets)
        if not grid.offsets:
            return shared, views.sums
        return shared, views.sums.turned(geometry.directions, geometry.free)

    def __call__(self, nodes: Sequence[Node]) -> list[float]:
        new = [node for node in nodes if node not in self._known]
        for i in range(0, len(new), self._at_once):
            some = new[i : i + self._at_once]
            found = (each.log_evidence for each in self._integrated(some))
            self._known.update(zip(some, found, strict=True))
        return [self._known[node] for node in nodes]

    @property
    def _at_once(self) -> int:
        """Error models whose offsets are eliminated together."""
        if not self.setting.grid.offsets:
            return AT_ONCE
        return max(1, AT_ONCE // len(self.setting.geometry.free) ** 2)

    def _integrated(self, nodes: Sequence[Node]) -> list[Laplace]:
        setting, data = self.setting, self.setting.data
        shared, sums = zip(*(self.sums(*node[:2]) for node in nodes), strict=True)
        sds = np.zeros((len(nodes), 0))
        if setting.grid.offsets:
            errors = map(setting.grid.error, nodes)
            sds = np.array([setting.geometry.offset_sds(e, setting.unit) for e in errors])
        gram, log_det = eliminate_independent(sums, sds)
        fixed = constant(data, log_det, np.array([s.log_det for s in shared]))
        forms = Forms.of(gram, np.full(len(nodes), degrees(data)), fixed)
        # Strengths left out would add nearly the same share to every error model.
        prior = self.reference.likely_strengths
        return laplace(forms, self.reference.x, prior, setting.level)
