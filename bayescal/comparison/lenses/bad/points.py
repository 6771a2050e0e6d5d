"""Bad points by name, with how probable that is under all lenses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.calibration.judging.bad_points import BadPoints
from bayescal.comparison.lenses.off_point import BadPoint
from bayescal.points.views.views import Views

TOLD = 0.05  # probability: points less likely bad are not listed


@dataclass(frozen=True)
class Bad:
    """Points that are taken for bad, or may be.

    Attributes
    ----------
    points : tuple of BadPoint
        The likeliest first, then the farthest.
    fraction : float
        Of bad points, posterior mean.
    """

    points: tuple[BadPoint, ...]
    fraction: float

    def words(self, n: int) -> str:
        """Say how many of `n` points are taken for bad."""
        gone = self.left_out
        if not gone:
            return f"No point of {n} is taken for bad."
        farthest = max(gone, key=lambda point: point.size).far
        if len(gone) == 1:
            return f"1 of {n} points is taken for bad and left out: {farthest}."
        return f"{len(gone)} of {n} points are taken for bad and left out, the farthest {farthest}."

    @property
    def left_out(self) -> tuple[BadPoint, ...]:
        """Those without which lenses are drawn."""
        return tuple(point for point in self.points if point.left_out)


def bad_points(
    lenses: Sequence[tuple[BadPoints, float]], common: Sequence[int], views: Views
) -> Bad:
    """Name points that may be bad.

    Parameters
    ----------
    lenses : sequence of tuple
        Sets of bad points under each lens, and its probability; the best first.
    common : sequence of int
        Places without which all lenses are judged.
    """
    sets, probabilities = zip(*lenses, strict=True)
    weights = np.array(probabilities) / math.fsum(probabilities)
    chance = np.einsum("l,lvn->vn", weights, np.array([s.chance for s in sets]))
    fraction = float(weights @ [s.fraction for s in sets])
    gone, n_places = frozenset(common), chance.shape[1]
    told = sorted({*np.flatnonzero(chance > TOLD).tolist(), *gone})
    found = []
    for place in told:
        view, at = divmod(place, n_places)
        point = views.slices[view].start + at
        r, c = sets[0].shift[view, at].tolist()
        label, where = views.label(point), views.place(point)
        chances = float(chance[view, at])
        found.append(
            BadPoint(point, views.names[view], label, where, (r, c), chances, place in gone)
        )
    return Bad(tuple(sorted(found, key=lambda p: (-round(p.probability, 3), -p.size))), fraction)
