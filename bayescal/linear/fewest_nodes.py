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
    scaled = functions / (functions @ weights)[:, None] * root
    _, sizes, directions = np.linalg.svd(scaled, full_matrices=False)
    directions = directions[sizes > DIRECTION * sizes[0]]
    try:
        found, _ = nnls(directions, directions @ root)
    except RuntimeError:  # it did not converge
        return weights
    if float(np.abs(scaled @ found - 1).max()) > OFF:
        return weights
    return np.asarray(found * root)
