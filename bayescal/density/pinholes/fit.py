"""Maximum likelihood of a pinhole by non-linear least squares (thesis eq. 30-32).

scipy's Levenberg-Marquardt (MINPACK) from linear starts, so that no guess is asked for;
where the noise levels are inferred, each axis is weighted by the level its residuals have.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from bayescal.arrays import Array, frozen
from bayescal.cameras.direct_linear import FLAT, direct_linear, flatness
from bayescal.cameras.pinhole import POSE, PinholeGeometry
from bayescal.cameras.pose import rotation_vectors
from bayescal.density.joint_data import JointData
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.prior.camera import PinholePrior

# A climb that takes more creeps along a valley, of a lens that folds its image for one.
MOST_ROUNDS, MOST_EVALUATIONS = 30, 200
# While the levels move and at the end: tolerances of a fit at given levels, and of ln L, relative.
STAGES = ((1e-2, 1e-6), (1e-14, 1e-12))
# ln L by which a mirrored world must fit better to say that an axis is mirrored.
MIRRORED = 10.0
BEHIND = 1e8  # residual of a point without an image, in sigmas


@dataclass(frozen=True, eq=False)
class PinholeFit:
    """A pinhole's maximum likelihood.

    Attributes
    ----------
    free : Array
        Free coordinates, ``(dimension,)``.
    residuals : Array
        Measured less predicted, ``(2, n_points)``, px.
    rss : Array
        Weighted sum of squares of each axis, ``(2,)``.
    sigma : Array
        Noise level of each axis there, ``(2,)``.
    log_likelihood : float
        Maximised, with every constant.
    covariance : Array
        Of the free coordinates, at these noise levels, ``(dimension, dimension)``.
    """

    free: Array
    residuals: Array
    rss: Array
    sigma: Array
    log_likelihood: float
    covariance: Array


def fit_pinhole(
    points: Correspondences, geometry: PinholeGeometry, prior: PinholePrior, data: JointData
) -> PinholeFit:
    """Fit a pinhole to pixels.

    Parameters
    ----------
    points : Correspondences
        For messages.
    prior : PinholePrior
        Says where a start may be taken from; not part of the likelihood.

    Raises
    ------
    InputError
        Where the points are too few or coplanar, lie behind the camera that fits best, or
        are the image of a mirrored world.
    """
    _check_determined(points, geometry)
    fits = [f for s in _starts(geometry, prior, data) if (f := _climb(geometry, data, s))]
    if not fits:
        raise InputError(
            f"{points.source}: no pinhole has these points in front of it; check the camera "
            "position and orientation of the setup, and whether z points forward"
        )
    best = max(fits, key=lambda f: f.log_likelihood)
    _check_handedness(points, geometry, prior, data, best)
    return best


def _check_determined(points: Correspondences, geometry: PinholeGeometry) -> None:
    n, p = len(points), geometry.dimension
    if 2 * n < p + 2:
        raise InputError(
            f"{points.source}: a pinhole of order {geometry.order} has {p} parameters for "
            f"{2 * n} pixel values; it needs {(p + 3) // 2} points at least"
        )
    if geometry.fixed is None and flatness(points.world) < FLAT:
        raise InputError(
            f"{points.source}: the points lie in one plane, from which pose and focal length "
            "can't be told apart; add points off the plane, or hold the position: --position stated"
        )


def _starts(geometry: PinholeGeometry, prior: PinholePrior, data: JointData) -> list[Array]:
    """Start from the linear camera, and from the prior's pose with its best optics."""
    out = []
    camera = direct_linear(geometry.world, data.pixels.T)
    if camera is not None and not camera.mirrored:
        theta = np.zeros((1, POSE + geometry.order))
        theta[0, :2], theta[0, 2:4] = np.log(camera.focal), camera.centre
        theta[0, 4:7] = rotation_vectors(camera.rotation @ geometry.orientation.T)
        position = camera.position if geometry.fixed is None else geometry.fixed
        out.append(geometry.to_anchor(theta, position))
    theta = np.zeros((1, POSE + geometry.order))
    local = (geometry.world - prior.position.mean) @ geometry.orientation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        image = local[:, :2] / local[:, 2:]
    if (local[:, 2] > 0).all():
        for i in (0, 1):
            slope, centre = np.polynomial.polynomial.polyfit(image[:, i], data.pixels[i], 1)[::-1]
            theta[0, i] = math.log(slope) if slope > 0 else math.log(prior.focal)
            theta[0, 2 + i] = centre
        out.append(geometry.to_anchor(theta, prior.position.mean))
    return [geometry.free(t)[0] for t in out if np.isfinite(t).all()]


def _climb(geometry: PinholeGeometry, data: JointData, start: Array) -> PinholeFit | None:
    """Climb the likelihood, the axes weighted by their levels until these settle.

    Each axis is weighted by its own residuals from the start on: equal weights can lead from a
    good start to a lesser mode, which follows the worse axis at the other's cost.
    """
    found = _residuals(geometry, data, start)
    sigma = np.ones(2) if found is None else data.likely_sigma(_squares(data, found))
    free, last = start, -math.inf
    stages = iter(STAGES)
    inner, outer = next(stages)
    for _ in range(MOST_ROUNDS):
        weight = 1 / (sigma[:, None] * data.deviations)
        free = _minimise(geometry, data.pixels, weight, free, inner)
        found = _residuals(geometry, data, free)
        if found is None:
            return None
        residuals = found
        rss = _squares(data, residuals)
        sigma, likelihood = data.likely_sigma(rss), data.log_likelihood(rss)
        if likelihood - last <= outer * abs(likelihood):
            stage = next(stages, None)
            if stage is None:
                break
            inner, outer = stage
        last = likelihood
    jacobian = geometry.jacobian(free) / (sigma[:, None] * data.deviations)[:, :, None]
    return PinholeFit(
        frozen(free),
        frozen(residuals),
        frozen(rss),
        frozen(sigma),
        likelihood,
        frozen(_inverse_gram(jacobian.reshape(-1, geometry.dimension))),
    )


def _residuals(geometry: PinholeGeometry, data: JointData, free: Array) -> Array | None:
    """Measured less predicted, ``(2, n_points)``, px; None where a point has no image."""
    with np.errstate(all="ignore"):
        pixels, depth = geometry.project(geometry.full(free[None]))
    if not ((depth > 0).all() and np.isfinite(pixels).all()):
        return None
    return np.asarray(data.pixels - pixels[0])


def _squares(data: JointData, residuals: Array) -> Array:
    """Weighted sum of squares of each axis, ``(2,)``."""
    return np.asarray(((residuals / data.deviations) ** 2).sum(axis=1))


def _minimise(
    geometry: PinholeGeometry, t: Array, weight: Array, start: Array, tolerance: float
) -> Array:
    def residuals(free: Array) -> Array:
        with np.errstate(all="ignore"):
            pixels, depth = geometry.project(geometry.full(free[None]))
            misfit = np.where(depth > 0, (pixels[0] - t) * weight, BEHIND)
        return np.nan_to_num(misfit, nan=BEHIND, posinf=BEHIND, neginf=-BEHIND).ravel()

    def jacobian(free: Array) -> Array:
        with np.errstate(all="ignore"):
            slopes = geometry.jacobian(free) * weight[:, :, None]
        return np.nan_to_num(slopes, posinf=0.0, neginf=0.0).reshape(-1, geometry.dimension)

    found = least_squares(
        residuals, start, jacobian, method="lm", x_scale="jac",
        xtol=tolerance, ftol=tolerance, gtol=tolerance, max_nfev=MOST_EVALUATIONS,
    )  # fmt: skip
    return np.asarray(found.x)


def _inverse_gram(jacobian: Array) -> Array:
    """(J'J)^-1 by the singular values of J with its columns scaled to unit length."""
    norms = np.linalg.norm(jacobian, axis=0)
    norms[norms == 0] = 1
    _, d, vt = np.linalg.svd(jacobian / norms, full_matrices=False)
    d = np.maximum(d, np.finfo(float).eps * d[0])
    root = vt.T / d / norms[:, None]
    return np.asarray(root @ root.T)


def _check_handedness(
    points: Correspondences,
    geometry: PinholeGeometry,
    prior: PinholePrior,
    data: JointData,
    best: PinholeFit,
) -> None:
    """Refuse an image that no rotation makes, but one of the mirrored world does."""
    camera = direct_linear(geometry.world, data.pixels.T)
    if camera is None or not camera.mirrored:
        return
    mirrored = JointData(np.array([[1.0], [-1.0]]) * data.pixels, data.sd, data.levels)
    fits = [f for s in _starts(geometry, prior, mirrored) if (f := _climb(geometry, mirrored, s))]
    gain = max((f.log_likelihood for f in fits), default=-math.inf) - best.log_likelihood
    if gain > MIRRORED:
        raise InputError(
            f"{points.source}: the pixels are those of a mirrored world (ln L higher by {gain:.0f} "
            f"with {AXES[1]} turned over): count c from the other end (c_from_bottom), swap or "
            "negate a world axis, or swap the columns r and c"
        )
