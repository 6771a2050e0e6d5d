"""Pixels and images as a camera without distortion would have them.

That *ideal* camera looks the same way and is a pinhole: its pixel of a direction (x, y, z) is
fx x/z + cx, fy y/z + cy. A table says for each of its pixels where to look in the photograph, so
that an image is undistorted by interpolation; it belongs to the camera, not to the image.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.errors import InputError

Field: TypeAlias = Literal["same", "inside", "full"] | float
ROWS = 64  # of a table made at once: some 10 MB of what is needed in between
WIDEST = 175.0  # degrees


class Seeing(Protocol):
    """What takes photographs: directions in a frame x right, y down, z forward, and their pixels.

    `intrinsics` are those of the pinhole that it is without distortion.
    """

    @property
    def intrinsics(self) -> Array: ...  # noqa: D102
    @property
    def width(self) -> int: ...  # noqa: D102
    @property
    def height(self) -> int: ...  # noqa: D102

    def rays(self, pixels: Array) -> Array:
        """Rays of pixels ``(n, 2)``, ``(n, 3)``; nan where there is none."""

    def pixels(self, rays: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Pixels of rays, ``(n, 2)``, and whether they are seen, ``(n,)``."""


@dataclass(frozen=True, eq=False)
class RealCamera:
    """A camera with its numbers, and the size of its images.

    Attributes
    ----------
    intrinsics : Array
        fx, fy, cx, cy, ``(4,)``, px.
    k : Array
        Coefficients of the lens, ``(K,)``.
    width, height : int
        Px.
    """

    camera: Camera
    intrinsics: Array
    k: Array
    width: int
    height: int

    def rays(self, pixels: Array) -> Array:
        """Rays of pixels, ``(n, 3)``; nan where there is none."""
        return self.camera.rays(self.intrinsics, self.k, pixels).rays

    def pixels(self, rays: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Pixels of rays, ``(n, 2)``, and whether they are seen, ``(n,)``."""
        seen = self.camera.lens.seen(rays, self.k)
        return self.camera.pixels(self.intrinsics, self.k, rays), seen


@dataclass(frozen=True, eq=False)
class IdealCamera:
    """A pinhole.

    Attributes
    ----------
    intrinsics : Array
        fx, fy, cx, cy, ``(4,)``, px.
    width, height : int
        Px.
    """

    intrinsics: Array
    width: int
    height: int

    def pixels(self, rays: Array) -> Array:
        """Pixels of rays, ``(..., 2)``, px; nan where a ray does not come from in front."""
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = np.where(rays[..., 2:] > 0, rays[..., :2] / rays[..., 2:], np.nan)
        return np.asarray(self.intrinsics[2:] + self.intrinsics[:2] * plane)

    def rays(self, pixels: Array) -> Array:
        """Rays of pixels, with z = 1, ``(..., 3)``."""
        plane = (pixels - self.intrinsics[2:]) / self.intrinsics[:2]
        return np.concatenate([plane, np.ones_like(plane[..., :1])], axis=-1)


@dataclass(frozen=True, eq=False)
class Table:
    """Where each pixel of the ideal image is in the photograph.

    Attributes
    ----------
    r, c : ndarray of float32
        As ``cv2.remap`` takes them, ``(height, width)``, px; -1e6 where `seen` is false.
    seen : ndarray of bool
        Whether the lens sees that direction, ``(height, width)``.
    """

    r: NDArray[np.float32]
    c: NDArray[np.float32]
    seen: NDArray[np.bool_]


def ideal_camera(real: Seeing, field: Field = "same") -> IdealCamera:
    """Choose what the ideal camera sees.

    Parameters
    ----------
    field : {"same", "inside", "full"} or float
        The same intrinsics; as much as leaves no pixel without an image; as much as loses no pixel
        of the photograph; or so many degrees from left to right, about the photograph's axis.

    Returns
    -------
    IdealCamera
        Of the photograph's size.

    Raises
    ------
    InputError
        Where no such pinhole exists: parts of the photograph lie 90 degrees or more from the axis,
        or beyond where the lens turns back.
    """
    width, height = real.width, real.height
    if not isinstance(field, str):
        if not 0 < field <= WIDEST:
            raise InputError(f"a field of {field:g} degrees: use more than 0 and up to {WIDEST:g}")
        across = (width - 1) / 2
        focal = across / math.tan(math.radians(field) / 2)
        return IdealCamera(np.array([focal, focal, across, (height - 1) / 2]), width, height)
    if field == "same":
        return IdealCamera(real.intrinsics, width, height)
    left, right, top, bottom = (_plane(real, edge) for edge in _edges(width, height))
    if field == "full":
        every = np.concatenate([left, right, top, bottom])
        low, high = every.min(axis=0), every.max(axis=0)
    else:
        low = np.array([left[:, 0].max(), top[:, 1].max()])
        high = np.array([right[:, 0].min(), bottom[:, 1].min()])
    if not (np.isfinite(low) & np.isfinite(high) & (low < high)).all():
        raise InputError(
            "some edges of the photograph look 90 degrees or more aside, or beyond where the lens "
            "turns back: no pinhole sees them; state a field in degrees"
        )
    sides = np.array([width, height]) - 1.0
    scales = sides / (high - low) / real.intrinsics[:2]
    # One scale for both sides: pixels keep their shape.
    focal = real.intrinsics[:2] * (scales.min() if field == "full" else scales.max())
    centre = sides / 2 - focal * (low + high) / 2
    return IdealCamera(np.concatenate([focal, centre]), width, height)


def undistort_pixels(
    real: Seeing, ideal: IdealCamera, pixels: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Pixels of a photograph as the ideal camera has them, and whether they exist.

    Parameters
    ----------
    pixels : Array
        ``(n, 2)``, px.

    Returns
    -------
    pixels : Array
        ``(n, 2)``, px; nan where there is none.
    found : ndarray of bool
        ``(n,)``.
    """
    out = ideal.pixels(real.rays(pixels))
    return out, np.isfinite(out).all(axis=-1)


def distort_pixels(
    real: Seeing, ideal: IdealCamera, pixels: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Pixels of the ideal camera as they are in the photograph; the inverse of the above."""
    out, seen = real.pixels(ideal.rays(pixels))
    return np.where(seen[..., None], out, np.nan), seen


def table(real: Seeing, ideal: IdealCamera) -> Table:
    """Make the table that undistorts images of a camera, some rows at a time."""
    shape = (ideal.height, ideal.width)
    r, c = np.empty(shape, dtype=np.float32), np.empty(shape, dtype=np.float32)
    seen = np.empty(shape, dtype=bool)
    for start in range(0, ideal.height, ROWS):
        rows = np.arange(start, min(start + ROWS, ideal.height))
        grid = np.stack(np.meshgrid(np.arange(ideal.width), rows), axis=-1).astype(np.float64)
        found, part = distort_pixels(real, ideal, grid.reshape(-1, 2))
        at = np.where(part[:, None], found, -1e6).reshape(*grid.shape)
        r[rows], c[rows], seen[rows] = at[..., 0], at[..., 1], part.reshape(len(rows), -1)
    return Table(r, c, seen)


def _plane(real: Seeing, pixels: Array) -> Array:
    """Plane coordinates x/z, y/z of pixels, ``(n, 2)``; nan where there are none."""
    unit = IdealCamera(np.array([1.0, 1.0, 0.0, 0.0]), 1, 1)
    return undistort_pixels(real, unit, pixels)[0]


def _edges(width: int, height: int) -> Iterator[Array]:
    """Centres of the pixels along the left, right, top and bottom edge, ``(n, 2)``."""
    rows, columns = np.arange(float(height)), np.arange(float(width))
    for r in (0.0, width - 1.0):
        yield np.column_stack([np.full(height, r), rows])
    for c in (0.0, height - 1.0):
        yield np.column_stack([columns, np.full(width, c)])
