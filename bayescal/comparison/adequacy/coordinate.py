"""Whether residuals depend on the coordinate that the axis's polynomial leaves out."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.special import fdtrc

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Extension, Problem, extension, other_name, scaled
from bayescal.linear.replicates import clusters, within_cells
from bayescal.rounding import significant

NAME = "other coordinate"


def other_coordinate(problem: Problem, other: Array | None) -> AdequacyTest:
    """F tests of nested models: other, other^2 and the product with the regressor added.

    The design is refitted with the columns added, in the camera's own frame (no
    centring), each alone and all three jointly (Draper & Smith 1998, 6.2). `parts`
    holds the single tests; the p-value is the joint one.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    return _tests(problem, NAME, other, problem.extend)


def other_coordinate_within(problem: Problem, other: Array | None) -> AdequacyTest | None:
    """Test the same among points that share the axis's regressor, whatever its function.

    A mean for each regressor value takes the place of the polynomial, so that an
    order too low can't hide the dependence in its own misfit. None where no points
    share the regressor but not the other.
    """
    if other is None:
        return None
    name = f"{NAME}, equal {problem.data.regressor}"
    places = clusters(problem.data.x)
    left = problem.n - int(places.max()) - 1
    e = within_cells(places, problem.data.t, problem.sd)
    if left == 0 or float(e @ e) <= problem.rounding:
        return None

    def extend(columns: Array) -> Extension:
        inner = np.column_stack([within_cells(places, c, problem.sd) for c in columns.T])
        lengths = np.linalg.norm(columns / problem.sd[:, None], axis=0)
        return extension(inner / np.where(lengths > 0, lengths, 1.0), e, left, problem.rounding)

    return _tests(problem, name, other, extend)


def _tests(
    problem: Problem, name: str, other: Array | None, extend: Callable[[Array], Extension]
) -> AdequacyTest:
    if other is None:
        return untested(name, "there is none: y is a function of x alone")
    regressor, symbol = problem.data.regressor, other_name(problem.data.regressor)
    v = scaled(other)
    if not v.any():
        return untested(name, f"{symbol} is the same for all points")
    u, x = other / np.abs(other).max(), problem.data.x / np.abs(problem.data.x).max()
    columns = {symbol: u, f"({symbol})²": u**2, f"{regressor} * {symbol}": x * u}
    added = {k: extend(c[:, None]) for k, c in columns.items()}
    parts = tuple(_test(problem, k, found) for k, found in added.items())
    tested = [part for part in parts if part.p_value is not None]
    if not tested:
        return untested(name, parts[0].meaning)
    best = min(tested, key=_strength)
    # The same span as the columns above, centred against rounding.
    joint = _test(problem, name, extend(np.column_stack([v, v**2, problem.s * v])))
    if joint.p_value is None:  # too few points for all at once
        p = min(1.0, len(tested) * (best.p_value or 0.0))
        meaning = f"Strongest of {len(tested)} tries is {best.name}, {best.meaning}"
        return AdequacyTest(name, best.statistic, best.value, best.dof, p, meaning, parts=parts)
    meaning = (
        f"{', '.join(columns)} together are {joint.meaning.rstrip('.')}; strongest alone is "
        f"{best.name}, {_worth(problem, added[best.name]):.2g} {problem.unit}."
    )
    return AdequacyTest(
        name, joint.statistic, joint.value, joint.dof, joint.p_value, meaning, parts=parts
    )


def _strength(test: AdequacyTest) -> tuple[float, float]:
    """Sort key: the smallest p-value first, then the largest F (p may underflow)."""
    p = 1.0 if test.p_value is None else test.p_value
    return p, -math.inf if test.value is None else -test.value


def _test(problem: Problem, name: str, added: Extension) -> AdequacyTest:
    if added.rank == 0:
        return untested(name, f"{name} can't be told from {problem.data.regressor} at these points")
    if added.dof <= 0:
        return untested(name, "no degree of freedom is left to test against")
    worth = _worth(problem, added)
    dof, unit = (added.rank, added.dof), problem.unit
    if added.exact:
        meaning = f"worth {significant(worth)} {unit} rms over the points, all that was left."
        return AdequacyTest(name, "F", None, dof, 0.0, meaning)
    noise = math.sqrt(added.rss / added.dof * float(np.mean(added.leverage * problem.sd**2)))
    before = math.sqrt((added.gain + added.rss) / (added.dof + added.rank))
    own = unit if problem.data.sd is None else "deviations"
    sigmas = " to ".join(significant(s, 3) for s in (before, math.sqrt(added.rss / added.dof)))
    meaning = (
        f"worth {significant(worth)} {unit} rms over the points (noise alone would give "
        f"{significant(noise)}), and sigma goes from {sigmas} {own}."
    )
    return AdequacyTest(name, "F", added.f, dof, float(fdtrc(*dof, added.f)), meaning)


def _worth(problem: Problem, added: Extension) -> float:
    """Root mean square over the points of what columns change, px."""
    return math.sqrt(float(np.mean((added.shift * problem.sd) ** 2)))
