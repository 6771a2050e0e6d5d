"""How sure the projection is at places of the image, by posterior and views."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array, finite
from bayescal.calibration.model.observations import Observations
from bayescal.comparison.lenses.left_out import Split, jackknife
from bayescal.comparison.lenses.place import Place
from bayescal.comparison.lenses.prediction import (
    deviation,
    difference,
    observed_sample,
    response,
)
from bayescal.comparison.lenses.results import JudgedLens

PROBABLE = 0.01  # lenses less probable than this add next to nothing


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
    lenses: Sequence[JudgedLens],
    data: Observations,
    covariance: Array,
    halves: tuple[Split, ...],
) -> tuple[Place, ...]:
    """Uncertainty at the named places.

    Parameters
    ----------
    lenses : sequence of JudgedLens
        The best first: the other probable ones add their own variance, and what they predict
        otherwise.
    covariance : Array
        Of the best lens's coordinates, the error models averaged.
    halves : tuple of Split
        The best lens fitted to two halves of the views, where there are such.
    """
    names, pixels = zip(*named_places(data.size), strict=True)
    at, sample = np.array(pixels), observed_sample(data)
    best = lenses[0]
    view = best.view
    spreads = []
    for distance in (None, best.evidence.problem.poses.depth):
        spreads.append(averaged(lenses, covariance, at, sample, distance))
    far = response(view, at, sample, None)
    jack = half = np.full(len(at), np.nan)
    if best.without is not None:
        jack = deviation(far, jackknife(best.without))
    if halves:
        # Halves are rarely equal: each split is in units of its own deviation.
        with np.errstate(divide="ignore", invalid="ignore"):
            squares = [
                ((far @ split.apart) ** 2).mean(axis=1) / deviation(far, split.covariance) ** 2
                for split in halves
            ]
        half = deviation(far, covariance) * np.sqrt(np.mean(squares, axis=0))
    columns = zip(names, pixels, *spreads, jack, half, strict=True)
    return tuple(Place(name, at, *map(finite, values)) for name, at, *values in columns)


def averaged(
    lenses: Sequence[JudgedLens],
    covariance: Array,
    at: Array,
    sample: Array,
    depth: float | None,
) -> Array:
    """Deviation of the prediction, each probable lens's own and between them, ``(n,)``, px.

    Parameters
    ----------
    covariance : Array
        Of the best lens; the others have that of their most probable error model.
    """
    view = lenses[0].view
    moves = [np.zeros((len(at), 2))]
    variances = [deviation(response(view, at, sample, depth), covariance) ** 2]
    shares = [lenses[0].probability]
    for judged in lenses[1:]:
        if judged.probability < PROBABLE:
            continue
        maps = response(judged.view, at, sample, depth, seen_by=view)
        own = deviation(maps, judged.evidence.problem.laplace.covariance)
        moves.append(np.nan_to_num(difference(view, judged.view, at, sample, depth)))
        variances.append(np.nan_to_num(own) ** 2)
        shares.append(judged.probability)
    weights = np.array(shares) / math.fsum(shares)
    gap = np.array(moves) - np.einsum("k,kna->na", weights, np.array(moves))
    variance = weights @ (np.array(variances) + (gap**2).mean(axis=2))
    return np.asarray(np.sqrt(variance))
