"""Resamples of many points, drawn without holding the points.

A resample counts each point w_i times, w multinomial, and changes no more than the sums of w_i q_i
q_i' over the rows of [design | pixels] = Q R. Of many points none of which weighs much these sums
are normal, with the mean and the covariance that they have over the points (Efron & Tibshirani
1993, ch. 22); the few rows that weigh much are kept, and their counts are drawn as they are.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.linear.evidence import Reduced
from bayescal.linear.reweighting import DataSets, roots_of
from bayescal.polynomials.basis import PolynomialMap

# A row with more of its column space than this is kept; of m columns there are at most 1000 m.
HEAVY = 1e-3


def triangle_of(reduced: Reduced) -> Array:
    """R of [design | pixels] at the order that is reduced, ``(p + 1, p + 1)``."""
    size = len(reduced.qt)
    out = np.zeros((size + 1, size + 1))
    out[:size, :size], out[:size, size] = reduced.r, reduced.qt
    out[size, size] = np.sqrt(reduced.rss) or 1.0
    return out


def without_each(
    reduced: Reduced, monomials: PolynomialMap, rows: Array, log_sd: Array
) -> DataSets:
    """All points but one, for each of some.

    Parameters
    ----------
    rows : Array
        Weighted [design | pixels] of these points, ``(n, p + 1)``.
    log_sd : Array
        ln of their deviations, ``(n,)``.
    """
    triangle = triangle_of(reduced)
    q = solve_triangular(triangle, rows.T, trans="T").T
    roots = roots_of(np.eye(len(triangle)) - q[:, :, None] * q[:, None, :])
    left = np.full(len(rows), float(reduced.n) - 1)
    return DataSets(_triangles(roots, triangle), left, reduced.log_sd - log_sd, monomials)


class Resampling:
    """What a bootstrap needs of many points, taken in chunk by chunk.

    Parameters
    ----------
    reduced : Reduced
        All points, at the highest order.
    """

    def __init__(self, reduced: Reduced, monomials: PolynomialMap) -> None:
        self._triangle, self._monomials = triangle_of(reduced), monomials
        m = len(self._triangle)
        self._upper = np.triu_indices(m)
        size = len(self._upper[0]) + 1  # and ln sd
        self._light, self._sum, self._squares = 0, np.zeros(size), np.zeros((size, size))
        self._heavy = [np.empty((0, size))]

    def add(self, rows: Array, log_sd: Array) -> None:
        """Take in weighted rows of [design | pixels], ``(n, p + 1)``, and ln of deviations."""
        q = solve_triangular(self._triangle, rows.T, trans="T").T
        terms = np.column_stack([q[:, self._upper[0]] * q[:, self._upper[1]], log_sd])
        heavy = (q**2).sum(axis=1) > HEAVY
        self._heavy.append(terms[heavy])
        light = terms[~heavy]
        self._light += len(light)
        self._sum += light.sum(axis=0)
        self._squares += light.T @ light

    def drawn(self, rng: np.random.Generator, resamples: int) -> DataSets:
        """Draw data sets of as many points as there are."""
        heavy = np.concatenate(self._heavy)
        n = self._light + len(heavy)
        shares = np.append(np.full(len(heavy), 1 / n), self._light / n)
        counts = rng.multinomial(n, shares, size=resamples).astype(float)
        total = counts[:, :-1] @ heavy
        if self._light:
            mean = self._sum / self._light
            spread = self._squares - self._light * np.outer(mean, mean)
            values, vectors = np.linalg.eigh(spread / self._light)
            root = vectors * np.sqrt(np.maximum(values, 0))
            left = counts[:, -1:]
            normal = rng.standard_normal((resamples, len(mean))) @ root.T
            total = total + left * mean + np.sqrt(left) * normal
        m = len(self._triangle)
        grams = np.empty((resamples, m, m))
        grams[:, self._upper[0], self._upper[1]] = total[:, :-1]
        grams[:, self._upper[1], self._upper[0]] = total[:, :-1]
        triangles = _triangles(roots_of(grams), self._triangle)
        return DataSets(triangles, np.full(resamples, float(n)), total[:, -1], self._monomials)


def _triangles(roots: Array, triangle: Array) -> Array:
    return np.asarray(np.linalg.qr(roots @ triangle, mode="r"))
