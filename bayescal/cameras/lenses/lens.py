"""What a lens is: from a direction in the camera's frame to the normalised image plane.

The frame is OpenCV's: x right, y down, z forward. A lens maps a ray (x, y, z), of any length,
to (u, v); without distortion u = x/z and v = y/z. Rays have shape ``(..., n, 3)`` and
coefficients k ``(..., K)``: leading dimensions are draws or views, and broadcast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array

# Largest residual of an inverse that counts as found, of plane coordinates up to 1: 1e-9 px at a
# focal length of 10 000 px.
RESIDUAL = 1e-13


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Plane coordinates and their derivatives.

    Attributes
    ----------
    plane : Array
        u, v, ``(..., n, 2)``.
    by_ray : Array
        By x, y, z of the ray, ``(..., n, 2, 3)``.
    by_coefficient : Array
        ``(..., n, 2, K)``.
    """

    plane: Array
    by_ray: Array
    by_coefficient: Array


@dataclass(frozen=True, eq=False)
class Undistorted:
    """Rays that a lens maps to given plane coordinates.

    Attributes
    ----------
    rays : Array
        Of length 1, ``(..., n, 3)``; nan where not found.
    found : ndarray of bool
        ``(..., n)``: whether `distort` gives the plane coordinates back, to 1e-13 of them or of 1.
    """

    rays: Array
    found: NDArray[np.bool_]


class Lens(Protocol):
    """A lens model: frozen, without coefficients of its own.

    Attributes
    ----------
    name : str
        As the user writes it.
    names : tuple of str
        Of the coefficients, in OpenCV's order and with its names where it has them.
    groups : tuple of str
        Of each coefficient: ``"radial"``, ``"tangential"``, ``"thin-prism"`` or ``"shape"``; those
        of one group share one strength.
    powers : tuple of int
        Power of the radius with which the displacement by each coefficient grows near the axis
        (k1: 3, k2: 5, p1: 2).
    start : tuple of float
        Coefficients to begin a search from.
    bounds : tuple of (float, float)
        What each coefficient must lie between; infinite where it may be anything.
    """

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def groups(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def powers(self) -> tuple[int, ...]: ...  # noqa: D102
    @property
    def start(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def bounds(self) -> tuple[tuple[float, float], ...]: ...  # noqa: D102

    def distort(self, rays: Array, k: Array) -> Array:
        """Plane coordinates, ``(..., n, 2)``; meaningless where the ray is not `seen`."""

    def jacobian(self, rays: Array, k: Array) -> Derivatives:
        """Plane coordinates with derivatives by ray and by coefficient."""

    def seen(self, rays: Array, k: Array) -> NDArray[np.bool_]:
        """Whether rays have an image: before the fold, before a pole, ``(..., n)``."""

    def undistort(self, plane: Array, k: Array) -> Undistorted:
        """Rays of plane coordinates, ``(..., n, 2)``, among those that are `seen`."""

    def limit(self, k: Array) -> Array:
        """Angle from the axis up to which the radius in the image grows, ``(...)``, rad."""


def columns(*parts: Array) -> Array:
    """Join arrays ``(..., n)`` along a new last axis; each stays contiguous in memory."""
    joined = np.array(parts)
    return joined.transpose(*range(1, joined.ndim), 0)
