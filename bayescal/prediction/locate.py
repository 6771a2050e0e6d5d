"""Pixels to the world: rays, points at a known depth or on a known plane, with uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, ArrayLike, IntArray
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import KEPT, BoolArray
from bayescal.prediction.given import Surface, checked
from bayescal.prediction.measuring import (
    BLOCK,
    FEW,
    PROBABILITY,
    SOURCES,
    budget,
    monte_carlo,
    summaries,
)
from bayescal.rounding import counted

MONTE_CARLO = 3 / np.sqrt(2 * KEPT)  # of an sd: three standard errors
APART = 0.05 + MONTE_CARLO  # relative difference from linear propagation that is told


@dataclass(frozen=True, eq=False)
class Location:
    """What pixels look at: points of the world, or directions where no surface is given.

    Attributes
    ----------
    values : Array
        Means, ``(n, 3)``: world units, or unit vectors; nan where there is no solution.
    sd : Array
        By Monte Carlo, ``(n, 3)``.
    linear_sd : Array
        By linear propagation, ``(n, 3)``.
    parts : dict of str to Array
        Of the linear sd: noise, coefficients, models, depth, ``(n, 3)`` each.
    lower, upper : Array
        Central interval by Monte Carlo, ``(n, 3)``; nan where fewer than 95 % of the draws have a
        solution.
    angle : Array
        Sd of the direction about each of two axes, root mean square, ``(n,)``, rad.
    count : Array
        Number of solutions inside the calibrated domain, ``(n,)``.
    share : Array
        Share of the draws that have a solution, ``(n,)``.
    extrapolated : ndarray of bool
        Which solutions lie beyond the calibrated domain or hull, ``(n,)``.
    outside : ndarray of bool
        Which pixels lie outside the image, ``(n,)``.
    surface : Surface or None
    probability : float
    """

    values: Array
    sd: Array
    linear_sd: Array
    parts: dict[str, Array]
    lower: Array
    upper: Array
    angle: Array
    count: IntArray
    share: Array
    extrapolated: BoolArray
    outside: BoolArray
    surface: Surface | None
    probability: float = PROBABILITY

    def __repr__(self) -> str:
        what = "directions" if self.surface is None else "points"
        pixels = counted(len(self.values), "pixel")
        return f"<Location: {what} of {pixels}, {int(self.found.sum())} found>"

    @property
    def found(self) -> BoolArray:
        """Which pixels have one solution, ``(n,)``."""
        return np.asarray(np.isfinite(self.values).all(axis=1))

    @property
    def nonlinear(self) -> BoolArray:
        """Where the two propagations differ by more than `APART` of the sd, ``(n,)``."""
        with np.errstate(invalid="ignore", divide="ignore"):
            apart = np.abs(self.sd - self.linear_sd) / self.sd.max(axis=1, keepdims=True)
        return np.asarray((apart > APART).any(axis=1))

    def __len__(self) -> int:
        return len(self.values)


def locate(
    camera: CalibratedCamera,
    pixels: ArrayLike,
    *,
    surface: Surface | None = None,
    average: bool | None = None,
    seed: int = 0,
) -> Location:
    """Find what pixels look at, with uncertainty; parameters and errors as of `bayescal.locate`."""
    measured = checked(pixels, 2, "pixels")
    camera = camera.average(average)
    own = camera.recorded(measured)
    step = max(1, BLOCK // len(camera.chosen.parameters.draws))
    starts = range(0, max(len(own), 1), step)
    parts = [_located(camera, own[i : i + step], surface, (seed, i)) for i in starts]
    return _joined(parts, surface)


def _located(
    camera: CalibratedCamera, pixels: Array, surface: Surface | None, seed: tuple[int, int]
) -> Location:
    """Locate pixels ``(n, 2)`` as the models count them."""
    solved = camera.chosen.solutions(pixels)
    drawn, share = monte_carlo(camera, pixels, surface, seed, _themselves)
    mean, sd, lower, upper = summaries(drawn, np.array(camera.used[1]))
    parts, linear = budget(camera, pixels, surface, _themselves)
    usable = (solved.count == 1) & (share > 0.5) & np.isfinite(linear).all(axis=1)
    for array in (mean, sd, lower, upper, linear, *parts.values()):
        array[~usable] = np.nan
    for array in (lower, upper):
        array[share < FEW] = np.nan
    turn = np.sqrt((sd**2).sum(axis=1) / 2) if surface is None else np.full(len(sd), np.nan)
    beyond, outside = usable & ~solved.inside, camera.outside(camera.recorded(pixels))
    return Location(
        mean, sd, linear, parts, lower, upper, turn, solved.count, share, beyond, outside, surface
    )


def _joined(parts: list[Location], surface: Surface | None) -> Location:
    """Put blocks of pixels one after the other."""

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    return Location(
        all_of("values"),
        all_of("sd"),
        all_of("linear_sd"),
        {name: np.concatenate([part.parts[name] for part in parts]) for name in SOURCES},
        all_of("lower"),
        all_of("upper"),
        all_of("angle"),
        np.concatenate([part.count for part in parts]),
        all_of("share"),
        np.concatenate([part.extrapolated for part in parts]),
        np.concatenate([part.outside for part in parts]),
        surface,
    )


def _themselves(points: Array) -> Array:
    return points
