"""As few nodes as integrate some functions as all nodes do.

Tchakaloff (1957, Bull. Sci. Math. 81, 123): as many nodes as functions are enough, with positive
weights. They are found by non-negative least squares (Lawson & Hanson 1974, ch. 23), of functions
that are orthonormal under all nodes, so that those alike to rounding count once.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from bayescal.arrays import Array

# Directions of the functions below this share of the largest are rounding.
DIRECTION = 1e-13
# How far any integral may be off.
OFF = 1e-11
# Random combinations of the functions that are looked at first, and those that must be redundant.
FEW, SPARE = 64, 8


def fewest_nodes(functions: Array, weights: Array) -> Array:
    """Weights of few nodes that give the same integrals.

    Parameters
    ----------
    functions : Array
        Positive values of each function at each node, ``(n_functions, n_nodes)``.
    weights : Array
        Of all nodes, ``(n_nodes,)``, positive.

    Returns
    -------
    Array
        ``(n_nodes,)``, mostly zero; `weights` where no such few are found.
    """
    root = np.sqrt(weights)
    scaled = functions * root
    scaled /= (functions @ weights)[:, None]
    directions = _directions(scaled)
    try:
        found, _ = nnls(directions, directions @ root)
    except RuntimeError:  # it did not converge
        return weights
    if float(np.abs(scaled @ found - 1).max()) > OFF:
        return weights
    return np.asarray(found * root)


def _directions(functions: Array) -> Array:
    """Orthonormal functions of which all others are made, ``(rank, n_nodes)``.

    Smooth functions have far fewer than there are of them, and as many random combinations and
    some more span them (Halko, Martinsson & Tropp 2011, SIAM Rev. 53, 217).
    """
    rng, count = np.random.default_rng(0), FEW
    while True:
        few = count < len(functions)
        rows = rng.standard_normal((count, len(functions))) @ functions if few else functions
        _, sizes, directions = np.linalg.svd(rows, full_matrices=False)
        found = directions[sizes > DIRECTION * sizes[0]]
        if not few or len(found) <= count - SPARE:
            return np.asarray(found)
        count *= 2
