"""How sure the projection is at places of the image, by posterior and views."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.density import Problem
from bayescal.calibration.observations import Observations
from bayescal.comparison.lenses.left_out import jackknife
from bayescal.comparison.lenses.prediction import (
    View,
    deviation,
    difference,
    observed_sample,
    response,
)
from bayescal.comparison.lenses.results import JudgedLens, Place


def named_places(size: tuple[float, float]) -> tuple[tuple[str, tuple[float, float]], ...]:
    """Centre, edges and corners of an image, px."""
    right, bottom = size[0] - 1, size[1] - 1
    r, c = right / 2, bottom / 2
    return (
        ("centre", (r, c)),
        ("left edge", (0.0, c)),
        ("right edge", (right, c)),
        ("top edge", (r, 0.0)),
        ("bottom edge", (r, bottom)),
        ("top left corner", (0.0, 0.0)),
        ("top right corner", (right, 0.0)),
        ("bottom left corner", (0.0, bottom)),
        ("bottom right corner", (right, bottom)),
    )


def places(
    best: JudgedLens,
    lenses: Sequence[JudgedLens],
    data: Observations,
    covariance: Array,
    two: tuple[Problem, Problem] | None,
    depth: float,
) -> tuple[Place, ...]:
    """Uncertainty at the named places.

    Parameters
    ----------
    best : JudgedLens
    lenses : sequence of JudgedLens
        All: what the probable ones predict otherwise adds to the variance.
    data : Observations
    covariance : Array
        Of the best lens's coordinates, the error models averaged.
    two : tuple of Problem or None
        The best lens fitted to two halves of the views.
    depth : float
        Of the target, diagonals.
    """
    names, pixels = zip(*named_places(data.size), strict=True)
    at, sample = np.array(pixels), observed_sample(data)
    problem = best.evidence.problem
    view = View(problem.model, problem.x)
    spreads = []
    for distance in (None, depth):
        own = deviation(response(view, at, sample, distance), covariance)
        spreads.append(np.hypot(own, between(view, lenses, at, sample, distance)))
    far = response(view, at, sample, None)
    jack = half = np.full(len(at), np.nan)
    if best.left_out is not None:
        jack = deviation(far, jackknife(best.left_out.lenses))
    if two is not None:
        apart = np.einsum("nai,i->na", far, two[0].x - two[1].x)
        # Half the views have twice the variance, and a difference of two of them four times.
        half = np.sqrt((apart**2).mean(axis=1)) / 2
    columns = zip(names, pixels, *spreads, jack, half, strict=True)
    return tuple(Place(name, at, *map(_known, values)) for name, at, *values in columns)


def between(
    view: View, lenses: Sequence[JudgedLens], at: Array, sample: Array, depth: float | None
) -> Array:
    """Deviation of the probable lenses' predictions about their mean, ``(n,)``, px."""
    moves, shares = [np.zeros((len(at), 2))], [lenses[0].probability]
    for judged in lenses[1:]:
        if judged.probability < 0.01:
            continue
        other = judged.evidence.problem
        moved = difference(view, View(other.model, other.x), at, sample, depth)
        moves.append(np.nan_to_num(moved))
        shares.append(judged.probability)
    weights = np.array(shares) / math.fsum(shares)
    gap = np.array(moves) - np.einsum("k,kna->na", weights, np.array(moves))
    return np.asarray(np.sqrt(np.einsum("k,kna->n", weights, gap**2) / 2))


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
