"""The array type used throughout, and read-only arrays for frozen results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.intp]
ArrayLike: TypeAlias = Array | Sequence[float] | Sequence[Sequence[float]]


def frozen(values: ArrayLike) -> Array:
    """Return `values` as a read-only float64 array of their own."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
