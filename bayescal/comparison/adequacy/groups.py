"""Errors that points of a group share: one-way random effects beyond the polynomial."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.outcome import GROUPS as NAME
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import NEW_DIRECTION, Problem
from bayescal.linear.replicates import clusters
from bayescal.rounding import significant


@dataclass(frozen=True)
class GroupEffects:
    """One-way random effects beside the polynomial, weighted.

    Attributes
    ----------
    gain : float
        Fall of the residual sum of squares with a mean for each group.
    rank : int
        Directions that the groups add to the design.
    rss : float
        What is left.
    dof : int
        Degrees of freedom left.
    between : float
        Variance of the shared error, not negative (Henderson's method III).
    within : float
        Variance of the points' own error.
    """

    gain: float
    rank: int
    rss: float
    dof: int
    between: float
    within: float

    @property
    def icc(self) -> float:
        """Intraclass correlation: the shared part of the variance."""
        total = self.between + self.within
        return self.between / total if total > 0 else 0.0


def numbered_groups(
    groups: Sequence[str] | None, depth: Array | None
) -> tuple[IntArray, str] | None:
    """Give each group a number: the column group, else points that share a plane z."""
    if groups is not None:
        names: dict[str, int] = {}
        numbers = [names.setdefault(group, len(names)) for group in groups]
        return np.array(numbers, dtype=np.intp), "a group"
    if depth is not None:
        return clusters(depth), "z"
    return None


def group_effects(problem: Problem, group: IntArray) -> GroupEffects | None:
    """Fit a mean per group beside the polynomial; None where nothing is left to compare.

    The F test of the group means in the refitted design is exact. The variance
    component equates its expectation, E gain = between * tr(Z'MZ) + within * rank,
    M the projection off the design (Henderson 1953, Biometrics 9, 226, method III;
    Searle, Casella & McCulloch 1992, 5.5); with a constant alone it is the ANOVA
    estimate. Group means are taken out beforehand (Frisch & Waugh 1933), so
    that a hundred thousand groups cost no more than two.
    """
    sizes = np.bincount(group).astype(np.float64)
    sums = np.column_stack([np.bincount(group, column, len(sizes)) for column in problem.q.T])
    inner = problem.q - (sums / sizes[:, None])[group]
    e = problem.e - (np.bincount(group, problem.e) / sizes)[group]
    u, size, _ = np.linalg.svd(inner, full_matrices=False)
    u = u[:, size > max(NEW_DIRECTION, 1e-8)]
    e -= u @ (u.T @ e)
    rank = len(sizes) + u.shape[1] - problem.p
    dof = problem.dof - rank
    if rank <= 0 or dof <= 0:
        return None
    rss = float(e @ e)
    rss = 0.0 if rss <= problem.rounding else rss
    gain = max(problem.rss - rss, 0.0)
    trace = problem.n - float((sums**2).sum())
    within = rss / dof
    between = max((gain - rank * within) / trace, 0.0)
    return GroupEffects(gain, rank, rss, dof, between, within)


def effective_points(group: IntArray, icc: float) -> float:
    """Points that independent errors would need for the same mean: n / (1 + (m0 - 1) icc).

    The design effect (Kish 1965, *Survey Sampling*, 5.4), with the mean group size m0 =
    (n - sum n_g² / n) / (G - 1) of unbalanced one-way ANOVA.
    """
    sizes = np.bincount(group).astype(np.float64)
    n = float(sizes.sum())
    if len(sizes) < 2:
        return n
    m0 = (n - float((sizes**2).sum()) / n) / (len(sizes) - 1)
    return n / (1 + (m0 - 1) * icc)


def shared_errors(
    problem: Problem, groups: Sequence[str] | None, depth: Array | None
) -> AdequacyTest:
    """F test of group means beside the polynomial, intraclass correlation, n_eff."""
    if problem.unusable:
        return untested(NAME, problem.unusable)
    found = numbered_groups(groups, depth)
    if found is None:
        return untested(NAME, "no group is stated")
    group, what = found
    count = int(group.max()) + 1
    if count == 1:
        return untested(NAME, f"all points share {what}")
    if count == problem.n:
        return untested(NAME, f"no two points share {what}")
    effects = group_effects(problem, group)
    if effects is None:
        return untested(
            NAME, f"{count} groups and {problem.p} coefficients leave nothing to compare"
        )
    dof = (effects.rank, effects.dof)
    value = None
    p = 0.0
    if effects.rss > 0:
        value = effects.gain / effects.rank / effects.within
        p = float(fdtrc(*dof, value))
    shared = math.sqrt(effects.between)
    unit = problem.unit if problem.data.sd is None else "deviations"
    n_eff = effective_points(group, effects.icc)
    says = (
        f"for a mean, {problem.n} points are worth about {n_eff:.0f} independent ones"
        if p < 0.05
        else "no more than chance"
    )
    return AdequacyTest(
        NAME,
        "F",
        value,
        dof,
        p,
        f"Points that share {what} ({count} groups) share an error of {significant(shared)} {unit} "
        f"beside their own {significant(math.sqrt(effects.within))}, intraclass correlation "
        f"{effects.icc:.2f}: {says}.",
    )
