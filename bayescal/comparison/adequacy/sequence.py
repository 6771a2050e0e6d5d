"""Runs of signs along the regressor: what a polynomial of too low an order leaves."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import erfc

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.null import simulated_residuals, two_sided
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import DETERMINED, Problem
from bayescal.linear.replicates import clusters
from bayescal.rounding import counted

NAME = "runs along the regressor"


def runs_test(
    problem: Problem, rng: np.random.Generator, simulations: int | None = None
) -> AdequacyTest:
    """Test whether residuals keep their sign for too long along the regressor, or not enough.

    Points that share the regressor have no order among themselves: their weighted
    mean counts as one. The p-value is simulated with the design up to 400 places,
    since p fitted coefficients make signs alternate more than Wald & Wolfowitz (1940)
    assume; beyond, it is their normal approximation. Both tails.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    places = clusters(problem.data.x)
    # The fit sees the means only: they are its points, and this is its design.
    q = tie_means(problem, places, problem.q.T).T
    kept = np.flatnonzero(1 - (q**2).sum(axis=1) > DETERMINED)
    if len(kept) - problem.p < 1 or len(kept) < 3:
        return untested(
            NAME,
            f"too few distinct {problem.data.regressor}, {int(places.max()) + 1}, for "
            f"{problem.p} coefficients",
        )
    signs = _signs(tie_means(problem, places, problem.e)[kept])
    count = int(1 + (signs[1:] != signs[:-1]).sum())
    mean, sd = wald_wolfowitz(int(signs.sum()), int((~signs).sum()))
    null = simulated_residuals(q, rng, simulations)
    if null is not None:
        simulated = _signs(null[:, kept])
        runs = 1.0 + (simulated[:, 1:] != simulated[:, :-1]).sum(axis=1)
        mean, p = float(runs.mean()), two_sided(runs, float(count))
        how = f"simulated with the fit's own design, {len(null)} times"
    elif sd > 0:
        p = float(erfc(abs(count - mean) / sd / math.sqrt(2)))
        how = "normal approximation"
    else:
        return untested(NAME, "all residuals have one sign")
    few = count < mean
    if p >= 0.05:
        says = "as chance would have it"
    elif few:
        says = "errors keep their sign, as a polynomial of too low an order leaves them"
    else:
        says = "errors alternate, as an order too high or averaged readings leave them"
    return AdequacyTest(
        NAME,
        "runs",
        float(count),
        None,
        p,
        f"{counted(count, 'run')} of sign over {len(kept)} distinct {problem.data.regressor}, "
        f"{mean:.1f} expected ({how}): {says}.",
    )


def wald_wolfowitz(positive: int, negative: int) -> tuple[float, float]:
    """Mean and sd of the number of runs (Wald & Wolfowitz 1940, Ann. Math. Stat. 11, 147)."""
    n, twice = positive + negative, 2 * positive * negative
    if n < 2:
        return 1.0, 0.0
    return 1 + twice / n, math.sqrt(twice * (twice - n) / (n * n * (n - 1)))


def tie_means(problem: Problem, places: IntArray, residuals: Array) -> Array:
    """Mean weighted residual of the points at each place, over its own noise.

    Parameters
    ----------
    places : IntArray
        Number of each point's place, ``(n_points,)``.
    residuals : Array
        Weighted, ``(n_points,)`` or ``(m, n_points)``.

    Returns
    -------
    Array
        ``(n_places,)`` or ``(m, n_places)``; of unit variance where residuals are
        independent of unit variance.
    """
    order = np.argsort(places, kind="stable")
    starts = np.flatnonzero(np.append(True, np.diff(places[order]) > 0))
    weights = 1 / problem.sd[order]
    sums = np.add.reduceat((residuals[..., order] * weights), starts, axis=-1)
    means: Array = sums / np.sqrt(np.add.reduceat(weights**2, starts))
    return means


def _signs(values: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return values > 0
