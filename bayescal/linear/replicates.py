"""Points that share their regressors, and the noise that their spread measures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.polynomials.basis import SAME_REGRESSOR


@dataclass(frozen=True)
class Spread:
    """Pooled spread within cells of points: sum of squares, its dof, number of cells."""

    rss: float
    dof: int
    cells: int


def cells_of(x: Array, other: Array | None) -> IntArray:
    """Give a number to points that share x (and `other`) to within 1e-9 of the domains."""
    cells = clusters(x)
    if other is None:
        return cells
    second = clusters(other)
    return renumbered(cells * (int(second.max()) + 1) + second)


def spread_within(cells: IntArray, t: Array, sd: Array) -> Spread:
    """Weighted squares of t about the mean of its cell.

    Rounding of the means, 8 eps max|t| per point, counts as no spread at all.
    """
    d = within_cells(cells, t, sd)
    rss = float(d @ d)
    floor = 8 * np.finfo(float).eps * float(np.abs(t / sd).max())
    count = int(cells.max()) + 1
    return Spread(rss if rss > len(t) * floor**2 else 0.0, len(t) - count, count)


def within_cells(cells: IntArray, values: Array, sd: Array) -> Array:
    """Weighted deviations of values from the weighted mean of their cell, ``(n_points,)``."""
    weights = 1 / sd**2
    shifted = values - values[0]  # so that the size of the values costs no digits
    means = np.bincount(cells, weights * shifted) / np.bincount(cells, weights)
    deviations: Array = (shifted - means[cells]) / sd
    return deviations


def pure_error(
    x: Array, other: Array | None, t: Array, sd: Array | None = None
) -> tuple[float | None, int]:
    """Noise level from true replicates (Draper & Smith 1998, 2.1).

    Replicates share every regressor of the family, to within 1e-9 of its domain.

    Parameters
    ----------
    x : Array
        The axis's regressor, ``(n_points,)``.
    other : Array or None
        The other axis's regressor; None for a generic problem.
    t : Array
        Measured pixels, ``(n_points,)``, px.
    sd : Array, optional
        Known deviations, ``(n_points,)``, px.

    Returns
    -------
    sigma : float or None
        px (with known deviations: a factor on them); None without replicates.
    dof : int
        Number of points less number of distinct places.
    """
    found = spread_within(cells_of(x, other), t, np.ones(len(t)) if sd is None else sd)
    return (math.sqrt(found.rss / found.dof), found.dof) if found.dof else (None, 0)


def clusters(values: Array) -> IntArray:
    """Give a number to values that are the same to within 1e-9 of their span, from 0."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    rounding = 8 * np.finfo(float).eps * float(np.abs(values).max())
    step = np.diff(ordered) > max(SAME_REGRESSOR * (ordered[-1] - ordered[0]), rounding)
    numbers = np.empty(len(values), dtype=np.intp)
    numbers[order] = np.concatenate([[0], np.cumsum(step)])
    return numbers


def renumbered(keys: IntArray) -> IntArray:
    """Give distinct keys numbers from 0."""
    return np.unique(keys, return_inverse=True)[1].astype(np.intp)
