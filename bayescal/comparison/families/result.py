"""A joint model of r and c, judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.faces.convert import Converts, Held, moments
from bayescal.comparison.judged import Judged

if TYPE_CHECKING:  # the hint in a comparison of orders samples nothing
    from bayescal.comparison.criteria.goodness import GoodnessOfFit
    from bayescal.comparison.criteria.information import Criteria
    from bayescal.density.pinholes.pinhole import PinholeModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.inference.weighting import WeightedDraws
    from bayescal.linear.closed_form import ExactPosterior


@dataclass(frozen=True, eq=False, kw_only=True)
class JointModel(Judged, Converts):
    """One joint model of r and c: what a candidate is judged by, and its likelihood.

    Attributes
    ----------
    criteria : Criteria
        K counts coefficients, inferred sigmas and the position where it is free; n counts points.
        There are no criteria of an exact fit, nor under robust noise, whose likelihood may have
        no maximum (a sigma that shrinks about a few points).
    goodness : GoodnessOfFit or None
        Chi-squared of both axes, where no sigma is inferred.
    position : Array
        Camera position of highest likelihood, of a linear family under robust noise of highest
        posterior density, ``(3,)``, world units.
    position_sd : Array
        Its standard errors that the points alone give; zero where none of the likelihood's is
        known.
    residuals : Array
        Measured less predicted, by least squares at that position, ``(2, n_points)``, px.
    camera : PinholeModel or None
        The density of a pinhole.
    exact : tuple of ExactPosterior
        Of r and of c, at the stated position of a linear family; empty elsewhere.
    posterior : SampledPosterior or None
        Of a model that was sampled: pinholes, a family's best at a free position, and under
        robust noise linear families at the stated one.
    weighted : WeightedDraws or None
        Of a model that has no closed form and was not sampled.
    pixels : Array or None
        Measured, ``(2, n_points)``, px.
    """

    log_evidence: float
    log_evidence_error: float
    criteria: Criteria
    position: Array
    residuals: Array
    position_sd: Array = field(default_factory=lambda: np.zeros(3))
    camera: PinholeModel | None = None
    goodness: GoodnessOfFit | None = None
    exact: tuple[ExactPosterior, ...] = ()
    posterior: SampledPosterior | None = None
    weighted: WeightedDraws | None = None
    pixels: Array | None = None

    @property
    def summaries(self) -> Sequence[Any]:
        """Summaries of the draws, or of the closed forms of r and of c."""
        if self.posterior is not None:
            return self.posterior.parameters
        if self.weighted is not None:
            return moments(self.weighted.model.names, self.weighted.reported)
        from bayescal.comparison.families.exact_parameters import exact_parameters

        return exact_parameters(self.exact)

    def named_covariance(self) -> tuple[tuple[str, ...], Array]:
        """Of the draws, or of the coefficients in closed form."""
        if not self.exact:
            return super().named_covariance()
        from bayescal.comparison.families.exact_parameters import exact_covariance

        return exact_covariance(self.exact)

    def held(self) -> Held:
        """Give draws, densities and data."""
        pixels = self.pixels
        observed = {} if pixels is None else dict(zip(("r", "c"), pixels, strict=True))
        if self.posterior is not None:
            full, model = self.posterior.full, self.posterior.model
            draws, names = self.posterior.chain.draws, self.posterior.names
        elif self.weighted is not None:
            full, model = self.weighted.full[None], self.weighted.model
            draws, names = self.weighted.reported[None], model.names
        else:
            return Held(None, (), None, observed)

        def density() -> Array:
            values = model.log_likelihood(full.reshape(-1, full.shape[2]))
            return np.asarray(values.reshape(*full.shape[:2], -1))

        return Held(draws, names, density, observed)
