"""Lack of fit against the spread of points that share their regressors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem, clusters, other_name, renumbered
from bayescal.rounding import counted


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


def lack_of_fit(problem: Problem, other: Array | None) -> AdequacyTest:
    """F test of the fit against pure error of true replicates."""
    shared = problem.data.regressor
    if other is not None:
        shared += f" and {other_name(shared)}"
    return _test(problem, "lack of fit, replicates", cells_of(problem.data.x, other), shared)


def lack_of_fit_scatter(problem: Problem, other: Array | None) -> AdequacyTest | None:
    """F test of the fit against points that share the axis's own regressor only.

    Its alternative is any function of that regressor. The scatter holds whatever
    depends on the other coordinate too, which only hides a lack of fit, but so
    do errors that such points share, which feign one. None where it would be the
    test with replicates over again.
    """
    cells = clusters(problem.data.x)
    if other is None or cells.max() == cells_of(problem.data.x, other).max():
        return None
    return _test(problem, "lack of fit, scatter", cells, problem.data.regressor)


def _test(problem: Problem, name: str, cells: IntArray, shared: str) -> AdequacyTest:
    if problem.unusable:
        return untested(name, problem.unusable)
    spread = spread_within(cells, problem.data.t, problem.sd)
    if spread.dof == 0:
        return untested(name, f"no replicates: no two points share {shared}")
    extra = spread.cells - problem.p
    if extra <= 0:
        return untested(
            name,
            f"nothing to miss: {counted(spread.cells, 'distinct place')} for "
            f"{problem.p} coefficients",
        )
    if spread.rss == 0:
        return AdequacyTest(
            name,
            None,
            None,
            (extra, spread.dof),
            None,
            f"{spread.dof + spread.cells} points in {counted(spread.cells, 'place')}: those that "
            f"share {shared} agree exactly, as copied or rounded readings do; they are no measure "
            "of the noise and count as independent points although they may not be.",
            concern=True,
        )
    lack = max(problem.rss - spread.rss, 0.0)
    f = lack / extra / (spread.rss / spread.dof)
    p = float(fdtrc(extra, spread.dof, f))
    sigma = math.sqrt(spread.rss / spread.dof)
    fitted = math.sqrt(problem.rss / problem.fit.dof)
    unit = problem.unit if problem.data.sd is None else "deviations"
    says = (
        f"order {problem.fit.order} misses more than noise, unless such points share errors"
        if p < 0.05
        else "the difference is no more than chance"
    )
    return AdequacyTest(
        name,
        "F",
        f,
        (extra, spread.dof),
        p,
        f"Points that share {shared} spread by {sigma:.3g} {unit} ({spread.dof} dof), the "
        f"residuals by {fitted:.3g}: {says}.",
    )
