"""Sigma or a lens's tau that piles up at a bound of its prior, and what that does to evidences."""

from __future__ import annotations

import math
from collections.abc import Mapping

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
MATTERS = 0.5  # nat: what a bound takes from the evidence that is worth a caveat
BEYOND = 2.0  # times: to where an upper bound is moved
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
    said = [text for group in basis.problem.model.groups if (text := _bounded(basis.best, group))]
    return limits("tau-bound", f"{basis.best.name}: {'; '.join(said)}") if said else None


def _bounded(judged: JudgedLens, group: Group) -> str:
    """Say where a bound of a strength lowers the evidence; a flat target serves any lens."""
    low, high = group.bounds
    bow = group.name == "bow"
    unit = "diagonals" if bow else "px"
    moved = [("upper", high, (low, BEYOND * high))]
    if not bow and LOWEST / group.unit < low:
        moved.append(("lower", low, (LOWEST / group.unit, high)))
    for side, bound, wider in moved:
        if (gain := _rise(judged, {group: wider})) > MATTERS:
            other = wider[0] if side == "lower" else wider[1]
            return (
                f"tau ({group.name}) lies at its {side} bound, {significant(bound * group.unit)} "
                f"{unit}; were that {significant(other * group.unit)} {unit}, the evidence would "
                f"be {gain:.1f} nat higher"
            )
    return ""


def lift(judged: JudgedLens) -> float:
    """By how much a lens's log evidence rises where tau begins at `LOWEST`, nat."""
    groups = [g for g in judged.evidence.problem.model.groups if g.name != "bow"]
    lowest = {g: LOWEST / g.unit for g in groups}
    return _rise(judged, {g: (b, g.bounds[1]) for g, b in lowest.items() if b < g.bounds[0]})


def _rise(judged: JudgedLens, bounds: Mapping[Group, tuple[float, float]]) -> float:
    """By how much a lens's log evidence rises under other bounds of strengths, nat.

    The mean of the priors' ratio over the posterior: the ratio of the evidences is that.
    """
    if not bounds:
        return 0.0
    problem: Problem = judged.evidence.problem
    rng = np.random.default_rng(0)  # always the same steps: they cancel between like lenses
    draws = problem.x + rng.standard_normal((DRAWS, problem.model.dimension)) @ problem.spread.T
    ratio = sum(_ratio(group, draws, other) for group, other in bounds.items())
    return float(np.logaddexp.reduce(ratio)) - math.log(DRAWS)


def _ratio(group: Group, x: Array, bounds: tuple[float, float]) -> Array:
    """Log of the prior density under other bounds over that as it is, ``(n_draws,)``."""
    q = ((x[:, list(group.columns)] / group.unit) ** 2).sum(axis=1)
    low, high = np.log([bounds, group.bounds]).T
    other, own = (Strength(b, len(group.columns)) for b in zip(low, high, strict=True))
    return other.log_density(q) - own.log_density(q)
