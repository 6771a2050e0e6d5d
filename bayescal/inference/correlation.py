"""Correlations of parameters, and which combinations the data leave weakly identified."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array

# An eigenvalue of the correlation matrix this far above 1 is parameters that move together,
STRONG = 1.8
# and those belong to it whose share of the eigenvector is at least this.
PART = 0.35


def correlation(draws: Array) -> Array:
    """Correlation matrix of draws ``(n_draws, n_parameters)``, square in the parameters."""
    return np.asarray(np.corrcoef(draws, rowvar=False))


def correlation_of(covariance: Array) -> Array:
    """Correlation matrix; NaN beside a parameter that does not vary."""
    sd = np.sqrt(covariance.diagonal())
    scale = np.outer(sd, sd)
    none = np.full_like(scale, np.nan)
    return np.asarray(np.divide(covariance, scale, out=none, where=scale > 0))


def weak_combinations(
    names: Sequence[str], matrix: Array
) -> tuple[tuple[tuple[str, ...], tuple[float, ...]], ...]:
    """Find combinations along which the posterior is longest, from its eigenvectors.

    Parameters
    ----------
    matrix : Array
        Correlation matrix, square in the names.

    Returns
    -------
    tuple
        For each combination the parameters that move together, the one that counts most
        first, and their shares of the eigenvector with signs (of the first: positive).
    """
    values, vectors = np.linalg.eigh(matrix)
    out = []
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        if value < STRONG:
            break
        order = np.argsort(-np.abs(vector))
        kept = [int(i) for i in order if abs(vector[i]) >= PART]
        if len(kept) < 2:
            continue
        sign = float(np.sign(vector[kept[0]]))
        shares = tuple(sign * float(vector[i]) for i in kept)
        out.append((tuple(names[i] for i in kept), shares))
    return tuple(out)


def weak_lines(names: Sequence[str], matrix: Array) -> list[str]:
    """Name what moves together, a sentence for each combination; arguments as of the former."""
    out = []
    for kept, shares in weak_combinations(names, matrix):
        parts = ", ".join(f"{n} ({s:+.2f})" for n, s in zip(kept, shares, strict=True))
        out.append(f"Weakly identified together: {parts} move as one.")
    return out
