"""Distances between what two pixels look at, with expanded uncertainty and its budget.

U = k u with k such that the interval d ± U holds 95 % of the Monte Carlo draws (JCGM 100:2008,
6.2; JCGM 101:2008, 7.7): no number of degrees of freedom is assumed. A draw without a distance
counts as outside, and where more than 5 % are such there is no U. The errors of the lens and of the
surface are shared by both ends, and largely cancel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.given import Surface, checked
from bayescal.prediction.measuring import (
    BLOCK,
    FEW,
    PROBABILITY,
    SOURCES,
    budget,
    monte_carlo,
    summaries,
    weighted_quantile,
)
from bayescal.rounding import counted

# Ends 2.45 sd of their difference apart, as far as 95 % of measurements of one point lie from each
# other, have over the noise of the draws a mean of 2.8 deviations (Rice's distribution).
APART_BY = 2.8


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of pairs; nan where an end has no solution, or several.

    Attributes
    ----------
    values : Array
        Means, ``(n,)``, world units.
    u : Array
        Standard uncertainty by Monte Carlo, ``(n,)``.
    linear_u : Array
        By linear propagation, ``(n,)``.
    expanded : Array
        U, ``(n,)``; nan where fewer than 95 % of the draws have a distance.
    expanded_error : Array
        Standard error of U by the number of draws, ``(n,)``.
    share : Array
        Share of the draws that have a distance, ``(n,)``.
    parts : dict of str to Array
        Of `linear_u`: noise, coefficients, models, depth, ``(n,)`` each.
    probability : float
        Coverage probability of U.
    """

    values: Array
    u: Array
    linear_u: Array
    expanded: Array
    expanded_error: Array
    share: Array
    parts: dict[str, Array]
    probability: float = PROBABILITY

    def __repr__(self) -> str:
        told = f"{int(self.found.sum())} found, {int(self.certain.sum())} with U"
        return f"<Distances of {counted(len(self.values), 'pair')}: {told}>"

    @property
    def found(self) -> BoolArray:
        """Which pairs have a distance, ``(n,)``."""
        return np.isfinite(self.values)

    @property
    def certain(self) -> BoolArray:
        """Which pairs have an expanded uncertainty, ``(n,)``."""
        return np.isfinite(self.expanded)

    @property
    def apart(self) -> BoolArray:
        """Which distances are told from 0, ``(n,)``: two measurements of one point are closer."""
        return np.asarray(self.values > APART_BY * self.u)

    @property
    def k(self) -> Array:
        """Coverage factor U / u, ``(n,)``."""
        return self.expanded / self.u

    def __len__(self) -> int:
        return len(self.values)


def distances(
    camera: CalibratedCamera,
    first: ArrayLike,
    second: ArrayLike,
    surface: Surface | None,
    *,
    average: bool | None = None,
    seed: int = 0,
) -> Distances:
    """Measure distances on a surface; parameters and errors as of `bayescal.distances`."""
    if surface is None:
        raise InputError("distances need a depth or a plane: a pixel alone is a direction")
    ends = [checked(first, 2, "first"), checked(second, 2, "second")]
    if len(ends[0]) != len(ends[1]):
        raise InputError(f"pairs need both ends: {len(ends[0])} and {len(ends[1])} are given")
    camera = camera.average(average)
    own = [camera.recorded(end) for end in ends]
    step = max(1, BLOCK // (2 * len(camera.chosen.parameters.draws)))
    starts = range(0, max(len(own[0]), 1), step)
    rows = [
        _block(camera, np.concatenate([end[i : i + step] for end in own]), surface, (seed, i))
        for i in starts
    ]
    values, u, linear, expanded, error, share, *parts = (
        np.concatenate(column) for column in zip(*rows, strict=True)
    )
    budgeted = dict(zip(SOURCES, parts, strict=True))
    return Distances(values, u, linear, expanded, error, share, budgeted)


def _block(
    camera: CalibratedCamera, pixels: Array, surface: Surface, seed: tuple[int, int]
) -> list[Array]:
    """Distances of pixels whose first half are the one ends: as `Distances` has them."""
    weights = np.array(camera.used[1])
    drawn, share = monte_carlo(camera, pixels, surface, seed, _lengths)
    mean, sd, _, _ = summaries(drawn, weights)
    expanded, error = _expanded(np.abs(drawn[..., 0] - mean[:, 0]), weights)
    expanded = np.where(share >= FEW, expanded, np.nan)
    parts, linear = budget(camera, pixels, surface, _lengths)
    count = camera.chosen.solutions(pixels).count.reshape(2, -1)
    usable = (count == 1).all(axis=0) & (share > 0.5) & np.isfinite(linear[:, 0])
    spreads = (linear, *(parts[name] for name in SOURCES))
    first, *rest = (row[:, 0] for row in spreads)
    rows = [mean[:, 0], sd[:, 0], first, expanded, error, share, *rest]
    return [np.where(usable, row, np.nan) for row in rows]


def _expanded(away: Array, weights: Array) -> tuple[Array, Array]:
    """Half-width that holds 95 % of draws ``(models, draws, q)``, and its standard error.

    The error is half the distance of the order statistics one binomial deviation off.
    """
    each = np.repeat(weights / away.shape[1], away.shape[1])
    flat = np.where(np.isfinite(away), away, np.inf).reshape(len(each), -1)
    one = np.sqrt(PROBABILITY * (1 - PROBABILITY) * (each**2).sum())
    share = np.broadcast_to(each[:, None], flat.shape)
    low, middle, high = (
        weighted_quantile(flat, share, PROBABILITY + step) for step in (-one, 0.0, one)
    )
    with np.errstate(invalid="ignore"):
        return middle, np.where(np.isfinite(high), (high - low) / 2, middle - low)


def _lengths(points: Array) -> Array:
    """Distances between the halves of points ``(m, 2 q, 3)``, ``(m, q, 1)``."""
    half = points.shape[1] // 2
    apart = points[:, :half] - points[:, half:]
    return np.asarray(np.sqrt((apart**2).sum(axis=2, keepdims=True)))
