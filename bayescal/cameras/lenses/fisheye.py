r"""Fisheye: R = theta (1 + k1 theta^2 + k2 theta^4 + ...), theta the angle itself.

Kannala & Brandt 2006 (IEEE PAMI 28, 1335); OpenCV's fisheye module has four coefficients. No
tangent is taken, so that angles may exceed 90 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses.axial import Axial
from bayescal.cameras.lenses.polynomial import first_root, horner
from bayescal.errors import InputError

LARGEST_ORDER = 5


@dataclass(frozen=True)
class Fisheye(Axial):
    """Polynomial of the angle.

    Attributes
    ----------
    order : int
        Number of coefficients; 0 is the equidistant lens.
    """

    order: int = 4
    name = "fisheye"

    def __post_init__(self) -> None:
        if not 0 <= self.order <= LARGEST_ORDER:
            raise InputError(f"order {self.order} of lens fisheye: use 0 to {LARGEST_ORDER}")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the coefficients."""
        return tuple(f"k{j + 1}" for j in range(self.order))

    @property
    def groups(self) -> tuple[str, ...]:
        """All radial."""
        return ("radial",) * self.order

    @property
    def powers(self) -> tuple[int, ...]:
        """Power of the angle."""
        return tuple(2 * j + 3 for j in range(self.order))

    @property
    def start(self) -> tuple[float, ...]:
        """The equidistant lens."""
        return (0.0,) * self.order

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """None."""
        return ((-np.inf, np.inf),) * self.order

    def radius(self, sine: Array, cosine: Array, k: Array) -> tuple[Array, Array]:
        """R and dR/dtheta."""
        angle = np.arctan2(sine, cosine)
        return angle * horner(k, angle**2), horner(self._rise(k), angle**2)

    def by_coefficient(self, sine: Array, cosine: Array, k: Array) -> list[Array]:  # noqa: ARG002
        """theta^3, theta^5, ..."""
        angle = np.arctan2(sine, cosine)
        return [angle**power for power in self.powers]

    def limit(self, k: Array) -> Array:
        """Where the polynomial turns back, or all around."""
        return np.minimum(np.sqrt(first_root(self._rise(k))), np.pi)

    def _rise(self, k: Array) -> Array:
        """Coefficients of dR/dtheta in powers of theta^2."""
        return k * np.array(self.powers, dtype=np.float64)
