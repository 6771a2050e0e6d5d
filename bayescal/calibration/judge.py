"""One lens model judged: its fit, the error models it supports, and its evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.density import Problem
from bayescal.calibration.error_grid import Averaged, ErrorGrid, Node, follow
from bayescal.calibration.error_model import Geometry, Shared
from bayescal.calibration.evidence import settled, weighed
from bayescal.calibration.laplace import Level, laplace
from bayescal.calibration.least_squares import Fit, with_bow
from bayescal.calibration.lens_model import LensModel
from bayescal.calibration.observations import Observations
from bayescal.calibration.reduction import Views, eliminate, reduce
from bayescal.calibration.stacking import Poses
from bayescal.calibration.strengths import strengths
from bayescal.inference.estimate import EvidenceEstimate

WHITE: Node = (0, 0, 0, 0)
NEARLY = 1.0  # nat: nodes looked at before residuals are linearised about the best
KEPT_VIEWS = 24  # normal equations held at a time: some MB each
COARSE = 6  # nodes of each strength while error models are compared


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

    def problem(self, model: LensModel, x: Array, poses: Poses, node: Node) -> Problem:
        """Put a lens and poses under an error model."""
        error = self.grid.error(node)
        shared, root = self.geometry.shared(error), self.geometry.offset_root(error, self.unit)
        return Problem(model, self.data, x, poses, shared, root, self.level)


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


def lens_evidence(
    model: LensModel,
    fit: Fit,
    setting: Setting,
    start: tuple[Node, ...],
    rng: np.random.Generator,
    draws: int,
) -> LensEvidence:
    """Compare the error models under a lens, and weigh the lens under the best of them.

    Parameters
    ----------
    model : LensModel
        Without bow.
    fit : Fit
        Its least squares.
    start : tuple of Node
        Error models to begin from.
    """
    bowed, begin = with_bow(fit, model) if setting.bow else (model, fit)
    reference = settled(setting.problem(bowed, begin.x, begin.poses, WHITE))
    comparer = _Comparer(reference, setting)
    errors = follow(setting.grid, comparer, start, NEARLY)
    best = settled(comparer.problem(errors.nodes[0]))
    # Once more from where the best error model has its mode: the residuals were linear elsewhere.
    comparer = _Comparer(best, setting)
    errors = follow(setting.grid, comparer, errors.nodes[:1])
    best = settled(comparer.problem(errors.nodes[0]))
    estimate, _, _ = weighed(best, rng, draws)
    linear = comparer(errors.nodes[0])
    if not math.isfinite(estimate.log_evidence):  # no draw was possible; its warning says so
        estimate = replace(estimate, log_evidence=linear)
    correction = estimate.log_evidence - linear
    return LensEvidence(errors, best, estimate, errors.log_evidence + correction)


class _Comparer:
    """Evidence of error models by linear algebra about one lens and its poses."""

    def __init__(self, reference: Problem, setting: Setting) -> None:
        self.reference, self.setting = reference, setting
        self.prior = strengths(reference.model, COARSE)
        self.views = lru_cache(maxsize=KEPT_VIEWS)(self._views)

    def _views(self, correlated: int, length: int) -> tuple[Shared, Views]:
        shared = self.setting.geometry.shared(self.setting.grid.error((correlated, length, 0, 0)))
        offsets = self.setting.grid.offsets
        return shared, reduce(self.reference.stack, self.setting.data, shared, offsets=offsets)

    def __call__(self, node: Node) -> float:
        shared, views = self.views(node[0], node[1])
        root = self._root(node)
        reduced = eliminate(views, root)
        level = self.setting.level
        data, x = self.setting.data, self.reference.x
        return laplace(reduced, x, data, self.prior, shared.log_det, level).log_evidence

    def _root(self, node: Node) -> Array | None:
        error = self.setting.grid.error(node)
        return self.setting.geometry.offset_root(error, self.setting.unit)

    def problem(self, node: Node) -> Problem:
        """Put the lens under an error model."""
        shared, _ = self.views(node[0], node[1])
        return replace(self.reference, shared=shared, root=self._root(node))
