r"""Lenses with an axis of symmetry: the radius in the image is a function of the angle from it.

A ray at angle theta from the axis has an image at radius R(theta) in its own direction:

    u = R(theta) x / rho,    v = R(theta) y / rho,    rho^2 = x^2 + y^2.

A lens says R, its derivatives and where it stops growing; theta may exceed 90 degrees. The inverse
is Newton's method inside a bracket, whatever R is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.lenses.inverse import invert
from bayescal.cameras.lenses.lens import RESIDUAL, Derivatives, Undistorted, columns


class Axial(ABC):
    """A lens with an axis of symmetry."""

    @abstractmethod
    def radius(self, sine: Array, cosine: Array, k: Array) -> tuple[Array, Array]:
        """R and dR/dtheta, ``(..., n)``, of the angle's sine and cosine."""

    @abstractmethod
    def by_coefficient(self, sine: Array, cosine: Array, k: Array) -> list[Array]:
        """Give dR/dk of each coefficient, ``(..., n)``."""

    @abstractmethod
    def limit(self, k: Array) -> Array:
        """Angle from the axis up to which the radius in the image grows, ``(...)``, rad."""

    def distort(self, rays: Array, k: Array) -> Array:
        """Plane coordinates, ``(..., n, 2)``."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            sine, cosine, rho, length = _angle(rays)
            radius, slope = self.radius(sine, cosine, k)
            scale = np.where(rho == 0, slope / length, radius / np.where(rho == 0, 1, rho))
            return columns(rays[..., 0] * scale, rays[..., 1] * scale)

    def jacobian(self, rays: Array, k: Array) -> Derivatives:
        """Plane coordinates with derivatives by ray and by coefficient."""
        x, y = rays[..., 0], rays[..., 1]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            sine, cosine, rho, length = _angle(rays)
            radius, slope = self.radius(sine, cosine, k)
            some = np.where(rho == 0, 1, rho)
            scale = np.where(rho == 0, slope / length, radius / some)
            toward = x / some, y / some
            # d theta is (cosine d rho - sine d z) / length.
            bend, sink = slope * cosine / length - scale, -slope * sine / length
            by_ray = np.empty((*scale.shape, 2, 3))
            by_k = np.empty((*scale.shape, 2, k.shape[-1]))
            slopes = self.by_coefficient(sine, cosine, k)
            for i in (0, 1):
                by_ray[..., i, 0] = toward[i] * toward[0] * bend
                by_ray[..., i, 1] = toward[i] * toward[1] * bend
                by_ray[..., i, i] += scale
                by_ray[..., i, 2] = toward[i] * sink
                for j, by in enumerate(slopes):
                    by_k[..., i, j] = toward[i] * by
            return Derivatives(columns(x * scale, y * scale), by_ray, by_k)

    def seen(self, rays: Array, k: Array) -> NDArray[np.bool_]:
        """Whether rays are inside `limit`, ``(..., n)``."""
        angle = np.arctan2(np.sqrt(rays[..., 0] ** 2 + rays[..., 1] ** 2), rays[..., 2])
        return np.asarray(angle < self.limit(k)[..., None])

    def undistort(self, plane: Array, k: Array) -> Undistorted:
        """Rays of plane coordinates, by Newton's method inside a bracket."""
        u, v = plane[..., 0], plane[..., 1]
        radius, limit = np.hypot(u, v), self.limit(k)[..., None]
        shape = np.broadcast_shapes(radius.shape, limit.shape)
        target = np.broadcast_to(radius, shape)
        angle = invert(
            lambda at: self.radius(np.sin(at), np.cos(at), k), target, np.broadcast_to(limit, shape)
        )
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            some, sine = np.where(radius == 0, 1, radius), np.sin(angle)
            rays = columns(u / some * sine, v / some * sine, np.cos(angle))
            miss = np.abs(self.distort(rays, k) - plane).max(axis=-1)
        found = (miss <= RESIDUAL * np.maximum(1, radius)) & (angle < limit)
        return Undistorted(np.where(found[..., None], rays, np.nan), np.asarray(found))


def _angle(rays: Array) -> tuple[Array, Array, Array, Array]:
    """Sine and cosine of the angle from the axis, distance from it, and length, ``(..., n)``."""
    square = rays[..., 0] ** 2 + rays[..., 1] ** 2
    rho, length = np.sqrt(square), np.sqrt(square + rays[..., 2] ** 2)
    return rho / length, rays[..., 2] / length, rho, length
