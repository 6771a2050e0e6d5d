"""What the coefficients of a planar lens add to a point (a, b), and the derivatives of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses.polynomial import horner, horner_slope


@dataclass(frozen=True, eq=False)
class Terms:
    """What one group of coefficients adds: u and v, and their derivatives, each ``(..., n)``."""

    plane: tuple[Array, Array]
    by_plane: tuple[tuple[Array, Array], tuple[Array, Array]]  # u by a, b; v by a, b
    by_coefficient: list[tuple[Array, Array]]  # of each: u, v


def radial_terms(a: Array, b: Array, above: Array, below: Array, step: int) -> Terms:
    """Make a g and b g, with k1, k2, ... above the line and then those below."""
    if not above.shape[-1] + below.shape[-1]:  # however far out the point is
        one, zero = np.ones_like(a), np.zeros_like(a)
        return Terms((a, b), ((one, zero), (zero, one)), [])
    square = a**2 + b**2
    t = square if step == 2 else np.sqrt(square)
    over = 1 / horner(below, t)
    gain = horner(above, t) * over
    rise = (horner_slope(above, t) - gain * horner_slope(below, t)) * over  # dg/dt
    # dg/da is a times this.
    bend = 2 * rise if step == 2 else np.where(t == 0, 0, rise / np.where(t == 0, 1, t))
    powers, power = [], over
    for _ in range(max(above.shape[-1], below.shape[-1])):
        power = power * t
        powers.append(power)
    slopes = [(a * power, b * power) for power in powers[: above.shape[-1]]]
    slopes += [(-a * gain * power, -b * gain * power) for power in powers[: below.shape[-1]]]
    cross = a * b * bend
    by_plane = ((gain + a**2 * bend, cross), (cross, gain + b**2 * bend))
    return Terms((a * gain, b * gain), by_plane, slopes)


def tangential_terms(a: Array, b: Array, p1: Array, p2: Array) -> Terms:
    """Brown's decentering."""
    cross, wide, tall = 2 * a * b, 3 * a**2 + b**2, a**2 + 3 * b**2
    lean = 2 * (p1 * a + p2 * b)
    by_plane = ((2 * p1 * b + 6 * p2 * a, lean), (lean, 6 * p1 * b + 2 * p2 * a))
    plane = (p1 * cross + p2 * wide, p1 * tall + p2 * cross)
    return Terms(plane, by_plane, [(cross, tall), (wide, cross)])


def prism_terms(a: Array, b: Array, s1: Array, s2: Array, s3: Array, s4: Array) -> Terms:
    """Add s1 w^2 + s2 w^4 to u, the same with s3 and s4 to v."""
    square, zero = a**2 + b**2, np.zeros_like(a)
    steep_u, steep_v = 2 * (s1 + 2 * s2 * square), 2 * (s3 + 2 * s4 * square)
    by_plane = ((a * steep_u, b * steep_u), (a * steep_v, b * steep_v))
    plane = (square * (s1 + s2 * square), square * (s3 + s4 * square))
    slopes = [(square, zero), (square**2, zero), (zero, square), (zero, square**2)]
    return Terms(plane, by_plane, slopes)
