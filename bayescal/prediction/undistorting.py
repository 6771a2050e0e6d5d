"""Undistorted pixels and photographs of a calibrated camera, a polynomial's as well as a lens's.

A polynomial says in which direction x/z, y/z each pixel looks; so a pinhole of that frame sees the
same directions without distortion. Its own is the tangent straight ahead, at x/z = y/z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.undistortion import (
    Field,
    IdealCamera,
    Seeing,
    Table,
    distort_pixels,
    ideal_camera,
    table,
    undistort_pixels,
)
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray


@dataclass(frozen=True, eq=False)
class ChosenCamera:
    """The mean of a calibrated camera's chosen model, as what takes photographs."""

    camera: CalibratedCamera

    @property
    def width(self) -> int:
        """Of the image, px."""
        return self._size[0]

    @property
    def height(self) -> int:
        """Of the image, px."""
        return self._size[1]

    @property
    def _size(self) -> tuple[int, int]:
        if self.camera.size is None:
            raise InputError("the calibration does not know the image's size: state it there")
        width, height = self.camera.size
        return round(width), round(height)

    @cached_property
    def intrinsics(self) -> Array:
        """fx, fy, cx, cy of the pinhole that it is without distortion, ``(4,)``, px."""
        ahead = self.camera.chosen.ahead
        if not ahead.calibrated:
            raise InputError(
                "straight ahead, at x/z = y/z = 0, nothing was calibrated: the polynomial has no "
                "focal length there; state a field in degrees (--field 60)"
            )
        return np.array([*np.abs(ahead.slopes), *self.camera.recorded(ahead.pixel)])

    @cached_property
    def _signs(self) -> Array:
        """What makes directions x right and y down, as recorded pixels are, ``(3,)``."""
        down = -1.0 if self.camera.c_from_bottom else 1.0
        return np.array([*(np.sign(self.camera.chosen.ahead.slopes) * [1.0, down]), 1.0])

    def rays(self, pixels: Array) -> Array:
        """Rays of recorded pixels, ``(n, 3)``; nan where there is none."""
        return self.camera.chosen.directions(self.camera.recorded(pixels)) * self._signs

    def pixels(self, rays: Array) -> tuple[Array, BoolArray]:
        """Find recorded pixels of rays, ``(n, 2)``, and whether they are seen, ``(n,)``."""
        pixels, seen = self.camera.chosen.of_directions(rays * self._signs)
        return self.camera.recorded(pixels), seen


@dataclass(frozen=True, eq=False)
class Undistortion:
    """What a camera without distortion would see in place of one that has some.

    Attributes
    ----------
    real : Seeing
        The camera that took the photographs.
    ideal : IdealCamera
        The pinhole that would have.
    """

    real: Seeing
    ideal: IdealCamera

    def pixels(self, pixels: Array) -> Array:
        """Pixels of photographs as the ideal camera has them, ``(n, 2)``; nan where none."""
        return undistort_pixels(self.real, self.ideal, np.asarray(pixels, dtype=np.float64))[0]

    def outside(self, pixels: Array) -> BoolArray:
        """Which pixels of photographs lie outside them, ``(n,)``."""
        # Pixel centres are at integers: the image reaches half a pixel beyond.
        end = np.array([self.real.width, self.real.height]) - 0.5
        return ~np.asarray(((pixels >= -0.5) & (pixels <= end)).all(axis=1))

    def distorted(self, pixels: Array) -> Array:
        """Pixels of the ideal camera as they are in photographs, ``(n, 2)``; nan where none."""
        return distort_pixels(self.real, self.ideal, np.asarray(pixels, dtype=np.float64))[0]

    @cached_property
    def table(self) -> Table:
        """Where each ideal pixel is in the photograph, for ``cv2.remap``: made once."""
        return table(self.real, self.ideal)

    def image(self, image: Any) -> Any:
        """Undistort a photograph, ``(height, width)`` or with channels; needs OpenCV.

        Raises
        ------
        InputError
            Where it is of another size, or OpenCV is missing.
        """
        from bayescal.detection.images import remapped

        height, width = image.shape[:2]
        if (width, height) != (self.real.width, self.real.height):
            raise InputError(
                f"the photograph is of {width} by {height} px, the camera of {self.real.width} by "
                f"{self.real.height}"
            )
        return remapped(image, self.table.r, self.table.c)


def undistortion(camera: CalibratedCamera, field: Field = "same") -> Undistortion:
    """Choose the ideal camera; parameters and errors as of `bayescal.undistortion`."""
    real = ChosenCamera(camera)
    return Undistortion(real, ideal_camera(real, field))
