"""Where to start from: focal lengths tried over two decades, poses by direct linear transform.

A lens with its first coefficients turns pixels into rays, which need not be in front of the
image plane: ray x (H X) = 0 is linear in H also beyond 90 degrees. Hartley & Zisserman 2004,
section 4.1; Zhang 2000 (IEEE PAMI 22, 1330) for planes, section 7.1 for bodies.
"""

from __future__ import annotations

import math

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.least_squares import Fit, cost, least_squares
from bayescal.calibration.lens_model import LensModel
from bayescal.calibration.observations import Observations
from bayescal.calibration.stacking import Poses

FOCAL_LENGTHS = np.geomspace(0.2, 5.0, 14)  # widths
TRIED = 3  # focal lengths whose fits are followed to the end
FEW_STEPS = 12


def start_fit(model: LensModel, data: Observations) -> Fit:
    """Fit a lens from nothing.

    Returns
    -------
    Fit
        The best of several starts; its sum of squares is infinite where none is possible.
    """
    starts = [s for f in FOCAL_LENGTHS if (s := _start(model, data, f * data.size[0])) is not None]
    starts.sort(key=lambda s: s.sum_of_squares)
    tried = [least_squares(model, data, s.x, s.poses, FEW_STEPS) for s in starts[:TRIED]]
    if not tried:
        return Fit(np.zeros(model.dimension), _nowhere(data), math.inf, False)
    best = min(tried, key=lambda f: f.sum_of_squares)
    return least_squares(model, data, best.x, best.poses)


def _start(model: LensModel, data: Observations, focal: float) -> Fit | None:
    """Poses for a focal length, px; None where pixels have no rays or points can't be seen."""
    k = np.array(model.lens.start)
    intrinsics = np.array([focal, focal, *model.middle])
    plane = (data.pixels - model.middle) / focal
    found = model.lens.undistort(plane.reshape(-1, 2), k)
    if not found.found.reshape(data.seen.shape)[data.seen].all():
        return None
    rays = np.where(data.seen[..., None], found.rays.reshape(*data.seen.shape, 3), 0.0)
    poses = poses_from_rays(data, rays)
    x = model.coordinates(intrinsics, k)
    total = cost(model, data, x, poses)
    if not math.isfinite(total):
        return None
    return Fit(x, poses, total, False)


def poses_from_rays(data: Observations, rays: Array) -> Poses:
    """Poses that take the target's points to rays, ``(n_views, n_places, 3)``; 0 where unseen."""
    world = data.world
    ones = np.ones((*world.shape[:2], 1))
    known = np.concatenate([world[..., :2] if data.planar else world, ones], axis=-1)
    x, y, z = np.moveaxis(rays, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack(
        [np.stack(row, axis=-1) for row in ([zero, -z, y], [z, zero, -x], [-y, x, zero])], axis=-2
    )
    rows = np.einsum("vnij,vnk->vnijk", cross, known)
    n_views, n_places = x.shape
    _, _, vt = np.linalg.svd(rows.reshape(n_views, 3 * n_places, -1), full_matrices=False)
    h = vt[:, -1].reshape(n_views, 3, -1)
    ahead = np.einsum("vni,vij,vnj->v", rays, h, known)
    h = h * np.where(ahead < 0, -1.0, 1.0)[:, None, None]
    if data.planar:
        size = np.linalg.norm(h[:, :, :2], axis=1).mean(axis=1)[:, None, None]
        h = h / size
        third = np.cross(h[:, :, 0], h[:, :, 1])
        matrix, translation = np.concatenate([h[:, :, :2], third[..., None]], axis=2), h[:, :, 2]
    else:
        determinant = np.linalg.det(h[:, :, :3])
        size = np.cbrt(np.abs(determinant))[:, None, None]
        h = h / size
        matrix, translation = h[:, :, :3], h[:, :, 3]
    u, _, vt = np.linalg.svd(matrix)
    turn = u @ vt
    flip = np.linalg.det(turn) < 0
    u[flip, :, -1] *= -1
    return Poses(u @ vt, translation)


def _nowhere(data: Observations) -> Poses:
    turn = np.broadcast_to(np.eye(3), (data.n_views, 3, 3))
    return Poses(turn, np.zeros((data.n_views, 3)))
