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
from bayescal.prediction.calibrated.inverse import continued, monotone
from bayescal.prediction.calibrated.members import BoolArray, LensMember, PolynomialMember
from bayescal.prediction.calibrated.slopes import with_slopes


@dataclass(frozen=True, eq=False)
class ChosenCamera:
    """The mean of a calibrated camera's chosen model, as what takes photographs.

    Attributes
    ----------
    camera : CalibratedCamera
    """

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
        member, flip = self.camera.chosen, self.camera.c_from_bottom
        if isinstance(member, LensMember):
            fx, fy, cx, cy = member.intrinsics(member.parameters.mean[None])[0][0]
            return np.array([fx, fy, cx, self.camera.recorded(np.array([cx, cy]))[1]])
        ahead, slopes = self._ahead
        if not member.covered(self._straight):
            raise InputError(
                "straight ahead, at x/z = y/z = 0, nothing was calibrated: the polynomial has no "
                "focal length there; state a field in degrees (--field 60)"
            )
        return np.array([*np.abs(slopes), *(self.camera.recorded(ahead) if flip else ahead)])

    @cached_property
    def _ahead(self) -> tuple[Array, Array]:
        """Pixel of x/z = y/z = 0, and slopes of r and c there, px."""
        member = self._polynomial
        mean = member.parameters.mean[None]
        scaled = np.array([d.scale(np.zeros(1))[0] for d in member.domains])
        value, slope = with_slopes(member, mean, scaled[None, None])
        half = np.array([d.half_range for d in member.domains])
        return value[0, 0], np.diagonal(slope[0, 0]) / half

    @property
    def _straight(self) -> Array:
        member = self._polynomial
        at = member.positions(member.parameters.mean[None])[0]
        return np.asarray(at + np.array([0.0, 0.0, member.side]))[None]

    @property
    def _polynomial(self) -> PolynomialMember:
        assert isinstance(self.camera.chosen, PolynomialMember), "a lens has its own numbers"
        return self.camera.chosen

    @cached_property
    def _signs(self) -> Array:
        """What makes directions x right and y down, as recorded pixels are, ``(2,)``."""
        down = -1.0 if self.camera.c_from_bottom else 1.0
        if isinstance(self.camera.chosen, LensMember):
            return np.array([1.0, down])
        return np.asarray(np.sign(self._ahead[1]) * np.array([1.0, down]))

    def rays(self, pixels: Array) -> Array:
        """Rays of recorded pixels, ``(n, 3)``; nan where there is none."""
        member, own = self.camera.chosen, self.camera.recorded(pixels)
        if isinstance(member, LensMember):
            intrinsics, k = member.intrinsics(member.parameters.mean[None])
            found = member.lens.undistort((own - intrinsics[0, 2:]) / intrinsics[0, :2], k[0])
            return np.asarray(found.rays * np.array([*self._signs, 1.0]))
        member = self._polynomial
        scaled, ok = continued(member, own)
        ratios = [
            d.middle + d.half_range * s for d, s in zip(member.domains, scaled.T, strict=True)
        ]
        rays = np.stack([*ratios, np.ones(len(own))], axis=1)
        rays[~ok] = np.nan
        return np.asarray(rays * np.array([*self._signs, 1.0]))

    def pixels(self, rays: Array) -> tuple[Array, BoolArray]:
        """Find recorded pixels of rays, ``(n, 2)``, and whether they are seen, ``(n,)``."""
        member = self.camera.chosen
        turned = rays * np.array([*self._signs, 1.0])
        if isinstance(member, LensMember):
            intrinsics, k = member.intrinsics(member.parameters.mean[None])
            plane = member.lens.distort(turned, k[0])
            pixels = intrinsics[0, 2:] + intrinsics[0, :2] * plane
            return self.camera.recorded(pixels), member.lens.seen(turned, k[0])
        member = self._polynomial
        ratios = turned[:, :2] / turned[:, 2:]
        scaled = np.column_stack(
            [d.scale(s) for d, s in zip(member.domains, ratios.T, strict=True)]
        )
        pixels = member.at_scaled(member.parameters.mean[None], scaled[None])[0]
        return self.camera.recorded(pixels), monotone(member, scaled)


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
    """Choose the ideal camera of a calibrated one's most probable model; parameters as above."""
    real = ChosenCamera(camera)
    return Undistortion(real, ideal_camera(real, field))
