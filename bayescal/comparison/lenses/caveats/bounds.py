"""Sigma or a lens's tau that piles up at a bound of its prior, and what that does to evidences."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.laplace import SIGMA_BOUNDS
from bayescal.calibration.model.lens_model import Group
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.bounds import PILE
from bayescal.comparison.lenses.results import Evidenced, JudgedLens
from bayescal.prior.strength import Strength
from bayescal.rounding import significant

LOWEST = 0.01  # px: where tau of a polynomial begins
NEAR = 10.0  # nat: lenses that lower bounds could lift over the best one
DRAWS = 1000  # of a lens's Laplace approximation


def sigma_bound(basis: Evidenced) -> Finding | None:
    """Find noise below or above all that its prior allows."""
    if basis.setting.level.sigma is not None:
        return None
    masses = basis.posterior.at_bounds("sigma", SIGMA_BOUNDS)
    for side, bound, mass in zip(("lower", "upper"), SIGMA_BOUNDS, masses, strict=True):
        if mass > PILE:
            return overturns(
                "sigma-bound",
                f"{basis.best.name}: {100 * mass:.0f}% of sigma's posterior lies at its {side} "
                f"bound, {bound:g} px; the evidence depends on that bound",
                "sigma lies at a bound of its prior",
            )
    return None


def tau_bound(basis: Evidenced) -> Finding | None:
    """Find strengths at their bounds, and whether a lower bound chooses the lens."""
    close = [j for j in basis.lenses if basis.best.log_evidence - j.log_evidence < NEAR]
    lifted = max(close, key=lambda j: j.log_evidence + lift(j))
    if lifted is not basis.best:
        return overturns(
            "tau-bound",
            f"were displacements of {LOWEST:g} px as likely beforehand as larger ones, "
            f"{lifted.name} would win over {basis.best.name}: tau's lower bound chooses",
            f"tau's lower bound chooses between it and {lifted.name}",
        )
    said = [text for group in basis.problem.model.groups if (text := _piled(basis, group))]
    if not said:
        return None
    return limits("tau-bound", f"{basis.best.name}: {'; '.join(said)}; its evidence is understated")


def _piled(basis: Evidenced, group: Group) -> str:
    masses = basis.posterior.at_bounds(f"tau {group.name}", group.bounds)
    sides = zip(("lower", "upper"), ("smaller", "larger"), group.bounds, masses, strict=True)
    bow = group.name == "bow"
    for side, size, bound, mass in sides:
        if mass > PILE and not (bow and side == "lower"):  # a flat target is as good for any lens
            unit = "diagonals" if bow else "px"
            return (
                f"{100 * mass:.0f}% of the posterior of tau ({group.name}) lies at its {side} "
                f"bound, {significant(bound * group.unit)} {unit}: that part is {size} than its "
                "prior expects"
            )
    return ""


def lift(judged: JudgedLens) -> float:
    """By how much a lens's log evidence rises where tau begins at `LOWEST`, nat.

    The mean of the priors' ratio over the posterior: the ratio of the evidences is that.
    """
    problem: Problem = judged.evidence.problem
    groups = [g for g in problem.model.groups if g.name != "bow" and LOWEST / g.unit < g.bounds[0]]
    if not groups:
        return 0.0
    rng = np.random.default_rng(0)  # always the same steps: they cancel between like lenses
    steps = rng.standard_normal((DRAWS, problem.model.dimension)) @ problem.spread.T
    return float(np.log(np.mean(np.exp(sum(_ratio(g, problem.x + steps) for g in groups)))))


def _ratio(group: Group, x: Array) -> Array:
    """Log of the prior density with tau from `LOWEST` over that as it is, ``(n_draws,)``."""
    q = ((x[:, list(group.columns)] / group.unit) ** 2).sum(axis=1)
    low, high = np.log(group.bounds)
    lower = float(np.log(LOWEST / group.unit))
    wide, own = (Strength((float(b), float(high)), len(group.columns)) for b in (lower, low))
    return wide.log_density(q) - own.log_density(q)
