"""Lack of fit against the spread of points that share their regressors."""

from __future__ import annotations

import math

from scipy.special import fdtrc

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem, other_name
from bayescal.linear.replicates import cells_of, clusters, spread_within
from bayescal.rounding import counted, significant


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
    fitted = math.sqrt(problem.rss / problem.dof)
    unit = problem.unit if problem.data.sd is None else "deviations"
    says = (
        f"{problem.what} leaves more than noise, unless such points share errors"
        if p < 0.05
        else "the difference is no more than chance"
    )
    return AdequacyTest(
        name,
        "F",
        f,
        (extra, spread.dof),
        p,
        f"Points that share {shared} spread by {significant(sigma, 3)} {unit} ({spread.dof} dof), "
        f"the residuals by {significant(fitted, 3)}: {says}.",
    )
