"""Where a known target stands: its pose by least squares, for many cameras or pixels at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from bayescal.arrays import Array
from bayescal.cameras.pose import cross_matrices, rotations
from bayescal.errors import InputError
from bayescal.prediction.calibrated.members import BoolArray, Member

MOST_STEPS = 60
SETTLED = 1e-7  # of an sd of the pose: the last step, and steps shrink quadratically
SAME = 1e-3  # rad and diagonals: poses closer than this are one
ROUNDING = 1e-12  # of the cost
FIRST_DAMPING, MOST_DAMPING = 1e-3, 1e12


@dataclass(frozen=True, eq=False)
class Placed:
    """Poses that take points of the target to the camera's world: X = R p + t.

    Attributes
    ----------
    rotation : Array
        ``(m, 3, 3)``.
    position : Array
        t, where the target's origin is, ``(m, 3)``, world units.
    cost : Array
        Chi-squared, ``(m,)``; infinite where a point is not seen.
    """

    rotation: Array
    position: Array
    cost: Array

    def only(self, index: int) -> Placed:
        """One of them."""
        i = slice(index, index + 1)
        return Placed(self.rotation[i], self.position[i], self.cost[i])

    def steps_from(self, other: Placed) -> Array:
        """Shifts (world units), then turns about the world's axes (rad), from another, ``(m, 6)``.

        The axes are fixed, as in the covariance of a ROS pose.
        """
        turn = self.rotation @ np.swapaxes(other.rotation, 1, 2)
        vectors = Rotation.from_matrix(turn).as_rotvec()
        return np.concatenate([self.position - other.position, vectors], axis=1)


def starts(member: Member, target: Array, pixels: Array) -> Placed | None:
    """Poses to search from: 24 turns of the target along the line of sight of its pixels.

    None where fewer than four pixels have a line of sight.
    """
    solved = member.solutions(pixels)
    sight = member.rays(member.parameters.mean[None], pixels[None], solved.scaled)
    known = sight.found[0] & (solved.count > 0)
    if known.sum() < 4:
        return None
    unit = sight.direction[0, known]
    middle = unit.mean(axis=0) / np.linalg.norm(unit.mean(axis=0))
    apart = np.sqrt(((unit - unit.mean(axis=0)) ** 2).sum(axis=1).mean())
    centre = target.mean(axis=0)
    size = np.sqrt(((target[known] - target[known].mean(axis=0)) ** 2).sum(axis=1).mean())
    distance = max(0.8 * size / apart, 2 * np.linalg.norm(target - centre, axis=1).max())
    turns = Rotation.create_group("O").as_matrix()
    at = sight.origin[0] + distance * middle
    position = at - np.einsum("mij,j->mi", turns, centre)
    return Placed(np.asarray(turns), np.asarray(position), np.full(len(turns), np.inf))


def settle_poses(
    member: Member, theta: Array, target: Array, pixels: Array, scale: Array, start: Placed
) -> Placed:
    """Climb down from each start (Marquardt 1963).

    Parameters
    ----------
    theta : Array
        Parameters of each, ``(m, d)``.
    target : Array
        Points in the target's own frame, ``(n, 3)``, world units.
    pixels : Array
        Where each is seen, ``(m, n, 2)`` or ``(1, n, 2)``, px.
    scale : Array
        Sd of the noise of r and of c, ``(2,)``, px.
    """
    now = Placed(start.rotation, start.position, _cost(member, theta, target, pixels, scale, start))
    damping, running = np.full(len(theta), FIRST_DAMPING), np.isfinite(now.cost)
    for _ in range(MOST_STEPS):
        miss, slope, _ = sensitivity(member, theta, target, pixels, scale, now)
        square = np.einsum("mki,mkj->mij", slope, slope)
        pull = np.einsum("mki,mk->mi", slope, miss)
        size = np.sqrt(np.maximum(np.einsum("mii->mi", square), np.finfo(float).tiny))
        scaled = square / size[:, :, None] / size[:, None, :]
        scaled = np.where(running[:, None, None], scaled, 0.0)
        scaled = scaled + damping[:, None, None] * np.eye(6)
        step = np.linalg.solve(scaled, (pull / size)[..., None])[..., 0] / size
        trial = _moved(now, np.where(running[:, None], step, 0.0))
        cost = _cost(member, theta, target, pixels, scale, trial)
        better = running & (cost <= now.cost * (1 + ROUNDING))
        settled = (np.abs(step * size).max(axis=1) < SETTLED) | (damping > MOST_DAMPING)
        now = Placed(
            np.where(better[:, None, None], trial.rotation, now.rotation),
            np.where(better[:, None], trial.position, now.position),
            np.where(better, cost, now.cost),
        )
        damping = np.where(better, np.maximum(damping / 10, 1e-15), damping * 10)
        running = running & ~settled
        if not running.any():
            break
    return now


def distinct_poses(member: Member, points: Array, pixels: Array, scale: Array) -> list[Placed]:
    """Give the different poses where a search ends, the best first.

    Raises
    ------
    InputError
        Where too few pixels have a line of sight, or no pose shows all points.
    """
    start = starts(member, points, pixels)
    if start is None:
        raise InputError(
            "fewer than four of the target's pixels look at something in the calibrated domain"
        )
    theta = np.repeat(member.parameters.mean[None], len(start.cost), axis=0)
    found = settle_poses(member, theta, points, pixels[None], scale, start)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    kept: list[Placed] = []
    for i in np.argsort(found.cost):
        one = found.only(int(i))
        if np.isfinite(one.cost[0]) and all(_apart(one, other, size) > SAME for other in kept):
            kept.append(one)
    if not kept:
        raise InputError("no pose puts all points of the target where the camera can see them")
    return kept


def _apart(one: Placed, other: Placed, size: float) -> float:
    step = one.steps_from(other)[0]
    return float(max(np.abs(step[:3]).max() / size, np.abs(step[3:]).max()))


def sensitivity(
    member: Member, theta: Array, target: Array, pixels: Array, scale: Array, at: Placed
) -> tuple[Array, Array, BoolArray]:
    """Residuals ``(m, 2 n)`` and their slopes ``(m, 2 n, 6)`` over the noise; whether all are seen.

    Slopes are by the shifts and turns of `Placed.steps_from`.
    """
    arms = target @ np.swapaxes(at.rotation, 1, 2)
    found, slope, seen = member.project_with_slopes(theta, arms + at.position[:, None, :])
    miss = np.where(seen[..., None], (pixels - found) / scale, 0.0)
    slope = np.where(seen[..., None, None], slope / scale[:, None], 0.0)
    both = np.concatenate([slope, -slope @ cross_matrices(arms)], axis=-1)
    m = len(theta)
    return miss.reshape(m, -1), both.reshape(m, -1, 6), seen.all(axis=1)


def _moved(at: Placed, step: Array) -> Placed:
    turn = rotations(step[:, 3:])
    return Placed(turn @ at.rotation, at.position + step[:, :3], at.cost)


def _cost(
    member: Member, theta: Array, target: Array, pixels: Array, scale: Array, at: Placed
) -> Array:
    world = target @ np.swapaxes(at.rotation, 1, 2) + at.position[:, None, :]
    found, seen = member.project(theta, world)
    total = (((pixels - found) / scale) ** 2).sum(axis=(1, 2))
    return np.where(seen.all(axis=1), total, np.inf)
