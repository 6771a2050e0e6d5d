r"""Maximum likelihood of a pinhole by non-linear least squares (thesis eq. 30-32).

Levenberg-Marquardt from linear starts, so that no guess is asked for. Where an axis's level is
inferred it is eliminated: with Q the axis's sum of squares, e its residuals and J their slopes in
units of the level that they have, ln L falls by n/2 ln Q, whose slope is J'e and whose curvature,
second derivatives of the residuals apart, is J'J - 2/n (J'e)(J'e)'. To weigh the axes in turn with
fits at given weights, which leaves the last term out, takes five to ten times as many evaluations
where the axes pull against each other, and may creep for hundreds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array, frozen
from bayescal.cameras.direct_linear import FLAT, direct_linear, flatness
from bayescal.cameras.pinhole import POSE, PinholeGeometry
from bayescal.cameras.pose import rotation_vectors
from bayescal.density.joint_data import JointData
from bayescal.errors import InputError
from bayescal.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.prior.camera import PinholePrior

# A climb that takes more creeps along a valley, of a lens that folds its image for one.
MOST_STEPS = 300
SETTLED = 1e-12  # gain of ln L, relative
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-15, 1e12
RAISED, LOWERED = 4.0, 10.0  # by so much where a step did not gain, and where it did
BENT = 0.9  # most of a direction's curvature that the levels' elimination takes away
# ln L by which a mirrored world must fit better to say that an axis is mirrored.
MIRRORED = 10.0


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
    best = max([best, *_turned(geometry, data, best)], key=lambda f: f.log_likelihood)
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
    """Climb the likelihood, the levels eliminated; None where the start has points behind it.

    Each axis is weighted by its own residuals from the start on: equal weights can lead from a
    good start to a lesser mode, which follows the worse axis at the other's cost.
    """
    residuals = _residuals(geometry, data, start)
    if residuals is None:
        return None
    free, damping = start, FIRST_DAMPING
    likelihood = data.log_likelihood(_squares(data, residuals))
    for _ in range(MOST_STEPS):
        linear = _Linear.of(geometry, data, free, residuals)
        least = SETTLED * abs(likelihood)
        while damping < MOST_DAMPING:
            trial = free + linear.step(damping)
            found = _residuals(geometry, data, trial)
            if found is not None:
                reached = data.log_likelihood(_squares(data, found))
                if reached >= likelihood - least:
                    break
            damping = RAISED * damping
        else:
            break  # nothing nearby is higher
        gain = reached - likelihood
        free, residuals, likelihood = trial, found, reached
        damping = max(damping / LOWERED, LEAST_DAMPING)
        if gain <= least:
            break
    rss = _squares(data, residuals)
    sigma = data.likely_sigma(rss)
    jacobian = geometry.jacobian(free) / (sigma[:, None] * data.deviations)[:, :, None]
    return PinholeFit(
        frozen(free),
        frozen(residuals),
        frozen(rss),
        frozen(sigma),
        likelihood,
        frozen(_inverse_gram(jacobian.reshape(-1, geometry.dimension))),
    )


def _turned(geometry: PinholeGeometry, data: JointData, best: PinholeFit) -> list[PinholeFit]:
    """Climb from where the fit goes when the axes' levels change places.

    A camera that can't follow both axes may follow either at the other's cost: each is a mode.
    """
    if not all(data.inferred):
        return []
    r, c = (NoiseLevel("known", sigma, None) for sigma in best.sigma[::-1].tolist())
    there = _climb(geometry, replace(data, levels=(r, c)), best.free)
    found = None if there is None else _climb(geometry, data, there.free)
    return [] if found is None else [found]


@dataclass(frozen=True, eq=False)
class _Linear:
    """Residuals and slopes at a place, in units of the axes' levels.

    Attributes
    ----------
    misfit : Array
        e, ``(2 n_points,)``.
    slopes : Array
        Of the predictions, columns of unit length, ``(2 n_points, dimension)``.
    scale : Array
        Length of each column, ``(dimension,)``.
    inferred : tuple of bool
        Whether each axis's level is eliminated.
    """

    misfit: Array
    slopes: Array
    scale: Array
    inferred: tuple[bool, bool]

    @classmethod
    def of(
        cls, geometry: PinholeGeometry, data: JointData, free: Array, residuals: Array
    ) -> _Linear:
        weight = 1 / (data.likely_sigma(_squares(data, residuals))[:, None] * data.deviations)
        with np.errstate(all="ignore"):
            slopes = geometry.jacobian(free) * weight[:, :, None]
        slopes = np.nan_to_num(slopes, posinf=0.0, neginf=0.0).reshape(-1, geometry.dimension)
        scale = np.linalg.norm(slopes, axis=0)
        scale[scale == 0] = 1
        return cls((residuals * weight).ravel(), slopes / scale, scale, data.inferred)

    def step(self, damping: float) -> Array:
        """Step of Levenberg and Marquardt (Marquardt 1963, J. SIAM 11, 431), ``(dimension,)``."""
        d, n = self.slopes.shape[1], len(self.misfit) // 2
        q, r = np.linalg.qr(np.concatenate([self.slopes, math.sqrt(damping) * np.eye(d)]))
        pulls = [q[i * n : (i + 1) * n].T @ self.misfit[i * n : (i + 1) * n] for i in (0, 1)]
        bend = math.sqrt(2 / n) * np.column_stack(pulls) * self.inferred
        most = float(np.linalg.norm(bend, 2)) ** 2
        if most > BENT:
            bend *= math.sqrt(BENT / most)
        move = np.linalg.solve(np.eye(d) - bend @ bend.T, pulls[0] + pulls[1])
        return np.asarray(solve_triangular(r, move) / self.scale)


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
