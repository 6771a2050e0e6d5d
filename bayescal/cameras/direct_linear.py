"""A pinhole without distortion from a linear system: where a non-linear fit can start.

The direct linear transform with normalised coordinates (Hartley & Zisserman 2004, 4.4, 7.1):
P = K R [I, -C] from the null vector of 2n equations, taken apart by an RQ decomposition;
its skew is dropped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import rq

from bayescal.arrays import Array, frozen

FEWEST_POINTS = 6  # 11 unknowns, two equations a point
# Singular value of the centred points, over the largest, below which they are coplanar.
FLAT = 1e-6


@dataclass(frozen=True, eq=False)
class LinearCamera:
    """What the linear system says of the camera.

    Attributes
    ----------
    focal, centre : Array
        ``(2,)``, px.
    rotation : Array
        From world directions to the camera's frame, ``(3, 3)``.
    position : Array
        ``(3,)``, world units.
    mirrored : bool
        Whether the points' image is that of a mirrored world: no rotation makes it.
    """

    focal: Array
    centre: Array
    rotation: Array
    position: Array
    mirrored: bool


def flatness(world: Array) -> float:
    """Thickness of the points over their extent: 0 where they lie in one plane."""
    values = np.linalg.svd(world - world.mean(axis=0), compute_uv=False)
    return float(values[-1] / values[0]) if values[0] > 0 else 0.0


def direct_linear(world: Array, pixels: Array) -> LinearCamera | None:
    """Solve for a camera linearly.

    Parameters
    ----------
    world : Array
        ``(n_points, 3)``, world units.
    pixels : Array
        r, c, ``(n_points, 2)``, px.

    Returns
    -------
    LinearCamera or None
        None where there are fewer than 6 points, they are coplanar or the solution is
        degenerate.
    """
    if len(world) < FEWEST_POINTS or flatness(world) < FLAT:
        return None
    space, plane = _normaliser(world), _normaliser(pixels)
    x = np.column_stack([world, np.ones(len(world))]) @ space.T
    t = np.column_stack([pixels, np.ones(len(pixels))]) @ plane.T
    rows = [np.hstack([x * (i == 0), x * (i == 1), -t[:, i, None] * x]) for i in (0, 1)]
    null = np.linalg.svd(np.vstack(rows), full_matrices=False)[2][-1]
    matrix = np.linalg.solve(plane, null.reshape(3, 4)) @ space
    depths = np.column_stack([world, np.ones(len(world))]) @ matrix[2]
    matrix *= np.sign(np.median(depths))
    if np.linalg.cond(matrix[:, :3]) > 1 / (np.finfo(float).eps * 1e3):
        return None
    intrinsic, turned = rq(matrix[:, :3])
    signs = np.sign(np.diag(intrinsic))
    intrinsic, turned = intrinsic * signs, signs[:, None] * turned
    mirrored = bool(np.linalg.det(turned) < 0)
    intrinsic /= intrinsic[2, 2]
    position = -np.linalg.solve(matrix[:, :3], matrix[:, 3])
    return LinearCamera(
        frozen([intrinsic[0, 0], intrinsic[1, 1]]),
        frozen([intrinsic[0, 2], intrinsic[1, 2]]),
        frozen(turned.tolist()),
        frozen(position.tolist()),
        mirrored,
    )


def _normaliser(points: Array) -> Array:
    """Similarity that centres points and brings them to unit spread."""
    d = points.shape[1]
    centre = points.mean(axis=0)
    scale = 1 / (float(np.sqrt(((points - centre) ** 2).mean())) or 1.0)
    out = np.eye(d + 1) * scale
    out[:d, d], out[d, d] = -scale * centre, 1
    return out
