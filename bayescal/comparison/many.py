"""Many points, brought to what a comparison needs of them: a factorisation and a sample."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.comparison.defence.stability import BEYOND
from bayescal.comparison.orders.averaging import USUAL
from bayescal.comparison.settings import HIGHEST_ORDER, Settings
from bayescal.errors import InputError
from bayescal.linear.reduction import Reduction
from bayescal.points.chunks.drawn import Drawn
from bayescal.points.chunks.many import ManyPoints
from bayescal.points.chunks.tally import Tally
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials import separable
from bayescal.polynomials.whole import Whole
from bayescal.rounding import grouped

# The most points of which a defence is made.
DEFENDED = 10_000
# Place of the sample's random numbers among those of a seed.
SAMPLE = 1000


def can_reduce(points: ManyPoints, settings: Settings) -> bool:
    """Whether an analysis needs no more of points than their reduction and a sample.

    Robust noise, replicates, errors of the world coordinates and a defence look at every point.

    Raises
    ------
    InputError
        Where there are too many to defend an order.
    """
    if settings.defend and not can_defend(points):
        raise InputError(
            f"{points.source}: a defence removes and resamples points, which is done for at most "
            f"{grouped(DEFENDED)}; drop --defend (defend=True), or give a sample"
        )
    robust, replicates = settings.choice.robust, settings.sigma == "replicates"
    return points.exact_world and not (robust or replicates or settings.defend)


def can_defend(points: ManyPoints | Correspondences) -> bool:
    """Whether points are few enough to be removed and resampled."""
    count = points.found.about if isinstance(points, ManyPoints) else points.n
    return count <= DEFENDED


def reduce_points(
    points: ManyPoints, orders: Mapping[str, tuple[int, ...]], settings: Settings
) -> tuple[Correspondences, dict[str, Whole]]:
    """Read points once: reduce the axes wanted, and draw a sample.

    Parameters
    ----------
    orders : mapping of str to tuple of int
        Orders of each axis, ascending.

    Returns
    -------
    sample : Correspondences
        At most `bayescal.points.chunks.chunk.HELD` of the points.
    whole : dict of str to Whole
        By axis, up to what a look beyond the orders wanted needs.

    Raises
    ------
    InputError
        Where a point can't be used; the message names it.
    """
    drawn = Drawn(np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=(SAMPLE,))))
    tally = Tally()
    sums = {
        axis: Reduction(max(min(wanted[-1], HIGHEST_ORDER) + BEYOND, USUAL))
        for axis, wanted in orders.items()
    }
    with threadpool_limits(1):
        for chunk in points:
            for axis, reduction in sums.items():
                data = separable.axis_data(chunk, axis)
                reduction.add(data.x, data.t, data.sd)
            drawn.add(chunk)
            tally.add(chunk)
    sample = drawn.points(points.digest(), (*points.found.notes, *tally.notes()))
    return sample, {axis: reduction.whole() for axis, reduction in sums.items()}
