"""The array type used throughout, read-only arrays, arrays as a file and in parts, ln 2 pi."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.intp]
ArrayLike: TypeAlias = Array | Sequence[float] | Sequence[Sequence[float]]

Rows = TypeVar("Rows", Array, IntArray)

# What reading a file of arrays raises where it is none, or says that it is too large.
DAMAGE = (
    *(ValueError, KeyError, TypeError, AttributeError),
    *(OSError, EOFError, MemoryError, zipfile.BadZipFile),
)
LOG_2PI = math.log(2 * math.pi)


def frozen(values: ArrayLike) -> Array:
    """Return `values` as a read-only float64 array of their own."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def in_parts(rows: Rows, numbers: int, most: int) -> list[Rows]:
    """Cut rows so that the numbers held at once, so many for each row, are `most` at the most."""
    step = max(1, most // numbers)
    return [rows[i : i + step] for i in range(0, len(rows), step)]


def finite(value: float) -> float | None:
    """Turn what could not be computed into None."""
    return float(value) if math.isfinite(value) else None


def to_npz(head: Mapping[str, Any], arrays: Mapping[str, Array], name: str = "head") -> bytes:
    """Encode arrays as NumPy keeps them (npz), and JSON under a name: the same, the same bytes."""
    kept: dict[str, Any] = {name: np.frombuffer(json.dumps(head).encode(), np.uint8), **arrays}
    stream = io.BytesIO()
    np.savez(stream, **kept)
    return stream.getvalue()


def from_npz(raw: bytes, name: str = "head") -> tuple[dict[str, Any], dict[str, Array]]:
    """Undo `to_npz`, without pickle: a file from elsewhere can't run anything.

    Raises
    ------
    ValueError
        Where it is no such file, or is damaged.
    """
    try:
        with np.load(io.BytesIO(raw), allow_pickle=False) as kept:
            arrays = {key: kept[key] for key in kept.files}
        head = json.loads(arrays.pop(name).tobytes())
    except KeyError as error:
        raise ValueError(f"lacks {error}") from None
    except DAMAGE as error:
        raise ValueError(" ".join(str(error).split()) or "is cut off") from None
    return head, arrays
