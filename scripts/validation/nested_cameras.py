"""Evidence of pinholes with Gaussian noise by nested sampling (dynesty), from the prior alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import dynesty
import numpy as np
from scipy.special import ndtri

from bayescal.arrays import Array
from bayescal.cameras.pinhole import POSE
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.prior.amplitudes import tau_bounds

LIVE = 1000
IMPOSSIBLE = -1e100


def nested_evidence(model: GaussianPinhole, seed: int = 1) -> tuple[float, float]:
    """Log evidence and its error by random walks, tau a coordinate."""
    dimension = model.geometry.dimension + (model.geometry.order > 0)
    sampler = dynesty.NestedSampler(
        _likelihood(model), _from_cube(model), dimension, nlive=LIVE, sample="rwalk",
        rstate=np.random.default_rng(seed),
    )  # fmt: skip
    sampler.run_nested(print_progress=False, dlogz=0.05)
    found = sampler.results
    return float(found.logz[-1]), float(found.logzerr[-1])


def _likelihood(model: GaussianPinhole) -> Callable[[Array], float]:
    """Likelihood with both sigmas integrated out, of all coordinates of the geometry."""

    def log_likelihood(theta: Array) -> float:
        if not np.isfinite(theta).all():
            return IMPOSSIBLE
        with np.errstate(all="ignore"):
            residuals, possible = model.residuals(theta[None, : POSE + model.geometry.order])
        value = sum(model.log_marginal(i, model.rss(residuals, i))[0] for i in range(2))
        return float(value) if possible[0] and math.isfinite(value) else IMPOSSIBLE

    return log_likelihood


def _from_cube(model: GaussianPinhole) -> Callable[[Array], Array]:
    """Map the unit cube to all coordinates of the geometry, then tau."""
    prior, geometry = model.prior, model.geometry
    low, high = (math.log(b) for b in tau_bounds(prior.width))

    def transform(u: Array) -> Array:
        z = ndtri(u)
        theta = np.zeros((1, POSE + geometry.order))
        theta[0, 0] = math.log(prior.focal) + prior.focal_log_sd * z[0]
        theta[0, 1] = theta[0, 0] + prior.ratio_log_sd * z[1]
        theta[0, 2:4] = prior.centre + prior.centre_sd * z[2:4]
        theta[0, 4:7] = prior.rotation_sd * z[4:7]
        tau = math.exp(low + (high - low) * u[-1])
        if geometry.order:
            theta[0, POSE:] = tau * prior.width * z[POSE:-1]
        position = prior.position.mean + prior.position.sd * z[7:10]
        all_coordinates = geometry.to_anchor(theta, position)[0]
        return np.append(all_coordinates, tau) if geometry.order else all_coordinates

    return transform
