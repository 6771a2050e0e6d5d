"""A fitted lens as a value: what every format is written from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, ArrayLike, frozen
from bayescal.cameras.lenses import Lens
from bayescal.cameras.lenses.fisheye import Fisheye
from bayescal.cameras.lenses.planar import Planar
from bayescal.errors import InputError

INTRINSICS = ("fx", "fy", "cx", "cy")
# OpenCV's twelve, in its order; formats take the first 4, 5, 8 or all.
SLOTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
LENGTHS = (4, 5, 8, 12)


@dataclass(frozen=True, eq=False)
class FittedCamera:
    """A lens with its numbers, and how sure they are.

    Frames are OpenCV's: x right, y down, z forward; pixel centres at integers.

    Attributes
    ----------
    lens : Lens
    intrinsics : Array
        fx, fy, cx, cy, ``(4,)``, px.
    coefficients : Array
        The lens's, in its order, ``(K,)``.
    size : tuple of int
        Width and height of the image, px.
    names : tuple of str
        Parameters of the covariance; empty where there is none.
    covariance : Array or None
        Posterior covariance of those parameters, ``(d, d)``.
    model : str
        The lens as people call it: "radial 2 + p".
    sound : bool
        Whether what it was made from converged and can be trusted.
    """

    lens: Lens
    intrinsics: Array
    coefficients: Array
    size: tuple[int, int]
    names: tuple[str, ...] = ()
    covariance: Array | None = None
    model: str = ""
    sound: bool = True

    @classmethod
    def from_arrays(
        cls,
        lens: Lens,
        intrinsics: ArrayLike,
        coefficients: ArrayLike,
        size: tuple[int, int],
        *,
        covariance: ArrayLike | None = None,
        names: Sequence[str] | None = None,
        model: str = "",
        sound: bool = True,
    ) -> FittedCamera:
        """Build a camera from arrays.

        Parameters
        ----------
        intrinsics : array_like
            fx, fy, cx, cy, ``(4,)``, px.
        coefficients : array_like
            The lens's, in the order of its names, ``(K,)``.
        size : tuple of int
            Width and height of the image, px.
        covariance : array_like, optional
            Of the parameters in `names`, ``(d, d)``.
        names : sequence of str, optional
            By default fx, fy, cx, cy and the lens's coefficients.
        model : str, optional
            The lens as people call it; its name by default.
        sound : bool, optional
            Whether what it was made from can be trusted.

        Raises
        ------
        InputError
            Where shapes disagree, a number is not finite or a name is unknown.
        """
        numbers, k = frozen(intrinsics), frozen(coefficients)
        if numbers.shape != (4,) or k.shape != (len(lens.names),):
            raise InputError(
                f"a {lens.name} lens has fx, fy, cx, cy and {len(lens.names)} coefficients, not "
                f"arrays of {numbers.shape} and {k.shape}"
            )
        known = (*INTRINSICS, *lens.names)
        stated = tuple(known if names is None else names) if covariance is not None else ()
        spread = None if covariance is None else frozen(covariance)
        if spread is not None and spread.shape != (len(stated), len(stated)):
            raise InputError(f"covariance must be {len(stated)} by {len(stated)}, as names are")
        if not set(stated) <= set(known):
            raise InputError(f"parameters of a {lens.name} lens are {', '.join(known)}")
        for array in (numbers, k, *(() if spread is None else (spread,))):
            if not np.isfinite(array).all():
                raise InputError("a camera's numbers must be finite")
        if not (numbers[:2] > 0).all() or min(size) < 1:
            raise InputError("focal lengths and the image size must be positive")
        whole = (int(size[0]), int(size[1]))
        return cls(lens, numbers, k, whole, stated, spread, model or lens.name, sound)

    @property
    def matrix(self) -> Array:
        """fx, fy, cx, cy in place, ``(3, 3)``, px."""
        fx, fy, cx, cy = self.intrinsics.tolist()
        return frozen([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])

    def about(self) -> str:
        """Say in a line what it is."""
        trust = "" if self.sound else "; NOT SOUND: see the run it was made from"
        return f"bayescal: {self.model}, posterior mean{trust}"


def slots(lens: Lens) -> tuple[int, ...] | None:
    """Places of a lens's coefficients among OpenCV's twelve; None where it is no lens of those."""
    if not isinstance(lens, Planar) or lens.step != 2:
        return None
    if lens.numerator > 3 or lens.denominator > 3:
        return None  # OpenCV's k4 stands below the line
    return tuple(SLOTS.index(name) for name in lens.names)


def shortest(lens: Lens) -> int | None:
    """Least number of OpenCV's coefficients that hold a lens; None where none do."""
    places = slots(lens)
    return None if places is None else next(n for n in LENGTHS if n > max(places, default=-1))


def filled(camera: FittedCamera, length: int) -> list[float]:
    """OpenCV's first coefficients, so many, those the lens lacks being zero."""
    places = slots(camera.lens)
    assert places is not None, "asked of a lens that has them"
    values = [0.0] * length
    for place, value in zip(places, camera.coefficients.tolist(), strict=True):
        values[place] = value
    return values


def fisheye(camera: FittedCamera, length: int = 4) -> list[float]:
    """k1 to k4 of a fisheye, those it lacks being zero."""
    values = camera.coefficients.tolist()
    return [*values, *[0.0] * (length - len(values))]


def is_fisheye(lens: Lens, most: int = 4) -> bool:
    """Whether it is a polynomial of the angle with so many coefficients at most."""
    return isinstance(lens, Fisheye) and lens.order <= most
