"""What findings are looked for in: one axis, its orders judged, and what lies around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.comparison.criteria.goodness import ReferenceSigma
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.result import OrderResult
from bayescal.noise.model import NoiseModel


@dataclass(frozen=True, eq=False)
class Case:
    """One axis, its orders judged, and what lies around it.

    Attributes
    ----------
    results : sequence of OrderResult
        Ascending.
    tests : tuple of AdequacyTest
        Of the best order's residuals, where the noise is Gaussian.
    geometry : tuple of str
        What nobody would mean of points and camera.
    """

    axis: Axis
    results: Sequence[OrderResult]
    shape: NoiseModel
    reference: ReferenceSigma
    tests: tuple[AdequacyTest, ...] = ()
    geometry: tuple[str, ...] = ()

    @property
    def best(self) -> OrderResult:
        """See `best_of`."""
        return best_of(self.results)

    @property
    def gaussian(self) -> bool:
        """Whether the noise is Gaussian, so that its tests apply."""
        return self.shape.conjugate


def best_of(results: Sequence[OrderResult]) -> OrderResult:
    """Give the most probable order, or that of lowest BIC where no order has an evidence."""
    return max(
        results,
        key=lambda r: (
            -(r.criteria.bic or 0.0) / 2 if r.log_evidence is None else r.log_evidence,
            -r.order,
        ),
    )
