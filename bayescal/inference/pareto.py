"""Shape of the tail of importance weights: Pareto k.

As ArviZ computes it, whose numbers come out to rounding (tests/inference/test_pareto.py);
importing it takes a second, a third of a whole sweep of lenses.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array

FEWEST = 5  # draws of a tail
FLOOR = 700.0  # of log weights below the largest
PRIOR_DRAWS, PRIOR_SHAPE = 10, 0.5
NODES, SPREAD = 30, 3  # Zhang & Stephens: at least so many; so many quartiles wide


def pareto_shape(log_weights: Array) -> float:
    """Pareto k of the upper tail of importance weights (Vehtari et al. 2024).

    Parameters
    ----------
    log_weights : Array
        ``(n_draws,)``; -inf for draws outside the support.

    Returns
    -------
    float
        inf where the tail has no shape.
    """
    n = len(log_weights)
    size = int(3 * math.sqrt(n)) if n > 225 else n // 5
    if size < FEWEST:
        return math.inf
    weights = np.sort(np.exp(np.maximum(log_weights - log_weights.max(), -FLOOR)))
    excess = weights[-size:] - weights[-size - 1]
    first = excess[int(size / 4 + 0.5) - 1]
    if excess[-1] <= excess[0] or first <= excess[0]:
        return math.inf
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        k = _shape(excess, first)
    return k if math.isfinite(k) else math.inf


def _shape(excess: Array, first: float) -> float:
    """Fit a generalised Pareto distribution to sorted values of first quartile `first`.

    Zhang & Stephens 2009, Technometrics 51, 316; the weak prior of k as Vehtari et al. 2024.
    """
    n = len(excess)
    count = NODES + int(math.sqrt(n))
    nodes = 1 / excess[-1] + (1 - np.sqrt(count / (np.arange(count) + 0.5))) / (SPREAD * first)
    shapes = np.log1p(-nodes[:, None] * excess).mean(axis=1)
    fit = n * (np.log(-nodes / shapes) - shapes - 1)
    shares = np.exp(fit - logsumexp(fit))
    kept = shares >= 10 * np.finfo(float).eps
    mean = float(nodes[kept] @ shares[kept] / shares[kept].sum())
    k = float(np.log1p(-mean * excess).mean())
    return (n * k + PRIOR_DRAWS * PRIOR_SHAPE) / (n + PRIOR_DRAWS)
