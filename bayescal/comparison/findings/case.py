"""What findings are looked for in: one axis, its orders judged, and what lies around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bayescal.arrays import Array
from bayescal.comparison.axis import Axis
from bayescal.comparison.goodness import ReferenceSigma
from bayescal.comparison.order_result import OrderResult
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.model import NoiseModel


@dataclass(frozen=True, eq=False)
class Case:
    """One axis, its orders judged, and what lies around it.

    Attributes
    ----------
    axis : Axis
    results : sequence of OrderResult
        Ascending.
    shape : NoiseModel
    reference : ReferenceSigma
    other : Array or None
        The other axis's regressor, ``(n_points,)``.
    depth : Array or None
        z in the camera's frame, ``(n_points,)``, world units.
    groups : tuple of str or None
        Group of each point.
    geometry : tuple of str
        What nobody would mean of points and camera.
    """

    axis: Axis
    results: Sequence[OrderResult]
    shape: NoiseModel
    reference: ReferenceSigma
    other: Array | None = None
    depth: Array | None = None
    groups: tuple[str, ...] | None = None
    geometry: tuple[str, ...] = ()

    @property
    def best(self) -> OrderResult:
        """The most probable order, or the one of lowest BIC where no order has an evidence."""
        return max(
            self.results,
            key=lambda r: (
                -(r.criteria.bic or 0.0) / 2 if r.log_evidence is None else r.log_evidence,
                -r.order,
            ),
        )

    @property
    def gaussian(self) -> bool:
        """Whether the noise is Gaussian, so that its tests apply."""
        return self.shape.name == GAUSSIAN.name
