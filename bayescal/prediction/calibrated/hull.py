"""Convex hulls in the plane: where calibration points were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array


def hull_of(points: Array) -> Array:
    """Corners of the convex hull of points ``(n, 2)``, counterclockwise, ``(m, 2)``.

    Andrew's monotone chain (1979). Points on a line give their two ends.
    """
    ordered = np.unique(points, axis=0)
    if len(ordered) < 3:
        return ordered
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(points: Array) -> list[Array]:
    out: list[Array] = []
    for point in points:
        while len(out) > 1 and _turn(out[-2], out[-1], point) <= 0:
            out.pop()
        out.append(point)
    return out


def _turn(a: Array, b: Array, p: Array) -> float:
    return float((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]))


def within(hull: Array, points: Array) -> NDArray[np.bool_]:
    """Which points ``(..., 2)`` lie in a convex hull or on its edge, to rounding, ``(...)``."""
    if len(hull) < 3:
        return np.zeros(points.shape[:-1], dtype=bool)
    inside = np.ones(points.shape[:-1], dtype=bool)
    slack = 1e-9 * float(np.ptp(hull, axis=0).max()) ** 2
    for a, b in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        cross = (b[0] - a[0]) * (points[..., 1] - a[1]) - (b[1] - a[1]) * (points[..., 0] - a[0])
        inside &= cross >= -slack
    return inside
