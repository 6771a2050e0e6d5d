"""Tables that people write: CSV or TSV with a header, comments, and numbers checked one by one."""

from __future__ import annotations

import csv
import io
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.setup import LARGEST, LARGEST_PX, SMALLEST_PX
from bayescal.points.text import quoted, reason

PIXEL_SIGMAS = ("sigma_r", "sigma_c")
WORLD_SIGMAS = ("sigma_x", "sigma_y", "sigma_z")


@dataclass(frozen=True)
class Columns:
    """Columns of a kind of table: those it must have, and all it may have."""

    required: tuple[str, ...]
    known: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """One data row: the file's line and its fields by column."""

    line: int
    fields: dict[str, str]


def read_bytes(source: str | Path, what: str = "a points file") -> tuple[str, bytes]:
    """Read a file, or standard input for "-": its name for messages, and its bytes."""
    if str(source) == "-":
        if sys.stdin is None:  # closed by the shell
            raise InputError("standard input: is closed; pipe the points in or name a file")
        return "standard input", sys.stdin.buffer.read()
    try:
        return str(source), Path(source).read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"{source}: {reason(error)}; give {what}") from None


def rows(name: str, text: str, columns: Columns) -> Iterator[Row]:
    """Yield the data rows below the header, each checked for its number of fields."""
    header: list[str] = []
    for line, fields in _records(name, text):
        if not header:
            header = _header(name, line, fields, columns)
        elif len(fields) != len(header):
            raise InputError(
                f"{name}:{line}: has {len(fields)} fields where the header has {len(header)} "
                f"({','.join(header)}); add or remove fields"
            )
        else:
            yield Row(line, dict(zip(header, fields, strict=True)))
    if not header:
        raise InputError(
            f"{name}: is empty; the first line must name the columns {','.join(columns.required)}"
        )


def _records(name: str, text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield (line, stripped fields) of every line that is not blank or a comment."""
    lines = io.StringIO(text, newline=None).read().split("\n")
    # Comments become blank lines, so that the reader's count stays the file's.
    kept = ["" if line.lstrip().startswith("#") else line for line in lines]
    first = next((line for line in kept if line.strip()), "")
    delimiter = "\t" if "\t" in first else ","
    reader = csv.reader((line + "\n" for line in kept), delimiter=delimiter, strict=True)
    start = 1  # of the record: a quoted field may go on over several lines
    try:
        for record in reader:
            fields = [f.strip() for f in record]
            if any(fields):
                yield start, fields
            start = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{name}:{start}: {error}; mend the line's quotes") from None


def _header(name: str, line: int, fields: list[str], columns: Columns) -> list[str]:
    header = [f.lower() for f in fields]
    where = f"{name}:{line}"
    if len(header) == 1 and ";" in header[0]:
        raise InputError(f"{where}: columns are separated by ';'; use commas or tabs")
    seen: set[str] = set()
    for column in header:
        if column in seen:
            raise InputError(f"{where}: column {quoted(column)} stands twice; keep one")
        seen.add(column)
    missing = [c for c in columns.required if c not in header]
    if missing:
        raise InputError(
            f"{where}: no column {', '.join(repr(c) for c in missing)}; "
            f"the header must name {','.join(columns.required)}"
        )
    for column in header:
        if column not in columns.known:
            raise InputError(
                f"{where}: unknown column {quoted(column)}; remove it or use one of "
                f"{', '.join(columns.known)}"
            )
    return header


def number(name: str, row: Row, column: str) -> float:
    """Parse a field of a row, refusing what no such column can hold."""
    text = row.fields[column]
    where = f"{name}:{row.line}: {column}"
    try:
        value = float("not a number" if "_" in text else text)
    except ValueError:
        raise InputError(f"{where}: {quoted(text)} where a number should be; mend it") from None
    if not math.isfinite(value):
        raise InputError(f"{where}: is {value:g}; every point needs finite numbers")
    if column in WORLD_SIGMAS and value < 0:
        raise InputError(f"{where}: is {value:g}; a standard deviation can't be negative")
    if column in PIXEL_SIGMAS and not SMALLEST_PX <= value <= LARGEST_PX:
        raise InputError(
            f"{where}: is {value:g}; a standard deviation must be positive, from {SMALLEST_PX:g} "
            f"to {LARGEST_PX:g} px"
        )
    if column in "rc" and abs(value) >= LARGEST_PX:
        raise InputError(f"{where}: is {value:g}; no pixel is that far out; mend it")
    if abs(value) >= LARGEST:
        raise InputError(f"{where}: is {value:g}, too large; use other units")
    return value
