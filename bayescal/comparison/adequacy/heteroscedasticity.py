"""Whether the size of the residuals depends on where a point lies."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtrc

from bayescal.arrays import Array
from bayescal.comparison.adequacy.null import upper_tail
from bayescal.comparison.adequacy.outcome import AdequacyTest, p_words, untested
from bayescal.comparison.adequacy.problem import NEW_DIRECTION, Problem
from bayescal.rounding import significant

NAME = "uneven noise"


def heteroscedasticity(problem: Problem, depth: Array | None, null: Array | None) -> AdequacyTest:
    """Koenker's LM test of squared studentised residuals on position.

    LM = n R² of the regression of the squares on a constant and the fitted value,
    the magnitude of the regressor and 1/|z| (Breusch & Pagan 1979; Koenker 1981, J.
    Econometrics 17, 107: valid without normal errors): jointly, and each alone in
    `parts`. Small samples: p-value simulated with the fit's own design and normal
    errors; beyond 400 points chi2.

    Parameters
    ----------
    depth : Array or None
        z in the camera's frame, ``(n_points,)``, world units.
    null : Array or None
        Simulated residuals, ``(n_simulations, n_points)``.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    if problem.dof < 2:
        return untested(NAME, "1 degree of freedom is too few")
    keep = problem.usable
    candidates = {
        "the fitted value": problem.data.t - problem.e * problem.sd,
        f"|{problem.data.regressor}|": np.abs(problem.data.x),
    }
    if depth is not None:
        candidates["1/|z|"] = 1 / np.abs(depth)
    columns = {
        name: unit
        for name, values in candidates.items()
        if (unit := _unit(values[keep])) is not None
    }
    squares = problem.studentised**2
    simulated = None
    if null is not None:
        simulated = null[:, keep] ** 2 / problem.free[keep]
    parts = tuple(
        _test(problem, name, column[:, None], squares, simulated, column)
        for name, column in columns.items()
    )
    basis = _basis(list(columns.values()))
    if basis is None or basis.shape[1] >= len(keep) - 1:
        return untested(NAME, "the points lie in too few places to compare their noise")
    best = min(parts, key=lambda t: (t.p_value or 0.0, -(t.value or 0.0)))
    if basis.shape[1] == 1:
        return _named(best, f"With {best.name}: {best.meaning}", parts)
    joint = _test(problem, NAME, basis, squares, simulated, columns[best.name])
    meaning = f"Clearest with {best.name} (alone {p_words(best.p_value or 0.0)}): {best.meaning}"
    return _named(joint, meaning, parts)


def _named(test: AdequacyTest, meaning: str, parts: tuple[AdequacyTest, ...]) -> AdequacyTest:
    return AdequacyTest(
        NAME, test.statistic, test.value, test.dof, test.p_value, meaning, parts=parts
    )


def lagrange_multiplier(squares: Array, basis: Array) -> Array:
    """Koenker's n R² of each row of squares on an orthonormal, centred basis.

    Parameters
    ----------
    squares : Array
        Squared residuals, ``(m, n_points)``.
    basis : Array
        ``(n_points, k)``, orthonormal and orthogonal to the constant.

    Returns
    -------
    Array
        ``(m,)``; 0 where all squares are equal.
    """
    centred = squares - squares.mean(axis=1, keepdims=True)
    total = (centred**2).sum(axis=1)
    flat = total <= 1e-18 * (squares**2).sum(axis=1)
    explained = ((centred @ basis) ** 2).sum(axis=1)
    result: Array = np.where(flat, 0.0, len(basis) * explained / np.where(flat, 1.0, total))
    return result


def _test(
    problem: Problem,
    name: str,
    basis: Array,
    squares: Array,
    simulated: Array | None,
    along: Array,
) -> AdequacyTest:
    """LM test on a basis; the words compare both halves along one of its directions."""
    value = float(lagrange_multiplier(squares[None], basis)[0])
    dof = basis.shape[1]
    if simulated is not None:
        p = upper_tail(lagrange_multiplier(simulated, basis), value)
    else:
        p = float(chdtrc(dof, value))
    sizes = np.sqrt(squares * problem.rss / problem.dof) * problem.sd[problem.usable]
    upper = along > np.median(along)
    if not upper.any() or upper.all():
        upper = along >= np.median(along)
    if upper.all():
        upper = along > along.min()
    high, low = (math.sqrt(float(np.mean(sizes[half] ** 2))) for half in (upper, ~upper))
    meaning = (
        f"residuals are {significant(high)} {problem.unit} rms where it is large, "
        f"{significant(low)} where it is small."
    )
    return AdequacyTest(name, "LM", value, (dof,), p, meaning)


def _unit(values: Array) -> Array | None:
    """Centre a column to unit length; None where it is constant up to rounding."""
    values = values / max(float(np.abs(values).max()), 1e-300)
    centred = values - values.mean()
    length = float(np.linalg.norm(centred))
    return centred / length if length > 1e-12 * math.sqrt(len(values)) else None


def _basis(columns: list[Array]) -> Array | None:
    """Orthonormal basis of centred columns, those that repeat others dropped."""
    if not columns:
        return None
    u, size, _ = np.linalg.svd(np.column_stack(columns), full_matrices=False)
    kept: Array = u[:, size > max(NEW_DIRECTION, 1e-7)]
    return kept
