"""Where to start from: focal lengths tried over two decades, poses by direct linear transform.

A lens with its first coefficients turns pixels into rays, which need not be in front of the
image plane: ray x (H X) = 0 is linear in H also beyond 90 degrees. Hartley & Zisserman 2004,
section 4.1; Zhang 2000 (IEEE PAMI 22, 1330) for planes, section 7.1 for bodies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from bayescal.arrays import Array, in_parts
from bayescal.calibration.fitting.least_squares import Fit, least_squares
from bayescal.calibration.fitting.stacking import Poses, residuals
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations

FOCAL_LENGTHS = np.geomspace(0.2, 5.0, 14)  # widths
AT_ONCE = 1_000_000  # numbers of pixels at which focal lengths are tried together
TRIED = 3  # focal lengths whose fits are followed to the end
FEW_STEPS = 8


def start_fit(model: LensModel, data: Observations) -> Fit:
    """Fit a lens from nothing.

    Returns
    -------
    Fit
        The best of several starts; its sum of squares is infinite where none is possible.
    """
    starts = _starts(model, data)
    tried = [least_squares(model, data, s.x, s.poses, FEW_STEPS) for s in starts[:TRIED]]
    if not tried:
        return Fit(np.zeros(model.dimension), _nowhere(data), math.inf, False)
    best = min(tried, key=lambda f: f.sum_of_squares)
    return best if best.converged else least_squares(model, data, best.x, best.poses)


def _starts(model: LensModel, data: Observations) -> list[Fit]:
    """Poses for each focal length at which all points can be seen, the best first."""
    found: list[Fit] = []
    for focal in in_parts(FOCAL_LENGTHS * data.size[0], data.pixels.size, AT_ONCE):
        found += _possible(model, data, focal)
    return sorted(found, key=lambda fit: fit.sum_of_squares)


def _possible(model: LensModel, data: Observations, focal: Array) -> Iterator[Fit]:
    """Poses for some focal lengths at which all points can be seen."""
    k = np.array(model.lens.start)
    plane = (data.pixels - model.middle) / focal[:, None, None, None]
    undistorted = model.lens.undistort(plane.reshape(-1, 2), k)
    possible = (undistorted.found.reshape(plane.shape[:-1]) | ~data.seen).all(axis=(1, 2))
    rays = undistorted.rays.reshape(*plane.shape[:-1], 3)[possible]
    poses = poses_from_rays(data, np.where(data.seen[..., None], rays, 0.0))
    focal = focal[possible]
    middle = np.broadcast_to(model.middle, (len(focal), 2))
    x = model.coordinates(
        np.column_stack([focal, focal, middle]), np.broadcast_to(k, (len(focal), len(k)))
    )
    misfit, seen = residuals(model, data, x, poses)
    with np.errstate(over="ignore"):
        totals = np.where(seen, (misfit**2).sum(axis=(1, 2, 3)), np.inf)
    for i in np.flatnonzero(np.isfinite(totals)).tolist():
        yield Fit(x[i], poses.only_draw(i), float(totals[i]), False)


def poses_from_rays(data: Observations, rays: Array) -> Poses:
    """Poses that take points to rays, ``(..., n_views, n_places, 3)``; 0 where unseen."""
    world = data.world
    ones = np.ones((*world.shape[:2], 1))
    known = np.concatenate([world[..., :2] if data.planar else world, ones], axis=-1)
    x, y, z = np.moveaxis(rays, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack(
        [np.stack(row, axis=-1) for row in ([zero, -z, y], [z, zero, -x], [-y, x, zero])], axis=-2
    )
    rows = cross[..., None] * known[..., None, None, :]
    rows = rows.reshape(*rays.shape[:-2], 3 * rays.shape[-2], -1)
    # The eigenvector of the least eigenvalue is what a singular vector would be, far sooner.
    h = np.linalg.eigh(rows.swapaxes(-1, -2) @ rows)[1][..., 0]
    h = h.reshape(*h.shape[:-1], 3, -1)
    ahead = (rays * (known @ h.swapaxes(-1, -2))).sum(axis=(-1, -2))
    h = h * np.where(ahead < 0, -1.0, 1.0)[..., None, None]
    if data.planar:
        size = np.linalg.norm(h[..., :2], axis=-2).mean(axis=-1)[..., None, None]
        h = h / size
        third = np.cross(h[..., 0], h[..., 1])
        matrix, translation = np.concatenate([h[..., :2], third[..., None]], axis=-1), h[..., 2]
    else:
        determinant = np.linalg.det(h[..., :3])
        size = np.cbrt(np.abs(determinant))[..., None, None]
        h = h / size
        matrix, translation = h[..., :3], h[..., 3]
    u, _, vt = np.linalg.svd(matrix)
    flip = np.linalg.det(u @ vt) < 0
    u[..., -1] *= np.where(flip, -1.0, 1.0)[..., None]
    return Poses(u @ vt, translation)


def _nowhere(data: Observations) -> Poses:
    turn = np.broadcast_to(np.eye(3), (data.n_views, 3, 3))
    return Poses(turn, np.zeros((data.n_views, 3)))
