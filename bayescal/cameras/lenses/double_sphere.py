r"""Double sphere: onto a sphere, onto a second one xi further on, then by a pinhole.

    u = x / (alpha d2 + (1 - alpha) (xi d1 + z)),
    d1^2 = rho^2 + z^2,    d2^2 = rho^2 + (xi d1 + z)^2.

Usenko, Demmel & Cremers 2018 (3DV, 552; arXiv:1807.08957, eq. 40-45). xi = 0 is the unified camera
model. xi also scales the image by 1 / (1 + xi), which the focal length makes up for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses.axial import Axial


@dataclass(frozen=True)
class DoubleSphere(Axial):
    """Two shapes, xi and alpha."""

    name = "double-sphere"
    names = ("xi", "alpha")
    groups = ("shape", "shape")
    powers = (1, 3)
    start = (0.0, 0.5)
    bounds = ((-1.0, 1.0), (0.0, 1.0))

    def radius(self, sine: Array, cosine: Array, k: Array) -> tuple[Array, Array]:
        """R and dR/dtheta."""
        xi, _, _, _, lean, depth = _parts(sine, cosine, k)
        return sine / depth, (1 + xi * cosine) * lean / depth**2

    def by_coefficient(self, sine: Array, cosine: Array, k: Array) -> list[Array]:
        """By xi and alpha."""
        _, _, ahead, distance, lean, depth = _parts(sine, cosine, k)
        factor = -sine / depth**2
        return [factor * lean, factor * (distance - ahead)]

    def limit(self, k: Array) -> Array:
        """Where the depth is zero (alpha <= 1/2) or the radius turns back; 0 out of bounds."""
        xi, alpha = k[..., 0], k[..., 1]
        allowed = (np.abs(xi) <= 1) & (alpha >= 0) & (alpha <= 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.minimum(alpha, 1 - alpha) / np.maximum(alpha, 1 - alpha)
            # xi + cos(theta) = -share d2, solved for the cosine; eq. 43-45 have a rougher bound.
            rest = xi * (1 - share**2)
            angle = np.arccos(-(rest + share * np.sqrt(1 - xi * rest)))
        return np.where(allowed, angle, 0)


def _parts(sine: Array, cosine: Array, k: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """xi, alpha, xi + z, d2, its mix with 1 that both derivatives hold, and the depth."""
    xi, alpha = k[..., 0, None], k[..., 1, None]
    ahead = xi + cosine
    distance = np.sqrt(sine**2 + ahead**2)
    lean = alpha * ahead / distance + 1 - alpha
    return xi, alpha, ahead, distance, lean, alpha * distance + (1 - alpha) * ahead
