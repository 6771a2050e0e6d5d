"""A camera: a lens, and how its plane becomes pixels; with a pose, the world.

Frames are OpenCV's: x right, y down, z forward; r from the left, c from the top, pixel centres at
integers. Intrinsics are fx, fy, cx, cy (px): r = fx u + cx, c = fy v + cy with (u, v) of the lens.
A pose is a rotation vector and a translation, p = R X + t (`bayescal.cameras.pose`). The camera
holds no points and no numbers: everything is passed in, with leading dimensions of draws or views
that broadcast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.lenses.lens import Lens, Undistorted
from bayescal.cameras.pose import rotations


@dataclass(frozen=True, eq=False)
class PixelSlopes:
    """Pixels of rays and their derivatives.

    Attributes
    ----------
    pixels : Array
        r, c, ``(..., n, 2)``, px.
    by_intrinsics : Array
        By fx, fy, cx, cy, ``(..., n, 2, 4)``.
    by_coefficients : Array
        By the lens's coefficients, ``(..., n, 2, K)``.
    by_ray : Array
        By x, y, z of the ray, ``(..., n, 2, 3)``.
    """

    pixels: Array
    by_intrinsics: Array
    by_coefficients: Array
    by_ray: Array


@dataclass(frozen=True, eq=False)
class Projection:
    """Pixels and their derivatives.

    Attributes
    ----------
    pixels : Array
        r, c, ``(..., n, 2)``, px.
    by_intrinsics : Array
        By fx, fy, cx, cy, ``(..., n, 2, 4)``.
    by_coefficients : Array
        By the lens's coefficients, ``(..., n, 2, K)``.
    by_pose : Array
        By a left perturbation of the rotation (rad) and by the translation, ``(..., n, 2, 6)``.
    by_world : Array
        By the world points, ``(..., n, 2, 3)``.
    seen : ndarray of bool
        Whether the lens sees the point, ``(..., n)``.
    """

    pixels: Array
    by_intrinsics: Array
    by_coefficients: Array
    by_pose: Array
    by_world: Array
    seen: NDArray[np.bool_]


@dataclass(frozen=True)
class Camera:
    """A lens that makes pixels."""

    lens: Lens

    def pixels(self, intrinsics: Array, k: Array, rays: Array) -> Array:
        """Pixels of rays in the camera's frame, ``(..., n, 2)``, px."""
        plane = self.lens.distort(rays, k)
        return np.asarray(intrinsics[..., None, 2:] + intrinsics[..., None, :2] * plane)

    def jacobian(self, intrinsics: Array, k: Array, rays: Array) -> PixelSlopes:
        """Pixels of rays in the camera's frame, with their derivatives."""
        found = self.lens.jacobian(rays, k)
        focal = intrinsics[..., None, :2]
        pixels = np.asarray(intrinsics[..., None, 2:] + focal * found.plane)
        by_intrinsics = np.zeros((*pixels.shape, 4))
        by_intrinsics[..., [0, 1], [0, 1]] = found.plane
        by_intrinsics[..., [0, 1], [2, 3]] = 1
        by_coefficients = found.by_coefficient * focal[..., None]
        return PixelSlopes(pixels, by_intrinsics, by_coefficients, found.by_ray * focal[..., None])

    def rays(self, intrinsics: Array, k: Array, pixels: Array) -> Undistorted:
        """Rays in the camera's frame that are seen at pixels, ``(..., n, 2)``."""
        plane = (pixels - intrinsics[..., None, 2:]) / intrinsics[..., None, :2]
        return self.lens.undistort(plane, k)

    def project(
        self, intrinsics: Array, k: Array, rotation: Array, translation: Array, world: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Pixels of world points ``(..., n, 3)``, and whether the lens sees them, ``(..., n)``."""
        rays = to_camera(rotation, translation, world)
        return self.pixels(intrinsics, k, rays), self.lens.seen(rays, k)

    def project_with_jacobian(
        self, intrinsics: Array, k: Array, rotation: Array, translation: Array, world: Array
    ) -> Projection:
        """Pixels of world points, ``(..., n, 3)``, with their derivatives."""
        matrix = rotations(rotation)
        arms = world @ np.swapaxes(matrix, -1, -2)  # R X
        rays = arms + translation[..., None, :]
        found = self.jacobian(intrinsics, k, rays)
        g, arm = found.by_ray, arms[..., None, :]
        by_pose = np.empty((*g.shape[:-1], 6))
        # A row g of by_ray turns into g (-[R X]x) = (R X) x g.
        for i, one, other in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            by_pose[..., i] = arm[..., one] * g[..., other] - arm[..., other] * g[..., one]
        by_pose[..., 3:] = g
        by_world = g.reshape(*g.shape[:-3], -1, 3) @ matrix
        return Projection(
            found.pixels,
            found.by_intrinsics,
            found.by_coefficients,
            by_pose,
            by_world.reshape(g.shape),
            self.lens.seen(rays, k),
        )


def to_camera(rotation: Array, translation: Array, world: Array) -> Array:
    """World points in the camera's frame, ``(..., n, 3)``: R X + t."""
    return world @ np.swapaxes(rotations(rotation), -1, -2) + translation[..., None, :]
