"""Evidence of pinholes by nested sampling (dynesty), from their priors alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import dynesty
import numpy as np
from scipy.special import gammaincinv, ndtri

from bayescal.arrays import Array
from bayescal.inference.gaussian_pinhole import GaussianPinhole
from bayescal.inference.pinhole import PinholeModel
from bayescal.models.noise.student_t import RATE, SHAPE
from bayescal.models.pinhole import POSE
from bayescal.models.priors import TAU_BOUNDS

LIVE = 1000
IMPOSSIBLE = -1e100


def nested_evidence(model: PinholeModel, seed: int = 1) -> tuple[float, float]:
    """Log evidence and its error by random walks; tau is a coordinate, as is the robust noise."""
    likelihood = _marginal(model) if isinstance(model, GaussianPinhole) else _with_noise(model)
    noise = 0 if model.gaussian else sum(model.data.inferred) + 2 * model.noise.dimension
    dimension = model.geometry.dimension + (model.geometry.order > 0) + noise
    sampler = dynesty.NestedSampler(
        likelihood, _from_cube(model), dimension, nlive=LIVE, sample="rwalk",
        rstate=np.random.default_rng(seed),
    )  # fmt: skip
    sampler.run_nested(print_progress=False, dlogz=0.05)
    found = sampler.results
    return float(found.logz[-1]), float(found.logzerr[-1])


def _marginal(model: GaussianPinhole) -> Callable[[Array], float]:
    """Likelihood with both sigmas integrated out, of all coordinates of the geometry."""

    def log_likelihood(theta: Array) -> float:
        residuals, possible = _residuals(model, theta)
        value = sum(model.log_marginal(i, model.rss(residuals, i))[0] for i in range(2))
        return float(value) if possible and math.isfinite(value) else IMPOSSIBLE

    return log_likelihood


def _with_noise(model: PinholeModel) -> Callable[[Array], float]:
    """Likelihood under robust noise, whose coordinates come last, r's before c's."""
    share = sum(math.log(level.mass) for level in model.data.levels if level.value is None)

    def log_likelihood(theta: Array) -> float:
        residuals, possible = _residuals(model, theta)
        value, at = share, POSE + model.geometry.order + (model.geometry.order > 0)
        for i, level in enumerate(model.data.levels):
            if level.value is None:
                log_sigma, at = level.log_sigma(theta[at : at + 1]), at + 1
            else:
                log_sigma = np.log([level.value])
            eta = theta[None, at : at + model.noise.dimension]
            at += model.noise.dimension
            sd = model.data.sd[i]
            value += float(model.noise.log_density(residuals[:, i], log_sigma, eta, sd).sum())
        return value if possible and math.isfinite(value) else IMPOSSIBLE

    return log_likelihood


def _residuals(model: PinholeModel, theta: Array) -> tuple[Array, bool]:
    if not np.isfinite(theta).all():
        return np.zeros((1, 2, model.data.n)), False
    with np.errstate(all="ignore"):
        residuals, possible = model.residuals(theta[None, : POSE + model.geometry.order])
    return residuals, bool(possible[0])


def _from_cube(model: PinholeModel) -> Callable[[Array], Array]:
    """Map the unit cube to all coordinates of the geometry, tau, then those of the noise."""
    prior, geometry = model.prior, model.geometry
    low, high = (math.log(b) for b in TAU_BOUNDS)

    def transform(u: Array) -> Array:
        z = ndtri(u)
        theta = np.zeros((1, POSE + geometry.order))
        theta[0, 0] = math.log(prior.focal) + prior.focal_log_sd * z[0]
        theta[0, 1] = theta[0, 0] + prior.ratio_log_sd * z[1]
        theta[0, 2:4] = prior.centre + prior.centre_sd * z[2:4]
        theta[0, 4:7] = prior.rotation_sd * z[4:7]
        after, tau = POSE + geometry.order, []
        if geometry.order:
            tau = [math.exp(low + (high - low) * u[after])]
            theta[0, POSE:] = tau[0] * prior.width * z[POSE:after]
        position = prior.position.mean + prior.position.sd * z[7:10]
        rest = after + len(tau)
        noise = z[rest:]
        if model.noise.name == "student-t":
            # Each axis: the probit of sigma where it is inferred, then ln nu.
            last = np.cumsum([inferred + 1 for inferred in model.data.inferred]) - 1
            noise[last] = np.log(gammaincinv(SHAPE, u[rest:][last]) / RATE)
        return np.concatenate([geometry.to_anchor(theta, position)[0], tau, noise])

    return transform
