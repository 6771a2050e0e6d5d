"""Simulation-based calibration: whether truths from the prior have uniform ranks among draws.

Talts et al. 2018 (arXiv:1804.06788).
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from bayescal.arrays import Array

DRAWS = 255  # ranks 0 to 255


def p_values(ranks: Array, bins: int) -> Array:
    """Chi-squared test of uniform ranks of each quantity, ``(n_quantities,)``.

    Parameters
    ----------
    ranks : Array
        ``(n_simulations, n_quantities)``, from 0 to DRAWS.
    bins : int
        Divides DRAWS + 1.
    """
    counts = np.array(
        [np.bincount(column * bins // (DRAWS + 1), minlength=bins) for column in ranks.T]
    )
    return np.asarray(stats.chisquare(counts, axis=1).pvalue)


def holm(p: Array) -> Array:
    """Holm's step-down adjustment: each p-value at the level of the family."""
    ascending = np.argsort(p)
    adjusted = np.maximum.accumulate(p[ascending] * np.arange(len(p), 0, -1))
    out = np.empty(len(p))
    out[ascending] = np.minimum(adjusted, 1)
    return out


def ranks(simulations: list[tuple[Array, Array]], shrink: float = 1.0) -> Array:
    """Ranks of the truths among draws, ``(n_simulations, n_quantities)``.

    Parameters
    ----------
    simulations : list of tuple
        Truth ``(n_quantities,)`` and draws ``(DRAWS, n_quantities)`` of each.
    shrink : float, optional
        Factor on the draws' distances from their mean: a control that must be noticed.
    """
    rows = []
    for truth, draws in simulations:
        centre = draws.mean(axis=0)
        rows.append((centre + shrink * (draws - centre) < truth).sum(axis=0))
    return np.array(rows)
