"""Numbers that documents and views both show, worked out once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.results import OrderResult
from bayescal.comparison.weak import correlation
from bayescal.inference.posterior import INTERVAL_PROBABILITY
from bayescal.points.setup import AXES

if TYPE_CHECKING:  # Gaussian noise on one axis does not pay for what it does not need
    from bayescal.comparison.families.results import JointModel
    from bayescal.inference.sampled_posterior import SampledPosterior
    from bayescal.linear.closed_form import ExactPosterior


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
    bad = model.bad_probability(full)
    weight = model.weight(full).mean(axis=0)
    return PointChances(None if bad is None else bad.mean(axis=0), weight)


def correlations(posterior: SampledPosterior) -> Array:
    """Correlation matrix of a sampled model's parameters, the same on any number of cores."""
    with threadpool_limits(1):
        return correlation(posterior.chain.draws.reshape(-1, len(posterior.names)))


def covariance(draws: Array) -> Array:
    """Covariance matrix of draws ``(n_chains, n_draws, n_parameters)``, as `correlations`."""
    with threadpool_limits(1):
        return np.atleast_2d(np.cov(draws.reshape(-1, draws.shape[2]), rowvar=False))


@dataclass(frozen=True)
class ExactParameter:
    """A parameter of which the closed form knows all.

    Attributes
    ----------
    name : str
        As of the sampled models: ``alpha_1``, ``sigma_r``.
    interval : tuple of float
        Central, of probability 0.95.
    """

    axis: str
    name: str
    mean: float
    sd: float
    interval: tuple[float, float]


def exact_parameters(model: JointModel) -> list[ExactParameter]:
    """Coefficients and noise of both axes; nothing where there is no closed form."""
    pairs = zip(AXES, model.exact, strict=False)
    return [p for axis, posterior in pairs for p in _of_axis(axis, posterior)]


def joint_covariance(model: JointModel) -> tuple[tuple[str, ...], Array]:
    """Names and covariance of a model's parameters; of its coefficients in closed form."""
    if model.posterior is not None:
        return model.posterior.names, covariance(model.posterior.chain.draws)
    roots = [found.model.factors.monomials.apply(found.root) for found in model.exact]
    names = [n for found in model.exact for n in found.model.names[: found.model.size]]
    return tuple(names), block_diag(*(root @ root.T for root in roots))


@lru_cache(maxsize=64)  # pairs of orders share their axes, and intervals take a while
def _of_axis(axis: str, posterior: ExactPosterior) -> tuple[ExactParameter, ...]:
    out = []
    numbers = zip(*posterior.summary, posterior.intervals(INTERVAL_PROBABILITY), strict=True)
    for name, (mean, sd, (low, high)) in zip(posterior.model.names, numbers, strict=True):
        own = name.split("_")[0] == posterior.model.symbol
        named, interval = name if own else f"{name}_{axis}", (float(low), float(high))
        out.append(ExactParameter(axis, named, float(mean), float(sd), interval))
    return tuple(out)
