"""What is known of the camera before it is calibrated."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from bayescal.errors import InputError
from bayescal.points.camera import StatedCamera
from bayescal.points.heading import SILENT, Heading

AXES = ("r", "c")
# Squares of numbers beyond this overflow a double somewhere downstream; no world
# coordinate is that large in any unit.
LARGEST = 1e100
# What a pixel may be, and how finely one can be known: beyond these no double tells
# a residual from rounding.
LARGEST_PX, SMALLEST_PX = 1e9, 1e-6


@dataclass(frozen=True)
class StatedPrior:
    """A normal prior for each Legendre amplitude, as a user states it.

    Attributes
    ----------
    mean, sd : tuple of float
        Means and standard deviations of b_0, b_1, ..., px.
    """

    mean: tuple[float, ...]
    sd: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", floats(self.mean))
        object.__setattr__(self, "sd", floats(self.sd))
        if len(self.mean) != len(self.sd):
            raise InputError(
                f"mean has {len(self.mean)} entries and sd {len(self.sd)}; give both for each b_j"
            )
        if not all(abs(m) <= LARGEST_PX for m in self.mean):
            raise InputError(f"every mean must be finite and at most {LARGEST_PX:g} px")
        if not all(SMALLEST_PX <= s <= LARGEST_PX for s in self.sd):
            raise InputError(f"every sd must be from {SMALLEST_PX:g} to {LARGEST_PX:g} px")


@dataclass(frozen=True)
class Setup:
    """What is known of the camera.

    Attributes
    ----------
    position : tuple of float
        Camera position x, y, z, world units; subtracted from the world points.
    width, height : float or None
        Image size, px; None where it is not known.
    c_from_bottom : bool
        Whether c is counted from the bottom: c = height - recorded row.
    assumed : tuple of str
        Which of these are assumptions rather than the source's statement.
    priors : dict of str to StatedPrior
        The user's own priors by axis.
    world_sigma : tuple of float or None
        Standard deviations of the world coordinates x, y, z, world units.
    camera : StatedCamera
        How sure the position is, the orientation and the optics, as far as stated.
    heading : Heading
        What the title block of a report says; no result depends on it.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: float | None = None
    height: float | None = None
    c_from_bottom: bool = False
    assumed: tuple[str, ...] = ()
    priors: dict[str, StatedPrior] = field(default_factory=dict)
    world_sigma: tuple[float, float, float] | None = None
    camera: StatedCamera = field(default_factory=StatedCamera)
    heading: Heading = field(default=SILENT, repr=False)

    def __post_init__(self) -> None:
        # Floats, whatever numbers they come as, so that a setup file gives back the same.
        object.__setattr__(self, "position", floats(self.position))
        for name in ("width", "height"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(getattr(self, name)))
        if self.world_sigma is not None:
            object.__setattr__(self, "world_sigma", floats(self.world_sigma))
        if not all(abs(v) < LARGEST for v in self.position):
            raise InputError(
                f"the camera position must be three finite numbers below {LARGEST:g}; correct it"
            )
        for name, size in (("width", self.width), ("height", self.height)):
            if size is not None and not 1 <= size <= LARGEST_PX:
                raise InputError(f"image {name} must be from 1 to {LARGEST_PX:g} px, not {size:g}")
        if self.world_sigma is not None and not all(0 <= s < LARGEST for s in self.world_sigma):
            raise InputError("deviations of x, y, z must be finite and not negative")
        if self.c_from_bottom and self.height is None:
            raise InputError("c counted from the bottom needs the image height; give it")

    def size(self, axis: str) -> float | None:
        """Image size along an axis, px: width for r, height for c."""
        return self.width if axis == "r" else self.height


def number(value: float) -> float:
    """Convert a number; an integer beyond every double becomes infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def floats(values: Iterable[float]) -> tuple[float, ...]:
    """Convert numbers."""
    return tuple(number(v) for v in values)
