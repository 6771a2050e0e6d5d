"""Whether neighbouring points have residuals alike: errors that are shared, or misfit."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import KDTree
from scipy.special import gammainc, gammaincc, ndtr

from bayescal.arrays import Array
from bayescal.comparison.adequacy.outcome import AdequacyTest, untested
from bayescal.comparison.adequacy.problem import Problem

NAME = "neighbours"
# Neighbours of each point that count.
NEAREST = 3
# Points below which the statistic is too far from normal.
FEWEST = 15


def neighbours(problem: Problem, place: Array) -> AdequacyTest:
    """Moran's I of the residuals over each point's nearest three in the image.

    I is the mean product of neighbouring residuals over their mean square: about their
    correlation. Mean, variance and skewness are those of least-squares residuals of independent
    normal errors: I is independent of e'e, so that its moments are ratios of theirs (Cliff & Ord
    1981, *Spatial Processes*, 8.3). The upper tail is of Pearson's type III with these moments:
    few points make it heavier than the normal's.

    Parameters
    ----------
    place : Array
        Predicted pixels of each point, ``(2, n_points)``, px.
    """
    if problem.unusable:
        return untested(NAME, problem.unusable)
    if problem.n < FEWEST:
        return untested(NAME, f"{problem.n} points are too few to have neighbours")
    _, nearest = KDTree(place.T).query(place.T, NEAREST + 1)
    first = np.repeat(np.arange(problem.n), NEAREST + 1)
    other = nearest.ravel() != first  # a point is no neighbour of itself
    pairs = (first[other], nearest.ravel()[other])
    links = coo_array((np.ones(other.sum()), pairs), shape=(problem.n,) * 2).tocsr()
    links = (links + links.T) / (2 * other.sum())
    e, q, dof = problem.e, problem.q, problem.dof
    reached = links @ q
    within = q.T @ reached
    # Traces of powers of (1 - q q') links.
    trace = -float(np.trace(within))
    square = float(links.multiply(links).sum()) - 2 * float((reached**2).sum())
    square += float((within**2).sum())
    cube = float((links @ links).multiply(links).sum())
    cube -= 3 * float((reached * (links @ reached)).sum())
    cube += 3 * float(((reached.T @ reached) * within).sum()) - float(
        np.trace(within @ within @ within)
    )
    mean = trace / dof
    sd = math.sqrt(2 * (dof * square - trace**2) / (dof + 2)) / dof
    third = (trace**3 + 6 * trace * square + 8 * cube) / (dof * (dof + 2) * (dof + 4))
    skewness = (third - 3 * mean * sd**2 - mean**3) / sd**3
    value = float(e @ (links @ e)) / problem.rss
    p = _upper_tail((value - mean) / sd, skewness)
    scale = problem.n
    says = "errors are shared, or the model misses" if p < 0.05 else "as chance would have it"
    meaning = (
        f"Residuals of a point and its nearest {NEAREST} in the image correlate by "
        f"{scale * value:.2f}, {scale * mean:.2f} ± {scale * sd:.2f} expected: {says}."
    )
    return AdequacyTest(NAME, "I", scale * value, None, p, meaning)


def _upper_tail(z: float, skewness: float) -> float:
    """Probability beyond z under Pearson's type III of mean 0, variance 1: a shifted gamma."""
    if abs(skewness) < 1e-3:
        return float(ndtr(-z))
    shape = 4 / skewness**2
    along = math.copysign(1, skewness) * z
    tail = gammaincc if skewness > 0 else gammainc
    return float(tail(shape, max(shape + along * math.sqrt(shape), 0.0)))
