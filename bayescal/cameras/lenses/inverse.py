"""The inverse of a function that grows from 0: Newton's method inside a bracket."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bayescal.arrays import Array

_EPS = float(np.finfo(np.float64).eps)
# Bisection alone halves a bracket to rounding in about 60 steps; Newton's method takes some 7.
_MOST_STEPS = 200
_MOST_DOUBLINGS = 400
_NEAR = 1e-6


def invert(curve: Callable[[Array], tuple[Array, Array]], target: Array, high: Array) -> Array:
    """Arguments in [0, high] at which a growing curve reaches `target` >= 0, ``(..., n)``.

    Newton's step is taken where it stays in the bracket and at least halves the last one, else
    the bracket is halved (Press et al. 2007, section 9.4). Targets beyond the curve's largest
    value end at `high`.

    Parameters
    ----------
    curve : callable
        Values and slopes at arguments, ``(..., n)`` each; 0 at 0.
    target : Array
        ``(..., n)``.
    high : Array
        Largest arguments, ``(..., n)``; infinite where there is none.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        low, high = np.zeros_like(target), _bracket(curve, target, high)
        # Never at `high` itself: there a pole may show its other side.
        w = np.where(target < high, target, high / 2)
        moved, done = high - low, (target == 0) | ~np.isfinite(target)
        for _ in range(_MOST_STEPS):
            value, slope = curve(w)
            below = value < target
            low, high = np.where(below, w, low), np.where(below, high, w)
            step = (target - value) / slope
            newton = w + step
            # Rounding alone is left to correct; beside a pole any step is as small.
            near = np.abs(value - target) <= _NEAR * target
            settled = near & (np.abs(step) <= 8 * _EPS * w)
            trusted = (newton >= low) & (newton < high) & (np.abs(step) <= moved / 2)
            new = np.where(trusted | settled, newton, low + (high - low) / 2)
            new = np.where(done, w, new)
            done |= settled | (high - low <= 2 * _EPS * w)
            moved, w = np.abs(new - w), new
            if done.all():
                break
    return w


def _bracket(curve: Callable[[Array], tuple[Array, Array]], target: Array, high: Array) -> Array:
    """Upper ends that are finite: doubled from twice the target until the curve is above it."""
    endless = ~np.isfinite(high)
    high = np.where(endless, np.where(np.isfinite(target), 2 * target, 1.0), high)
    for _ in range(_MOST_DOUBLINGS):
        short = endless & (curve(high)[0] < target)
        if not short.any():
            break
        high = np.where(short, 2 * high, high)
    return high
