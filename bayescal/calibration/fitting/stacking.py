"""Residuals of all views and their derivatives, stacked view by view."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, IntArray
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.cameras.pose import rotations


@dataclass(frozen=True, eq=False)
class Poses:
    """Where the target was in each view: X_camera = rotation X + translation.

    Attributes
    ----------
    rotation : Array
        ``(..., n_views, 3, 3)``.
    translation : Array
        ``(..., n_views, 3)``, diagonals of the target.
    """

    rotation: Array
    translation: Array

    def moved(self, step: Array) -> Poses:
        """Poses turned by exp(step[:3]) on the camera's side and shifted by step[3:].

        Parameters
        ----------
        step : Array
            ``(..., n_views, 6)``, radians and diagonals.
        """
        turn = rotations(step[..., :3])
        return Poses(turn @ self.rotation, self.translation + step[..., 3:])

    @property
    def depth(self) -> float:
        """Distance of the target, median over the views, diagonals."""
        return float(np.median(np.linalg.norm(self.translation, axis=-1)))

    def only(self, views: IntArray) -> Poses:
        """Poses of some views."""
        return Poses(self.rotation[..., views, :, :], self.translation[..., views, :])

    def between(self, views: slice) -> Poses:
        """Poses of neighbouring views."""
        return Poses(self.rotation[..., views, :, :], self.translation[..., views, :])

    def only_draw(self, draw: int) -> Poses:
        """Poses of one draw of many."""
        return Poses(self.rotation[draw], self.translation[draw])


@dataclass(frozen=True, eq=False)
class Stacked:
    """Weighted residuals (observed less predicted) and derivatives of the prediction.

    Attributes
    ----------
    residuals : Array
        ``(n_views, n_places, 2)``.
    by_lens : Array
        ``(n_views, n_places, 2, dimension)``.
    by_pose : Array
        ``(n_views, n_places, 2, 6)``, as `Poses.moved` steps.
    by_target : Array
        By the point of the target, ``(n_views, n_places, 2, 3)``, px a diagonal.
    possible : bool
        Whether every point is where the lens can see it.
    """

    residuals: Array
    by_lens: Array
    by_pose: Array
    by_target: Array
    possible: bool

    @cached_property
    def columns(self) -> Array:
        """Derivatives by pose and by lens, then the residuals, ``(n_views, n_places, 2, ...)``."""
        return np.concatenate([self.by_pose, self.by_lens, self.residuals[..., None]], axis=-1)


def bowl(data: Observations, at: Array) -> Array:
    """Shape of the bow at x, y of the target: 1 - x^2 and 1 - y^2, x, y scaled to -1..1."""
    half = np.maximum(np.abs(data.target[:, :2]).max(axis=0), 1e-300)
    return np.asarray(1 - (at[..., :2] / half) ** 2)


def camera_points(model: LensModel, data: Observations, bow: Array, poses: Poses) -> Array:
    """Points in the camera's frame, ``(..., n_views, n_places, 3)``; each axis is contiguous."""
    shape = np.broadcast_shapes(poses.rotation.shape[:-3], bow.shape[:-1])
    parts = [poses.rotation, poses.translation[..., None]]
    features = [data.world, np.ones((*data.which.shape, 1))]
    if model.bow:
        parts.append(poses.rotation[..., 2:] * bow[..., None, None, :])
        features.append(bowl(data, data.world))
    # One product per axis, of all draws of a view at once.
    by_view = np.moveaxis(np.concatenate(features, axis=-1), -1, -2)
    moved = np.concatenate(parts, axis=-1).reshape(-1, data.n_views, 3, by_view.shape[1])
    out = np.empty((3, len(moved), *data.which.shape))
    for axis in range(3):
        np.matmul(moved[:, :, axis].swapaxes(0, 1), by_view, out=out[axis].swapaxes(0, 1))
    return np.moveaxis(out.reshape(3, *shape, *data.which.shape), 0, -1)


def residuals(
    model: LensModel, data: Observations, x: Array, poses: Poses
) -> tuple[Array, NDArray[np.bool_]]:
    """Weighted residuals at many draws.

    Parameters
    ----------
    x : Array
        ``(..., dimension)``.
    poses : Poses
        Of the same leading axes.

    Returns
    -------
    residuals : Array
        ``(..., n_views, n_places, 2)``, 0 where nothing was seen.
    possible : ndarray of bool
        ``(...,)``: whether every point is where the lens can see it.
    """
    intrinsics, k, bow = model.physical(x)
    rays = camera_points(model, data, bow, poses)
    shape = rays.shape[:-1]
    # The axes of rays and of the image stay apart in memory, as `camera_points` has them.
    flat = np.moveaxis(np.moveaxis(rays, -1, 0).reshape(3, *shape[:-2], -1), 0, -1)
    misfit = np.empty((2, *shape))
    with np.errstate(all="ignore"):
        plane = model.lens.distort(flat, k)
        for axis in (0, 1):
            scale, centre = intrinsics[..., axis, None, None], intrinsics[..., 2 + axis, None, None]
            np.subtract(data.pixels[..., axis], centre, out=misfit[axis])
            misfit[axis] -= scale * plane[..., axis].reshape(shape)
            misfit[axis] *= data.weight[..., axis]
        visible = model.lens.seen(flat, k).reshape(shape)
    if not data.complete:
        misfit[:, ..., ~data.seen] = 0.0
        visible = visible | ~data.seen
    finite = np.isfinite(misfit).all(axis=(0, -1, -2))
    return np.moveaxis(misfit, 0, -1), visible.all(axis=(-1, -2)) & finite


def stacked(model: LensModel, data: Observations, x: Array, poses: Poses) -> Stacked:
    """Residuals and derivatives at coordinates ``(dimension,)``."""
    with np.errstate(all="ignore"):  # steps may lead to lenses that see nothing
        return _stacked(model, data, x, poses)


def _stacked(model: LensModel, data: Observations, x: Array, poses: Poses) -> Stacked:
    intrinsics, k, bow = model.physical(x)
    rays = camera_points(model, data, bow, poses)
    flat = rays.reshape(-1, 3)
    found = model.lens.jacobian(flat, k)
    visible = model.lens.seen(flat, k).reshape(rays.shape[:-1])
    shape = rays.shape[:2]
    scale, centre, weight = intrinsics[:2], intrinsics[2:], data.weight
    plane, gain = scale * found.plane.reshape(*shape, 2), (scale * weight)[..., None]
    misfit = (data.pixels - centre - plane) * weight
    slope = found.by_ray.reshape(*shape, 2, 3) * gain
    by_k = found.by_coefficient.reshape(*shape, 2, -1) * gain
    by_lens = model.by_coordinate(x, plane * weight, weight, by_k)
    possible = bool((visible | ~data.seen).all())
    if not data.complete:
        misfit[~data.seen], slope[~data.seen], by_lens[~data.seen] = 0.0, 0.0, 0.0
    turned = rays - poses.translation[:, None]
    by_pose = np.concatenate([_crossed(turned, slope), slope], axis=-1)
    by_target = (slope.reshape(len(slope), -1, 3) @ poses.rotation).reshape(slope.shape)
    if model.bow:
        by_lens[..., -2:] = by_target[..., 2, None] * bowl(data, data.world)[..., None, :]
    possible = possible and bool(np.isfinite(misfit).all())
    return Stacked(misfit, by_lens, by_pose, by_target, possible)


def _crossed(points: Array, slopes: Array) -> Array:
    """Cross products with each row of slopes, ``(..., 2, 3)``: sooner than by matrices."""
    (x, y, z), (a, b, c) = np.moveaxis(points, -1, 0)[..., None], np.moveaxis(slopes, -1, 0)
    out = np.empty(slopes.shape)
    out[..., 0], out[..., 1], out[..., 2] = y * c - z * b, z * a - x * c, x * b - y * a
    return out


def pose_slopes(model: LensModel, data: Observations, x: Array, poses: Poses) -> Array:
    """Weighted derivatives of the prediction by the poses at many lenses.

    Parameters
    ----------
    x : Array
        ``(n_draws, dimension)``.
    poses : Poses
        Of as many draws.

    Returns
    -------
    Array
        ``(n_draws, n_views, n_places, 2, 6)``, as `Poses.moved` steps.
    """
    intrinsics, k, bow = model.physical(x)
    rays = camera_points(model, data, bow, poses)
    with np.errstate(all="ignore"):
        found = model.lens.jacobian(rays.reshape(len(x), -1, 3), k)
    by_point = intrinsics[:, None, None, :2, None] * found.by_ray.reshape(*rays.shape[:-1], 2, 3)
    by_point = np.where(data.seen[..., None, None], by_point * data.weight[..., None], 0.0)
    turned = rays - poses.translation[..., None, :]
    return np.concatenate([_crossed(turned, by_point), by_point], axis=-1)
