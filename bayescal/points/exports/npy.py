"""Arrays that NumPy saved (.npy): x, y, z, r, c in columns, or fields of these names."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.exports.found import Found
from bayescal.points.tables.columns import REQUIRED
from bayescal.points.tables.content import Content
from bayescal.points.tables.sniffing import Line, TextTable

NAME = "NumPy array"
MARK = b"\x93NUMPY"


def recognises(content: Content) -> bool:
    """Whether it bears NumPy's mark."""
    return content.raw.startswith(MARK)


def read(content: Content, _view: str | None) -> Found:
    """Read its columns."""
    stream = io.BytesIO(content.raw)
    count, dtype, fortran = header(content.name, stream)
    raw = np.frombuffer(stream.read(), dtype)
    names, rows = _columns(content.name, raw, count, fortran=fortran)
    lines = tuple(
        Line(i, tuple(map(repr, row))) for i, row in enumerate(zip(*rows, strict=True), 1)
    )
    return Found(TextTable(content.name, names, lines, place=", row "))


def header(name: str, stream: BinaryIO) -> tuple[int, np.dtype[Any], bool]:
    """Read the number of points, the type of an entry and whether columns stand one by one.

    Raises
    ------
    InputError
        Where it is damaged, or of another shape; no pickle is opened.
    """
    try:
        version = np.lib.format.read_magic(stream)
        old = version == (1, 0)
        parse = np.lib.format.read_array_header_1_0 if old else np.lib.format.read_array_header_2_0
        shape, fortran, dtype = parse(stream)
    except ValueError as error:
        raise InputError(f"{name}: is a damaged {NAME}: {str(error)[:100]}; save it anew") from None
    fields = dtype.names is not None
    numbers = (dtype,) if dtype.names is None else tuple(dtype[field] for field in dtype.names)
    if any(kind.kind not in "fiu" for kind in numbers) or not (
        (fields and len(shape) == 1) or (not fields and len(shape) == 2 and shape[1] == 5)
    ):
        raise InputError(
            f"{name}: holds an array {shape} of {dtype}; give one of x, y, z, r, c, (n_points, 5), "
            "or a table of named fields"
        )
    return shape[0], dtype, fortran and not fields


def _columns(
    name: str, raw: Any, count: int, *, fortran: bool
) -> tuple[tuple[str, ...], list[list[float]]]:
    """Name the columns of entries as they were stored, and list their numbers."""
    if raw.dtype.names is not None:
        if len(raw) != count:
            raise InputError(f"{name}: is cut off; save it anew")
        return raw.dtype.names, [raw[field].astype(float).tolist() for field in raw.dtype.names]
    if raw.size != 5 * count:
        raise InputError(f"{name}: is cut off; save it anew")
    table = raw.reshape((5, count) if fortran else (count, 5)).astype(float)
    return REQUIRED, (table if fortran else table.T).tolist()


def parts(path: Path, rows: int) -> Iterator[tuple[int, Mapping[str, Array]]]:
    """Read a file so many rows at a time: points before them, and their columns by name."""
    with path.open("rb") as stream:
        count, dtype, fortran = header(str(path), stream)
        for start in range(0, count, rows):
            size = min(rows, count - start)
            if fortran:
                table = np.load(path, mmap_mode="r", allow_pickle=False)[start : start + size]
                yield start, dict(zip(REQUIRED, np.array(table, dtype=float).T, strict=True))
                continue
            fields = dtype.names
            found = np.fromfile(stream, dtype, size if fields else 5 * size)
            if found.size != (size if fields else 5 * size):
                raise InputError(f"{path}: is cut off; save it anew")
            if fields:
                yield start, {name: found[name].astype(float) for name in fields}
            else:
                table = found.reshape(size, 5).astype(float, copy=False)
                yield start, dict(zip(REQUIRED, table.T, strict=True))
