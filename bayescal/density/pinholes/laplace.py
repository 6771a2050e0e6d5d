r"""Laplace approximation of a pinhole's posterior at a given strength of the distortion.

Gauss-Newton; the normal priors are further residuals, their slopes by complex step. With sigma
integrated out the likelihood is rss^(-n/2), whose slope is that of a normal one with
sigma^2 = rss / n: each step takes sigma from the residuals, within the bounds of its prior,
below which residuals without noise would make the normal far narrower than the posterior.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array, frozen
from bayescal.cameras.pinhole import POSE, PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.density.robust_fits import LinearPixels
from bayescal.inference.optimum import ascend
from bayescal.prior.camera import PinholePrior

MOST_STEPS = 60
HALVINGS = 12
SETTLED = 1e-8  # nat that a step gains
STEP = 1e-30


@dataclass(frozen=True, eq=False)
class Normal:
    """A normal approximation in free coordinates.

    Attributes
    ----------
    mean : Array
        ``(dimension,)``.
    root : Array
        Lower Cholesky root of the covariance, ``(dimension, dimension)``.
    """

    mean: Array
    root: Array

    def at(self, x: Array) -> Array:
        """Free coordinates of whitened ones, ``(..., dimension)``."""
        return np.asarray(self.mean + x @ self.root.T)

    def whitened(self, free: Array) -> Array:
        """Whitened coordinates of free ones, ``(..., dimension)``; inverse of `at`."""
        return np.asarray(solve_triangular(self.root, (free - self.mean).T, lower=True).T)


def laplace(
    geometry: PinholeGeometry, prior: PinholePrior, data: JointData, start: Array, tau: float
) -> Normal:
    """Climb the posterior at a strength `tau`, from free coordinates ``(dimension,)``."""

    def step(free: Array) -> Array:
        slope, precision = _slope(geometry, prior, data, free, tau)
        return np.linalg.solve(precision, slope)

    free, _ = ascend(
        lambda free: _value(geometry, prior, data, free, tau),
        step,
        start,
        most=MOST_STEPS,
        halvings=HALVINGS,
        settled=SETTLED,
    )
    _, precision = _slope(geometry, prior, data, free, tau)
    return Normal(frozen(free), frozen(_root_of_inverse(precision)))


def likely_start(
    geometry: PinholeGeometry, prior: PinholePrior, data: JointData, fitted: Array, tau: float
) -> Array:
    """Where to climb from: the fit, or the prior's own camera where that is more probable.

    A pinhole that can't follow the pixels may fit best with a focal length of nothing, at
    which no posterior can be climbed.
    """
    theta = np.zeros((1, POSE + geometry.order))
    theta[0, :2], theta[0, 2:4] = math.log(prior.focal), prior.centre
    expected = geometry.free(geometry.to_anchor(theta, prior.position.mean))[0]
    values = [_value(geometry, prior, data, free, tau) for free in (fitted, expected)]
    return expected if values[1] > values[0] else fitted


def linear_pixels(geometry: PinholeGeometry, data: JointData, frame: Normal) -> LinearPixels:
    """Linearise pixels at a frame, in whitened coordinates: their posterior is standard normal."""
    pixels, slopes = geometry.project_with_jacobian(frame.mean)
    residuals, slopes = data.pixels - pixels, slopes @ frame.root
    d = slopes.shape[2]
    flat = LinearPixels(
        residuals, slopes, np.zeros(d), np.zeros((d, d)), data.deviations, data.levels
    )
    slope, gram = flat.normal(flat.plain)
    return replace(flat, prior_slope=-slope, prior_precision=np.eye(d) - gram)


def _value(
    geometry: PinholeGeometry, prior: PinholePrior, data: JointData, free: Array, tau: float
) -> float:
    with np.errstate(all="ignore"):
        theta = geometry.full(free[None])
        pixels, depth = geometry.project(theta)
        rss = (((data.pixels - pixels[0]) / data.deviations) ** 2).sum(axis=1)
        z, tilt = _prior_residuals(geometry, prior, theta, tau)
        value = data.bounded_log_likelihood(rss) - float(z[0] @ z[0]) / 2 + float(tilt[0])
    return value if math.isfinite(value) and bool((depth > 0).all()) else -math.inf


def _slope(
    geometry: PinholeGeometry, prior: PinholePrior, data: JointData, free: Array, tau: float
) -> tuple[Array, Array]:
    """Slope of the log posterior, and Gauss-Newton's precision."""
    theta = geometry.full(np.concatenate([free[None], free + STEP * 1j * np.eye(len(free))]))
    pixels, slopes = geometry.project_with_jacobian(free)
    residual = (data.pixels - pixels) / data.deviations
    rss = (residual**2).sum(axis=1)
    sigma = data.bounded_sigma(rss)[:, None]
    weight = 1 / (sigma * data.deviations)
    jacobian = np.moveaxis(slopes * weight[..., None], 2, 0).reshape(len(free), -1)
    z, tilt = _prior_residuals(geometry, prior, theta, tau)
    prior_jacobian = z[1:].imag / STEP
    misfit = (residual / sigma).ravel()
    slope = jacobian @ misfit - prior_jacobian @ z[0].real + tilt[1:].imag / STEP
    return slope, jacobian @ jacobian.T + prior_jacobian @ prior_jacobian.T


def _prior_residuals(
    geometry: PinholeGeometry, prior: PinholePrior, theta: Array, tau: float
) -> tuple[Array, Array]:
    """Standardised deviations from the prior's means, and the log volume of the coordinates."""
    parts = [
        (theta[:, :1] - math.log(prior.focal)) / prior.focal_log_sd,
        (theta[:, 1:2] - theta[:, :1]) / prior.ratio_log_sd,
        (theta[:, 2:4] - prior.centre) / prior.centre_sd,
        theta[:, 4:7] / prior.rotation_sd,
        theta[:, POSE:] / (tau * prior.width),
    ]
    tilt = np.zeros_like(theta[:, 0])
    if geometry.fixed is None:
        parts.append((geometry.position(theta) - prior.position.mean) / prior.position.sd)
        tilt = geometry.log_volume(theta)
    return np.concatenate(parts, axis=1), tilt


def _root_of_inverse(precision: Array) -> Array:
    """Lower root of the inverse of a positive definite matrix."""
    scale = 1 / np.sqrt(np.diag(precision))
    upper = np.linalg.cholesky((precision * scale * scale[:, None])[::-1, ::-1])[::-1, ::-1]
    # precision = upper upper' with upper upper-triangular: its inverse's root is lower.
    inverse = solve_triangular(upper, np.eye(len(scale))).T
    return np.asarray(scale[:, None] * inverse)
