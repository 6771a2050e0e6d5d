"""Points in chunks of what holds numbers as numbers: arrays, .npy and Parquet files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.chunks.chunk import HELD, Found, Lazily, chunk_of
from bayescal.points.correspondences import Correspondences
from bayescal.points.exports import npy
from bayescal.points.reader import COLUMNS
from bayescal.points.setup import Setup
from bayescal.points.tables.columns import REQUIRED, TEXTS, match_columns, reading_note
from bayescal.points.tables.sniffing import TextTable

# Points of a chunk: a few megabytes.
ROWS = 65536


def cut(points: Correspondences, setup: Setup) -> Iterator[Correspondences]:
    """Cut correspondences that are held into chunks."""
    for start in range(0, len(points), ROWS):
        part = slice(start, start + ROWS)
        yield Correspondences(
            points.world[part],
            points.pixels[part],
            points.labels[part],
            None if points.groups is None else points.groups[part],
            {name: sd[part] for name, sd in points.sigma.items()},
            setup,
            points.source,
            None if points.lines is None else points.lines[part],
        )


def cut_array(table: Array, source: str, setup: Setup) -> Iterator[Correspondences]:
    """Cut an array of x, y, z, r, c, ``(n_points, 5)``, into chunks."""
    for start in range(0, len(table), ROWS):
        part = np.asarray(table[start : start + ROWS], dtype=float)
        yield chunk_of(source, start, dict(zip(REQUIRED, part.T, strict=True)), setup)


def of_npy(path: Path, stated: Mapping[str, str] | None) -> Found | None:
    """Read a .npy file chunk by chunk; None where its points are few."""
    with path.open("rb") as stream:
        count, dtype, _ = npy.header(str(path), stream)
    if count <= HELD:
        return None
    wanted, notes = _matched(str(path), dtype.names or REQUIRED, stated)

    def read(setup: Setup) -> Iterator[Correspondences]:
        for start, columns in npy.parts(path, ROWS):
            named = {quantity: columns[name] for quantity, name in wanted.items()}
            yield chunk_of(str(path), start, named, setup)

    return Found(count, frozenset(wanted), read, notes)


def of_parquet(path: Path, stated: Mapping[str, str] | None) -> Found | None:
    """Read a Parquet file by pyarrow; None where its points are few, or it can't be read."""
    if find_spec("pyarrow") is None:
        return None  # who reads it at once says what to install
    from pyarrow import ArrowException, parquet

    try:
        with parquet.ParquetFile(path) as file:
            count, names = file.metadata.num_rows, tuple(file.schema_arrow.names)
    except (ArrowException, OSError):
        return None  # likewise
    if count <= HELD or len(set(names)) < len(names):
        return None
    wanted, notes = _matched(str(path), names, stated)

    def read(setup: Setup) -> Iterator[Correspondences]:
        start = 0
        with parquet.ParquetFile(path) as file:
            for batch in file.iter_batches(ROWS, columns=list(wanted.values()), use_threads=False):
                found = {quantity: batch.column(name) for quantity, name in wanted.items()}
                yield _batch(str(path), start, found, setup)
                start += batch.num_rows

    return Found(count, frozenset(wanted), read, notes)


def _matched(
    source: str, names: tuple[str, ...], stated: Mapping[str, str] | None
) -> tuple[dict[str, str], tuple[str, ...]]:
    """Find each quantity's column, and say what was assumed."""
    table = TextTable(source, names, (), place=", row ")
    index = match_columns(table, COLUMNS, stated)
    notes = reading_note(table, index, decimal_commas=False)
    return {quantity: names[i] for quantity, i in index.items()}, notes


def _batch(source: str, start: int, found: Mapping[str, Any], setup: Setup) -> Correspondences:
    """Make a chunk of a batch of pyarrow's columns."""
    columns: dict[str, Array] = {}
    texts: dict[str, Sequence[str]] = {}
    for quantity, column in found.items():
        if quantity in TEXTS:
            texts[quantity] = _words(column)
            continue
        try:
            columns[quantity] = np.asarray(column.cast("float64").fill_null(np.nan))
        except ValueError as error:  # of pyarrow's, where words stand for numbers
            why = " ".join(str(error).split())[:100]
            raise InputError(
                f"{source}, rows {start + 1} to {start + len(column)}: {quantity}: {why}; "
                "correct it"
            ) from None
    return chunk_of(source, start, columns, setup, texts=texts)


def _words(column: Any) -> Sequence[str]:
    """Texts of a column of pyarrow, made where they are asked for."""

    def word(index: int) -> str:
        value = column[index].as_py()
        return "" if value is None else str(value)

    return Lazily(len(column), word)
