"""A posterior that piles up at a bound of its prior: the evidence depends on that bound."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.case import Case
from bayescal.linear.evidence import NEAR_BOUND
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.rounding import significant

# Posterior mass within 5 % of a bound that is worth a finding.
PILE = 0.01
# Of a mixture's width, whose posterior is wide, within 10 % of its upper bound.
PILE_OF_WIDTH, NEAR_WIDTH = 0.1, 1.1


def at_bounds(case: Case) -> Iterator[Finding]:
    """Find sigma of any order, and tau and a mixture's width of the best, at a bound."""
    noise, best = case.axis.noise, case.best
    unit = " px" if noise.parameter == "sigma" else ""
    for result in case.results if noise.bounds is not None else ():
        assert noise.bounds is not None, "sigma is inferred"
        masses = result.posterior.at_bounds(noise.parameter, noise.bounds)
        for side, bound, mass in zip(("lower", "upper"), noise.bounds, masses, strict=True):
            if mass > PILE:
                text = (
                    f"order {result.order}: {100 * mass:.0f}% of sigma's posterior lies at its "
                    f"{side} bound, {bound:.4g}{unit}; the evidence depends on that bound"
                )
                if result is best:
                    yield overturns("sigma-bound", text, "sigma lies at a bound of its prior")
                else:
                    yield limits("sigma-bound", text)
    yield from _tau(case)
    if isinstance(case.shape, OutlierMixture) and "bad_width" in best.posterior.names:
        draws = best.posterior.chain.draws[:, :, best.posterior.names.index("bad_width")]
        mass = float(np.mean(draws > case.shape.width_bounds[1] / NEAR_WIDTH))
        if mass > PILE_OF_WIDTH:
            yield limits(
                "width-bound",
                f"{100 * mass:.0f}% of the posterior of the bad points' width lies within 10% of "
                f"its upper bound, {case.shape.width_bounds[1]:.4g}: bad points may be wider, and "
                "the evidence of this noise is understated",
            )


def _tau(case: Case) -> Iterator[Finding]:
    """Find the best order's tau at a bound: there the evidence depends on it."""
    best, rule = case.best, case.axis.rule
    if "tau" not in best.posterior.names:
        return
    low, high = rule.tau_bounds
    if best.exact is not None:
        values, mass = best.exact.hyperparameters[-1]
    else:
        draws = best.posterior.chain.draws
        values = draws[:, :, best.posterior.names.index("tau")].ravel()
        mass = np.full(len(values), 1 / len(values))
    near = {
        "lower": (low, float(mass[values < low * (1 + NEAR_BOUND)].sum())),
        "upper": (high, float(mass[values > high / (1 + NEAR_BOUND)].sum())),
    }
    for side, (bound, share) in near.items():
        if share > PILE:
            yield overturns(
                "tau-bound",
                f"order {best.order}: {100 * share:.0f}% of tau's posterior lies at its {side} "
                f"bound, {significant(bound * rule.size)} px; the evidence depends on that bound",
                "tau lies at a bound of its prior",
            )
