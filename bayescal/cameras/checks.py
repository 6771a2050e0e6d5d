"""Checks of the arrays that the camera's geometry is given, and of what comes out."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.errors import InputError
from bayescal.points.correspondences import LARGEST


def finite_table(values: ArrayLike, columns: int, what: str) -> Array:
    """Float64 array of rows of `columns` numbers, ``(n, columns)``; n may be 0.

    Raises
    ------
    InputError
        Where the shape differs or a number is NaN, infinite or above 1e100;
        `what` names the array.
    """
    table = np.asarray(values, dtype=np.float64)
    if table.ndim != 2 or table.shape[1] != columns:
        raise InputError(f"{what} must have shape (n, {columns}), not {table.shape}")
    bad = np.flatnonzero(~(np.abs(table) < LARGEST).all(axis=1))
    if bad.size:
        raise InputError(
            f"{what}, point {int(bad[0]) + 1}: holds a number that is NaN, infinite or above "
            f"{LARGEST}; mend it"
        )
    return table


def finite_vector(values: ArrayLike, size: int | None, what: str) -> Array:
    """Float64 vector of `size` numbers, ``(size,)``; of any number where `size` is None.

    Raises
    ------
    InputError
        Where the shape differs or a number is NaN, infinite or above 1e100;
        `what` names the vector.
    """
    vector = np.asarray(values, dtype=np.float64)
    if vector.ndim != 1 or size not in (None, len(vector)):
        raise InputError(f"{what} must have shape ({size or 'm'},), not {vector.shape}")
    if not (np.abs(vector) < LARGEST).all():
        raise InputError(f"{what} holds a number that is NaN, infinite or above {LARGEST}; mend it")
    return vector


def positive(value: float, what: str) -> float:
    """Return `value`, a positive finite number.

    Raises
    ------
    InputError
        Where it is not; `what` names it.
    """
    if not 0 < value < LARGEST:
        raise InputError(f"{what} must be a positive finite number, not {value:g}")
    return float(value)


def pixel_sizes(values: ArrayLike) -> Array:
    """Width and height of a pixel, ``(2,)``.

    Raises
    ------
    InputError
        Where they are not two positive finite numbers.
    """
    size = finite_vector(values, 2, "pixel size")
    if not (size > 0).all():
        raise InputError(
            f"pixel size must be two positive numbers, not {size[0]:g} and {size[1]:g}"
        )
    return size


def bounded(image: Array) -> Array:
    """Return image points, ``(n, columns)``, none of which overflowed.

    Raises
    ------
    InputError
        Naming the first that did.
    """
    bad = np.flatnonzero(~(np.abs(image) < LARGEST).all(axis=1))
    if bad.size:
        raise InputError(f"point {int(bad[0]) + 1}: its image is above {LARGEST}; remove the point")
    return image
