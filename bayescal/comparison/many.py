"""Many points, brought to what a comparison needs of them: a factorisation and a sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.comparison.orders.averaging import USUAL
from bayescal.comparison.orders.beyond import BEYOND
from bayescal.comparison.settings import HIGHEST_ORDER, Settings
from bayescal.linear.reduction import Reduction
from bayescal.points.chunks.drawn import Drawn
from bayescal.points.chunks.many import ManyPoints
from bayescal.points.chunks.tally import Tally
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.whole import Whole

AxisOf: TypeAlias = Callable[[Correspondences, str], AxisData]
# A defence of more points reads them again, and leaves out groups and draws.
DEFENDED = 10_000
# Place of the sample's random numbers among those of a seed.
SAMPLE = 1000


def can_reduce(points: ManyPoints, settings: Settings) -> bool:
    """Whether an analysis needs no more of points than their reduction and a sample.

    Robust noise, replicates and errors of the world coordinates look at every point, and a defence
    of not too many does more with all of them at hand.
    """
    robust, replicates = settings.choice.robust, settings.sigma == "replicates"
    at_hand = settings.defend and points.found.about <= DEFENDED
    return points.exact_world and not (robust or replicates or at_hand)


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
    wanted = {
        axis: (separable.axis_data, axis, max(beyond(some[-1], BEYOND), USUAL))
        for axis, some in orders.items()
    }
    return reduced(points, wanted, settings)


def beyond(highest: int, more: int) -> int:
    """Give the order that a look beyond the highest wanted needs."""
    return min(highest, HIGHEST_ORDER) + more


def reduced(
    points: ManyPoints, wanted: Mapping[str, tuple[AxisOf, str, int]], settings: Settings
) -> tuple[Correspondences, dict[str, Whole]]:
    """Reduce axes, each up to an order, and draw a sample."""
    drawn = Drawn(np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=(SAMPLE,))))
    tally = Tally()
    sums: dict[str, Reduction] = {}
    with threadpool_limits(1):
        for chunk in points:
            for name, (axis_of, axis, order) in wanted.items():
                data = axis_of(chunk, axis)
                across = data.other is not None
                reduction = sums.setdefault(name, Reduction(order, across=across))
                reduction.add(data.x, data.t, data.sd, data.other)
            drawn.add(chunk)
            tally.add(chunk)
    sample = drawn.points(points.digest(), (*points.found.notes, *tally.notes()))
    return sample, {name: reduction.whole() for name, reduction in sums.items()}
