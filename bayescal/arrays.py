"""The array type used throughout, read-only arrays for frozen results, and ln 2 pi."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.intp]
ArrayLike: TypeAlias = Array | Sequence[float] | Sequence[Sequence[float]]

LOG_2PI = math.log(2 * math.pi)


def frozen(values: ArrayLike) -> Array:
    """Return `values` as a read-only float64 array of their own."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
