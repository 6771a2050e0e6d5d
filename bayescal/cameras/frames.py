r"""Between the frame of a points file and OpenCV's: the one place that knows of left hands.

OpenCV's frames are right-handed, x right, y down, z forward, with rows from the image's top. Where
a file counts c from the bottom, as the thesis does, its world and its camera have y up: a
left-handed frame, OpenCV's seen in a mirror. With M = diag(1, -1, 1) there,

    x' = M x,    c' = height - c,    R' = M R M,    t' = -M R C,

and M = 1, c' = c elsewhere. Focal lengths and radial coefficients are the same on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.points.setup import Setup


@dataclass(frozen=True)
class Frame:
    """The frame of a points file.

    Attributes
    ----------
    height : float or None
        Of the image, px, where c counts from its bottom; None where the frame is OpenCV's.
    """

    height: float | None

    @classmethod
    def of(cls, setup: Setup) -> Frame:
        """Give the frame of a setup."""
        return cls(setup.height if setup.c_from_bottom else None)

    @property
    def mirror(self) -> Array:
        """Diagonal of M, ``(3,)``."""
        return np.array([1.0, 1.0 if self.height is None else -1.0, 1.0])

    def points(self, points: Array) -> Array:
        """World points in the other frame, ``(..., 3)``."""
        return points * self.mirror

    def pixels(self, pixels: Array) -> Array:
        """Pixels r, c of the other frame, ``(..., 2)``, px."""
        if self.height is None:
            return pixels
        return np.stack([pixels[..., 0], self.height - pixels[..., 1]], axis=-1)

    def pose(self, rotation: Array, position: Array) -> tuple[Array, Array]:
        """OpenCV's R' and t' of R ``(..., 3, 3)`` and the camera's position C ``(..., 3)``."""
        turned = self.mirror[:, None] * rotation * self.mirror
        return turned, -self.mirror * np.einsum("...ij,...j->...i", rotation, position)
