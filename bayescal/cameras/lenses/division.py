r"""Division: the undistorted radius is R / (1 + lambda R^2), R the radius in the image.

Fitzgibbon 2001 (CVPR, 125). The ray of (u, v) is (u, v, 1 + lambda R^2); its inverse solves

    lambda sin(theta) R^2 - cos(theta) R + sin(theta) = 0.

lambda < 0 is barrel distortion, and R then grows all around, past 90 degrees; for lambda > 0 it
turns back where tan(theta) = 1 / (2 sqrt(lambda)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses.axial import Axial


@dataclass(frozen=True)
class Division(Axial):
    """One coefficient below the line."""

    name = "division"
    names = ("lambda",)
    groups = ("radial",)
    powers = (3,)
    start = (0.0,)
    bounds = ((-np.inf, np.inf),)

    def radius(self, sine: Array, cosine: Array, k: Array) -> tuple[Array, Array]:
        """R and dR/dtheta."""
        bend = k[..., 0, None]
        root = np.sqrt(cosine**2 - 4 * bend * sine**2)
        # Of the two forms of the one root, that without a difference of like numbers.
        radius = np.where(
            cosine >= 0, 2 * sine / (cosine + root), (cosine - root) / (2 * bend * sine)
        )
        return radius, (bend * cosine * radius**2 + sine * radius + cosine) / root

    def by_coefficient(self, sine: Array, cosine: Array, k: Array) -> list[Array]:
        """By lambda."""
        radius, _ = self.radius(sine, cosine, k)
        return [sine * radius**2 / np.sqrt(cosine**2 - 4 * k[..., 0, None] * sine**2)]

    def limit(self, k: Array) -> Array:
        """Where the discriminant is zero, or all around."""
        bend = k[..., 0]
        turn = np.arctan2(1.0, 2 * np.sqrt(np.maximum(bend, 0)))
        return np.where(bend < 0, np.pi, turn)
