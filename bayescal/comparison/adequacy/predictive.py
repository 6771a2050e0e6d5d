"""Posterior predictive checks: whether data drawn from the posterior look like these."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc, fdtri, log_ndtr, ndtr, ndtri

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.sequence import tie_means
from bayescal.linear.replicates import clusters

NAME = "posterior predictive"
NUMBERS = 400_000  # standardised residuals over all draws used
FEWEST, MOST = 100, 4000  # draws used
CHUNK = 2_000_000  # standardised residuals held at a time
SIMULATED_PLACES = 1000  # beyond, the lag-1 autocorrelation of noise is normal
# A ppp this small (or, where both sides count, half of it from 0 or 1) is a concern.
# It is not uniform under the model but crowds around 1/2; below a it falls with a
# probability of at most 2a (Meng 1994, Ann. Statist. 22, 1142).
EXTREME = 0.01


@dataclass(frozen=True)
class Discrepancy:
    """A statistic of standardised residuals and its law in replicated data.

    Attributes
    ----------
    of : callable
        Standardised residuals ``(m, n_points)`` to the statistic ``(m,)``.
    tail : callable
        Probability that a replicate's is at least as large, ``(m,)`` to ``(m,)``.
    typical : float
        Its median in replicates.
    two_sided : bool
        Whether small values are a concern too.
    """

    name: str
    of: Callable[[Array], Array]
    tail: Callable[[Array], Array]
    typical: float
    two_sided: bool


def posterior_predictive(
    problem: Problem, draws: Array | None, rng: np.random.Generator
) -> tuple[AdequacyTest, ...]:
    """Posterior predictive p-values of three discrepancies.

    For each draw theta the standardised residuals (t - f(theta)) / sigma of the data are
    compared with those of data replicated from the same draw (Gelman, Meng & Stern
    1996, Stat. Sinica 6, 733). The replicate's are standard normal whatever theta is,
    so that the probability of exceeding the data's is averaged over the draws
    instead of being counted, which leaves a smaller Monte Carlo error. The ppp is
    not uniform under the model, and not among the p-values that are adjusted for
    multiplicity.

    Parameters
    ----------
    draws : Array or None
        ``(n_draws, m)``: monomial coefficients, px, then sigma, px, where it is
        inferred; further columns are ignored.
    """
    if draws is None or len(draws) == 0:
        return (untested(NAME, "no draws are given"),)
    if problem.exact:
        return (untested(NAME, "the fit is exact, the residuals are rounding only"),)
    if _digits_lost(problem, draws):
        return (untested(NAME, "monomials this far off centre cost the draws too many digits"),)
    discrepancies = _discrepancies(problem, rng)
    wanted = min(max(NUMBERS // problem.n, FEWEST), MOST, len(draws))
    used = draws[np.linspace(0, len(draws) - 1, wanted).astype(np.intp)]
    found: list[list[Array]] = []
    step = max(CHUNK // problem.n, 1)
    for start in range(0, wanted, step):
        z = _standardised(problem, used[start : start + step])
        found.append([discrepancy.of(z) for discrepancy in discrepancies])
    observed = [np.concatenate(parts) for parts in zip(*found, strict=True)]
    return tuple(_outcome(d, values) for d, values in zip(discrepancies, observed, strict=True))


def _discrepancies(problem: Problem, rng: np.random.Generator) -> list[Discrepancy]:
    n, regressor = problem.n, problem.data.regressor
    found = [
        Discrepancy(
            "largest |z|",
            lambda z: np.abs(z).max(axis=1),
            lambda a: tail_of_largest(a, n),
            float(ndtri((1 + 0.5 ** (1 / n)) / 2)),
            False,
        )
    ]
    places = clusters(problem.data.x)
    count = int(places.max()) + 1
    if count >= 3:
        found.append(
            Discrepancy(
                f"lag-1 along {regressor}",
                lambda z: lag_one(tie_means(problem, places, z)),
                _tail_of_lag_one(count, rng),
                0.0,
                True,
            )
        )
    distance = np.abs(problem.s)
    outer = distance > np.median(distance) * (1 + 1e-9)
    n_outer = int(outer.sum())
    n_inner = n - n_outer
    if n_outer > 1 and n_inner > 1:

        def ratio(z: Array) -> Array:
            squares = z**2
            high, low = squares[:, outer].mean(axis=1), squares[:, ~outer].mean(axis=1)
            quotient: Array = np.sqrt(high / low)
            return quotient

        found.append(
            Discrepancy(
                "spread outer/inner",
                ratio,
                lambda q: np.asarray(fdtrc(n_outer, n_inner, q**2)),
                math.sqrt(float(fdtri(n_outer, n_inner, 0.5))),
                True,
            )
        )
    return found


def tail_of_largest(value: Array, n: int) -> Array:
    """Probability that the largest of n standard normals in size is at least `value`."""
    # 1 - (1 - 2 Q)^n, Q the upper tail, without cancellation.
    tail: Array = -np.expm1(n * np.log1p(-np.minimum(2 * ndtr(-value), 1 - 1e-16)))
    return tail


def lag_one(values: Array) -> Array:
    """Uncentred lag-1 autocorrelation of each row, ``(m, k)`` to ``(m,)``."""
    products: Array = (values[:, 1:] * values[:, :-1]).sum(axis=1) / (values**2).sum(axis=1)
    return products


def _tail_of_lag_one(count: int, rng: np.random.Generator) -> Callable[[Array], Array]:
    """Upper tail of the lag-1 autocorrelation of `count` standard normals."""
    if count > SIMULATED_PLACES:
        sd = math.sqrt((count - 1) / count / (count + 2))  # exact; the shape is normal by then
        return lambda value: np.exp(log_ndtr(-value / sd))
    size = max(NUMBERS // count, MOST)
    pool = np.sort(lag_one(rng.standard_normal((size, count))))
    return lambda value: 1 - np.searchsorted(pool, value) / size


def _standardised(problem: Problem, draws: Array) -> Array:
    """Standardised residuals of the data at each draw, ``(n_draws, n_points)``."""
    powers = np.vander(problem.data.x, problem.p, increasing=True)
    residuals: Array = problem.data.t - draws[:, : problem.p] @ powers.T
    residuals /= problem.sd
    residuals /= draws[:, problem.p, None] if problem.noise.value is None else problem.noise.value
    return residuals


def _digits_lost(problem: Problem, draws: Array) -> bool:
    """Whether rounding of monomial coefficients is felt beside sigma."""
    with np.errstate(over="ignore", invalid="ignore"):
        largest = np.abs(problem.data.x).max() ** np.arange(problem.p)
        size = float((np.abs(draws[:, : problem.p]).max(axis=0) * largest).max())
    sigma = problem.noise.value
    smallest = float(draws[:, problem.p].min()) if sigma is None else sigma
    # Each of p terms was rounded, in the coefficient and in the power.
    lost = np.finfo(float).eps * problem.p * size
    return not lost < 1e-3 * smallest * float(problem.sd.min())


def _outcome(discrepancy: Discrepancy, observed: Array) -> AdequacyTest:
    count = len(observed)
    tails = discrepancy.tail(observed)
    ppp = float(tails.mean())
    error = float(tails.std()) / math.sqrt(count)
    side = min(ppp, 1 - ppp) if discrepancy.two_sided else ppp
    limit = EXTREME / 2 if discrepancy.two_sided else EXTREME
    concern = side + 2 * error < limit
    says = "data like these are not what the model predicts" if concern else "as predicted"
    shown = f"{ppp:.3f}" if ppp >= 0.001 else f"{ppp:.1g}"
    return AdequacyTest(
        f"{NAME}, {discrepancy.name}",
        "ppp",
        ppp,
        None,
        None,
        f"{np.median(observed):.2f} in the data, {discrepancy.typical:.2f} in replicates, ppp "
        f"{shown} (Monte Carlo error {error:.1g}, {count} draws; not uniform under the model): "
        f"{says}.",
        concern=concern,
    )
