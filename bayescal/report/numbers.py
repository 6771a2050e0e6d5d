"""Numbers that documents and views both show, worked out once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.inference.correlation import correlation

if TYPE_CHECKING:  # Gaussian noise on one axis does not pay for what it does not need
    from bayescal.comparison.results import OrderResult
    from bayescal.inference.sampled_posterior import SampledPosterior


@dataclass(frozen=True, eq=False)
class PointChances:
    """What robust noise says of every point.

    Attributes
    ----------
    bad : Array or None
        Posterior probability of being bad, ``(n,)``; None where the noise has no notion of it.
    weight : Array
        Share of a good point's precision that it keeps, ``(n,)``.
    """

    bad: Array | None
    weight: Array


def point_chances(result: OrderResult) -> PointChances | None:
    """Say what robust noise finds of every point; None where the noise is Gaussian."""
    if result.exact is not None:
        return None
    from bayescal.density.robust_linear import RobustLinearModel

    model, full = result.posterior.model, result.posterior.full
    if not isinstance(model, RobustLinearModel):
        return None
    full = full.reshape(-1, full.shape[2])
    return PointChances(model.bad_probability(full), model.weight(full))


def correlations(posterior: SampledPosterior) -> Array:
    """Correlation matrix of a sampled model's parameters, the same on any number of cores."""
    with threadpool_limits(1):
        return correlation(posterior.chain.draws.reshape(-1, len(posterior.names)))
