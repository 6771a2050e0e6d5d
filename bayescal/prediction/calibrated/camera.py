"""The calibrated camera: what a calibration leaves behind, without its points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.prediction.calibrated.members import Member


@dataclass(frozen=True, eq=False)
class CalibratedCamera:
    """A calibrated camera: one model, or all plausible ones with their probabilities.

    Pixels are as recorded in the points file it comes from: where that counts c from the bottom,
    the models do, and pixels are turned on their way in and out.

    Attributes
    ----------
    members : tuple of Member
        The plausible models, the most probable first.
    probabilities : tuple of float
        Of each; they sum to 1.
    covered : float
        Probability that these models had among all compared.
    averaged : bool
        Whether predictions average over the members; else the first alone is used.
    size : tuple of float or None
        Image width and height, px.
    c_from_bottom : bool
    pixel_hull : Array
        Corners of the convex hull of the calibration pixels, ``(n, 2)``, px, as recorded.
    distance : float
        Median distance of the calibration points from the camera, world units.
    source : str
        Where its points came from.
    notes : tuple of str
        What was assumed.
    """

    members: tuple[Member, ...]
    probabilities: tuple[float, ...]
    covered: float
    averaged: bool
    size: tuple[float, float] | None
    c_from_bottom: bool
    pixel_hull: Array
    distance: float
    source: str
    notes: tuple[str, ...] = ()

    @property
    def chosen(self) -> Member:
        """The most probable model."""
        return self.members[0]

    @property
    def used(self) -> tuple[tuple[Member, ...], tuple[float, ...]]:
        """The models that predictions are made from, with their weights."""
        if self.averaged:
            return self.members, self.probabilities
        return self.members[:1], (1.0,)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the models."""
        return tuple(m.name for m in self.members)

    @property
    def posed(self) -> bool:
        """Whether it maps world points; a lens without a pose maps points in its own frame."""
        return all(m.posed for m in self.members)

    def average(self, average: bool | None) -> CalibratedCamera:
        """Give the camera that averages over its models, or not; None leaves it as it is."""
        return self if average is None else replace(self, averaged=average)

    def only(self, name: str) -> CalibratedCamera:
        """Give the camera with one of its models alone.

        Raises
        ------
        InputError
            Where it has no such model.
        """
        for member in self.members:
            if member.name == name:
                return replace(self, members=(member,), probabilities=(1.0,), averaged=False)
        raise InputError(f"{name!r} is none of the plausible models: {'; '.join(self.names)}")

    def recorded(self, pixels: Array) -> Array:
        """Turn pixels of the models into recorded ones, or back, ``(..., 2)``."""
        if not self.c_from_bottom:
            return pixels
        assert self.size is not None, "c is counted from a height"
        out = np.array(pixels)
        out[..., 1] = self.size[1] - out[..., 1]
        return out

    def outside(self, pixels: Array) -> NDArray[np.bool_]:
        """Which recorded pixels lie outside the image, ``(...)``; none where no size is known."""
        if self.size is None:
            return np.zeros(pixels.shape[:-1], dtype=bool)
        # Pixel centres are at integers: the image reaches half a pixel beyond.
        inside = (pixels >= -0.5) & (pixels <= np.array(self.size) - 0.5)
        return ~np.asarray(inside.all(axis=-1))

    def __repr__(self) -> str:
        models = "; ".join(
            f"{m.name} ({100 * p:.0f}%)"
            for m, p in zip(self.members, self.probabilities, strict=True)
        )
        return f"<CalibratedCamera: {models}; from {self.source}>"


def normalised(weights: Sequence[float]) -> tuple[float, ...]:
    """Weights that sum to 1."""
    total = float(sum(weights))
    return tuple(float(w) / total for w in weights)


def check_comparable(first: CalibratedCamera, second: CalibratedCamera) -> None:
    """Refuse calibrations that can't be of one camera.

    Raises
    ------
    InputError
    """
    for what, a, b in (
        ("images of {} px", _size(first), _size(second)),
        ("c counted from the {}", _end(first), _end(second)),
        ("{}", _kind(first), _kind(second)),
    ):
        if a != b:
            raise InputError(
                f"these are not two calibrations of one camera: {what.format(a)} and "
                f"{what.format(b)}"
            )


def _size(camera: CalibratedCamera) -> str:
    return "unknown size" if camera.size is None else "{:g} by {:g}".format(*camera.size)


def _end(camera: CalibratedCamera) -> str:
    return "bottom" if camera.c_from_bottom else "top"


def _kind(camera: CalibratedCamera) -> str:
    return "a camera in the world" if camera.posed else "a lens of many views"


def no_camera(result: object) -> InputError:
    """Complain that something holds no calibrated camera."""
    return InputError(
        f"a result of the kind {type(result).__name__} holds no calibrated camera; take one of "
        "compare, fit or calibrate"
    )
