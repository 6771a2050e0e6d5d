"""Residuals as the fitted order would leave them if it were true.

The distribution of a statistic that does not change with the scale of the residuals
depends on the design only, so that its p-value can be simulated exactly: of N
simulations the fraction (1 + number as extreme) / (N + 1) is uniform under the model
(Barnard 1963; Davison & Hinkley 1997, 4.2). Textbook null distributions of the runs
and of Koenker's LM ignore that fitting p coefficients ties the residuals together.
"""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array

# Beyond this many residuals large-sample distributions are as good and cheaper.
SIMULATED_POINTS = 400
NUMBERS = 250_000  # normal deviates drawn for a small problem
FEWEST, MOST = 999, 4999  # simulations


def simulated_residuals(
    q: Array, rng: np.random.Generator, simulations: int | None = None
) -> Array | None:
    """Residuals of independent standard normals off a design, ``(n_simulations, n)``.

    Parameters
    ----------
    q : Array
        Orthonormal basis of the weighted design, ``(n, p)``.
    simulations : int, optional
        By default 999 to 4999, the fewer the more points.

    Returns
    -------
    Array or None
        None beyond 400.
    """
    if len(q) > SIMULATED_POINTS:
        return None
    if simulations is None:
        simulations = min(max(NUMBERS // len(q), FEWEST), MOST)
    noise = rng.standard_normal((simulations, len(q)))
    residuals: Array = noise - (noise @ q) @ q.T
    return residuals


def upper_tail(null: Array, value: float) -> float:
    """Give the simulated p-value of a statistic at least as large; ties to rounding count."""
    slack = 1e-9 * max(abs(value), 1e-300)
    return (1 + int((null >= value - slack).sum())) / (len(null) + 1)


def two_sided(null: Array, value: float) -> float:
    """Twice the smaller simulated tail, at most 1."""
    return min(1.0, 2 * min(upper_tail(null, value), upper_tail(-null, -value)))
