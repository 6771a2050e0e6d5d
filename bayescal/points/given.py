"""What is given as arrays: numbers, of the right shape, none infinite or too large."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.errors import InputError


def numbers(values: ArrayLike, what: str) -> Array:
    """Make an array of what is given, or complain."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be an array of numbers") from None


def table(values: ArrayLike, columns: int, what: str, rows: str = "n_points") -> Array:
    """Make ``(n, columns)`` of what is given; (n, 1, columns), as OpenCV has it, is that too."""
    array = numbers(values, what)
    if array.size == 0:
        array = array.reshape(0, columns)
    if array.ndim == 3 and 1 in array.shape[:2]:
        array = array.reshape(-1, array.shape[2])
    if array.ndim != 2 or array.shape[1] != columns:
        raise InputError(f"{what} must have shape ({rows}, {columns}), not {array.shape}")
    return array


def check_bounded(array: Array, what: str, limit: float) -> None:
    """Refuse numbers that are NaN, infinite or above a limit."""
    if not (np.abs(array) < limit).all():
        raise InputError(f"{what} holds a number that is NaN, infinite or above {limit:g}")
