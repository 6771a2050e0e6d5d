r"""Enhanced unified camera model: u = x / (alpha sqrt(beta rho^2 + z^2) + (1 - alpha) z).

Khomutenko, Garcia & Martinet 2016 (IEEE RA-L 1, 137). alpha = 0 is a pinhole, beta = 1 the unified
camera model; past 90 degrees where alpha > 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses.axial import Axial


@dataclass(frozen=True)
class Eucm(Axial):
    """Two shapes, alpha and beta."""

    name = "eucm"
    names = ("alpha", "beta")
    groups = ("shape", "shape")
    powers = (3, 3)
    start = (0.8, 0.6)
    bounds = ((0.0, 1.0), (0.0, np.inf))

    def radius(self, sine: Array, cosine: Array, k: Array) -> tuple[Array, Array]:
        """R and dR/dtheta."""
        alpha, _, distance, depth = _parts(sine, cosine, k)
        return sine / depth, (alpha * cosine / distance + 1 - alpha) / depth**2

    def by_coefficient(self, sine: Array, cosine: Array, k: Array) -> list[Array]:
        """By alpha and beta."""
        alpha, _, distance, depth = _parts(sine, cosine, k)
        factor = -sine / depth**2
        return [factor * (distance - cosine), factor * alpha * sine**2 / (2 * distance)]

    def limit(self, k: Array) -> Array:
        """Where the depth is zero (alpha <= 1/2) or the radius turns back; 0 out of bounds."""
        alpha, beta = k[..., 0], k[..., 1]
        allowed = (alpha >= 0) & (alpha <= 1) & (beta > 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.minimum(alpha, 1 - alpha) / np.maximum(alpha, 1 - alpha)
            angle = np.pi - np.arctan2(np.sqrt(1 - share**2), share * np.sqrt(beta))
        return np.where(allowed, angle, 0)


def _parts(sine: Array, cosine: Array, k: Array) -> tuple[Array, Array, Array, Array]:
    """alpha, beta, sqrt(beta rho^2 + z^2) and what x and y are divided by."""
    alpha, beta = k[..., 0, None], k[..., 1, None]
    distance = np.sqrt(beta * sine**2 + cosine**2)
    return alpha, beta, distance, alpha * distance + (1 - alpha) * cosine
