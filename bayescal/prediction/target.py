r"""The pose of a known target in a new picture, with what the calibration leaves unknown in it.

The pose is the least-squares one of the mean lens, as solvePnP's, averaged over the models where
the camera is. Its covariance is computed twice: by Monte Carlo (JCGM 101, 102), the pose solved
anew for every draw of the posterior with new noise on the pixels, and linearly
(`bayescal.prediction.propagating`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.cameras.pose import rotation_vectors, rotations
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray, Member
from bayescal.prediction.given import checked
from bayescal.prediction.picture import Picture
from bayescal.prediction.placing import Placed, distinct_poses, settle_poses
from bayescal.prediction.propagating import Propagated, propagated

FEWEST = 4
SOURCES = ("noise", "coefficients", "models")
QUANTITIES = ("x", "y", "z", "turn x", "turn y", "turn z")
ODDS = 20.0  # a second pose less likely than one in so many is not told
FAR = 10.0  # times the squares of the best: what misses by more is no second pose
UNLIKELY = 0.001  # a chi-squared so large by chance is told
MIRROR = np.array([1.0, 1.0, -1.0])
BETTER = 0.25  # of chi-squared: a mirror image with half the residuals is told
FLAT = 1e-9  # of the target's extent: points on a line have no pose


@dataclass(frozen=True, eq=False)
class TargetPose:
    """Where a target stands: X = R p + t takes its points p to the world of the camera.

    That world is the camera's own frame (x right, y down, z forward) for a lens of many views.

    Attributes
    ----------
    rotation : Array
        Rotation vector of R, ``(3,)``, rad.
    position : Array
        t, the place of the target's origin, ``(3,)``, world units.
    covariance : Array
        Of t (world units), then of a turn about the world's fixed axes (rad), ``(6, 6)``, by Monte
        Carlo: the order and axes of a ROS pose with covariance, if the world is right-handed.
    linear_covariance : Array
        The same by linear propagation.
    parts : dict of str to Array
        Of the linear sds: noise, coefficients, models, ``(6,)`` each.
    residuals : Array
        Measured less predicted pixels, ``(n, 2)``, px, of the most probable model.
    chi2 : float
        Of those residuals, by the noise of the calibration, or that stated, and what the
        calibration leaves unknown of the lens.
    p_value : float or None
        Probability of so large a chi-squared, averaged over the models; None of four points on a
        plane or fewer dof.
    extrapolated : ndarray of bool
        Which points lie beyond what the camera was calibrated with, ``(n,)``.
    second : TargetPose or None
        A second pose that fits nearly as well, with its own covariance.
    odds : float
        Of the best pose against the second by their chi-squared; infinite where there is none.
    frame : str
        ``"world"`` or ``"camera"``.
    mirrored : float or None
        Chi-squared of the target's mirror image, z negated, where that fits far better: the target
        and the world are then of opposite hands.
    """

    rotation: Array
    position: Array
    covariance: Array
    linear_covariance: Array
    parts: dict[str, Array]
    residuals: Array
    chi2: float
    p_value: float | None
    extrapolated: BoolArray
    second: TargetPose | None
    odds: float
    frame: str
    mirrored: float | None = None

    @property
    def matrix(self) -> Array:
        """R, ``(3, 3)``."""
        return rotations(self.rotation)

    @property
    def sd(self) -> Array:
        """Of t and of the turn, ``(6,)``, world units and rad."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def dof(self) -> int:
        """Two numbers of every point, less six."""
        return self.residuals.size - 6

    @property
    def rms(self) -> float:
        """Root mean square distance of the pixels from the predicted ones, px."""
        return math.sqrt((self.residuals**2).sum() / len(self.residuals))

    def __repr__(self) -> str:
        at = ", ".join(f"{v:.6g}" for v in self.position)
        return f"<TargetPose: origin at ({at}) in the {self.frame}'s frame>"


def locate_target(
    camera: CalibratedCamera,
    target: ArrayLike,
    pixels: ArrayLike,
    *,
    average: bool | None = None,
    sigma: float | None = None,
    seed: int = 0,
) -> TargetPose:
    """Find a target in a new picture; parameters and errors as of `bayescal.locate_target`."""
    points, measured = checked(target, 3, "target"), checked(pixels, 2, "pixels")
    _check(points, measured, sigma)
    camera = camera.average(average)
    own = camera.recorded(measured)
    members = [m.in_own_frame() for m in camera.used[0]]
    pictures = [Picture(m.noise, sigma) for m in members]
    every = [
        distinct_poses(m, points, own, picture.scale)
        for m, picture in zip(members, pictures, strict=True)
    ]
    best = [found[0] for found in every]
    first = _pose(camera, members, best, points, own, pictures, seed)
    if first.p_value is not None and first.p_value < UNLIKELY:
        mirrored = _mirrored(members[0], points, own, pictures[0], seed)
        if mirrored < BETTER * first.chi2:
            first = replace(first, mirrored=mirrored)
    # Chi-squared is linear in the pose: where a search was lost it would be what it is not.
    limit = FAR * (best[0].cost[0] + own.size)
    others = [p for p in every[0][1:] if p.cost[0] < limit]
    worse = [
        propagated(members[0], p, points, own, pictures[0], seed).chi2 - first.chi2 for p in others
    ]
    if min(worse, default=math.inf) > 2 * math.log(ODDS):
        return first
    other = others[int(np.argmin(worse))]
    near = [_nearest(found, other) for found in every]
    second = _pose(camera, members, near, points, own, pictures, seed)
    return replace(first, second=second, odds=math.exp(max(min(worse), 0.0) / 2))


def _mirrored(member: Member, points: Array, pixels: Array, picture: Picture, seed: int) -> float:
    """Chi-squared of the target with z negated; infinite where it has no pose."""
    image = points * MIRROR
    with suppress(InputError):
        at = distinct_poses(member, image, pixels, picture.scale)[0]
        return propagated(member, at, image, pixels, picture, seed).chi2
    return math.inf


def _check(points: Array, pixels: Array, sigma: float | None) -> None:
    if len(points) != len(pixels):
        raise InputError(f"{len(points)} points of the target have {len(pixels)} pixels")
    if len(points) < FEWEST:
        raise InputError(
            f"a pose needs {FEWEST} points of the target at least: {len(points)} are given"
        )
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if values[1] <= FLAT * values[0]:
        raise InputError("the target's points lie on a line: they have no pose")
    if sigma is not None and not (math.isfinite(sigma) and sigma > 0):
        raise InputError(f"sigma must be above 0 px, not {sigma:g}")


def _nearest(found: Sequence[Placed], to: Placed) -> Placed:
    """Of a model's poses the one closest in turn to another model's."""
    return min(found, key=lambda one: float(np.linalg.norm(one.steps_from(to)[0, 3:])))


def _pose(
    camera: CalibratedCamera,
    members: Sequence[Member],
    at: Sequence[Placed],
    points: Array,
    pixels: Array,
    pictures: Sequence[Picture],
    seed: int,
) -> TargetPose:
    """Average the models' poses, with their covariance."""
    weights = np.array(camera.used[1])
    centres = np.stack([one.steps_from(at[0])[0] for one in at])
    shift = weights @ centres
    mean = Placed(
        rotations(shift[None, 3:]) @ at[0].rotation, at[0].position + shift[:3], at[0].cost
    )
    covariance, linear = np.zeros((6, 6)), np.zeros((6, 6))
    variances = {name: np.zeros(6) for name in SOURCES}
    told: list[Propagated] = []
    for i, (member, one, picture, w) in enumerate(zip(members, at, pictures, weights, strict=True)):
        told.append(propagated(member, one, points, pixels, picture, seed))
        away = centres[i] - shift
        between = np.outer(away, away)
        for name, part in zip(SOURCES, (told[i].noise, told[i].lens, between), strict=True):
            variances[name] += w * np.diag(part)
        linear += w * (told[i].noise + told[i].lens + between)
        rng = np.random.default_rng([seed, i, 2])
        steps = _drawn(member, one, points, picture, rng).steps_from(mean)
        usable = np.isfinite(steps).all(axis=1)
        covariance += w * (steps[usable].T @ steps[usable]) / max(usable.sum(), 1)
    member, theta = members[0], members[0].parameters.mean[None]
    world = points @ at[0].rotation[0].T + at[0].position[0]
    predicted, _ = member.project(theta, world)
    sign = np.array([1.0, -1.0 if camera.c_from_bottom else 1.0])
    return TargetPose(
        rotation_vectors(mean.rotation)[0],
        mean.position[0],
        covariance,
        linear,
        {name: np.sqrt(v) for name, v in variances.items()},
        (pixels - predicted[0]) * sign,
        told[0].chi2,
        _averaged([one.p_value for one in told], weights),
        ~np.asarray(np.all([m.covered(world) for m in members], axis=0)),
        None,
        math.inf,
        "world" if camera.posed else "camera",
    )


def _averaged(p_values: Sequence[float | None], weights: Array) -> float | None:
    known = [p for p in p_values if p is not None]
    return float(weights @ known) if known else None


def _drawn(
    member: Member, at: Placed, points: Array, picture: Picture, rng: np.random.Generator
) -> Placed:
    """Poses of every draw, its noise added to the pixels."""
    draws, m = member.parameters.draws, len(member.parameters.draws)
    noise = picture.draw(rng, points)
    # Noise about what is predicted: with the residuals it would count twice.
    world = points @ at.rotation[0].T + at.position[0]
    predicted, _ = member.project(member.parameters.mean[None], world)
    start = Placed(
        np.repeat(at.rotation, m, axis=0), np.repeat(at.position, m, axis=0), np.zeros(m)
    )
    found = settle_poses(member, draws, points, predicted + noise, picture.scale, start)
    lost = ~np.isfinite(found.cost)
    found.position[lost] = np.nan
    return found
