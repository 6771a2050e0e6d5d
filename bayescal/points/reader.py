"""Reads points files: CSV or TSV with a header."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES, LARGEST, LARGEST_PX, SMALLEST_PX, Setup, load_setup
from bayescal.points.text import decode, quoted, reason

REQUIRED = ("x", "y", "z", "r", "c")
PIXEL_SIGMAS = ("sigma_r", "sigma_c")
WORLD_SIGMAS = ("sigma_x", "sigma_y", "sigma_z")
SIGMAS = PIXEL_SIGMAS + WORLD_SIGMAS
TEXTS = ("label", "group")
KNOWN = (*REQUIRED, *TEXTS, *SIGMAS)


@dataclass(frozen=True)
class _Row:
    """One data row: the file's line and its fields by column."""

    line: int
    fields: dict[str, str]


def load(source: str | Path, setup: Setup | str | Path | None = None) -> Correspondences:
    """Read correspondences from a CSV or TSV file with a header.

    Parameters
    ----------
    source : str or Path
        The file, or ``"-"`` for standard input. Columns ``x, y, z, r, c`` and
        optionally ``label, group``, ``sigma_r, sigma_c`` (px) and ``sigma_x, sigma_y,
        sigma_z`` (world units), in any order and case; lines that start with ``#`` are
        comments. UTF-8, with or without a BOM.
    setup : Setup or str or Path, optional
        What is known of the camera, or the TOML file that says it.

    Returns
    -------
    Correspondences

    Raises
    ------
    InputError
        Where the file can't be used; the message names its line.
    """
    name, raw = _read_bytes(source)
    rows = list(_rows(name, decode(name, raw)))
    if not rows:
        raise InputError(f"{name}: there are no points below the header; add at least two")
    columns = {column: [row.fields[column] for row in rows] for column in rows[0].fields}
    numbers = {
        column: [_number(name, row, column) for row in rows]
        for column in (*REQUIRED, *SIGMAS)
        if column in columns
    }
    camera = setup if isinstance(setup, Setup) or setup is None else load_setup(setup)
    points = Correspondences.from_arrays(
        list(zip(*(numbers[c] for c in "xyz"), strict=True)),
        list(zip(*(numbers[c] for c in "rc"), strict=True)),
        labels=tuple(columns["label"]) if "label" in columns else None,
        groups=tuple(columns["group"]) if "group" in columns else None,
        **{column: numbers[column] for column in SIGMAS if column in numbers},
        setup=camera,
    )
    return Correspondences(
        points.world,
        points.pixels,
        points.labels,
        points.groups,
        points.sigma,
        points.setup,
        source=name,
        lines=tuple(row.line for row in rows),
        sha256=hashlib.sha256(raw).hexdigest(),
    )


def _read_bytes(source: str | Path) -> tuple[str, bytes]:
    if str(source) == "-":
        if sys.stdin is None:  # closed by the shell
            raise InputError("standard input: is closed; pipe the points in or name a file")
        return "standard input", sys.stdin.buffer.read()
    try:
        return str(source), Path(source).read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(f"{source}: {reason(error)}; give a points file") from None


def _rows(name: str, text: str) -> Iterator[_Row]:
    """Yield the data rows below the header, each checked for its number of fields."""
    header: list[str] = []
    for line, fields in _records(name, text):
        if not header:
            header = _header(name, line, fields)
        elif len(fields) != len(header):
            raise InputError(
                f"{name}:{line}: has {len(fields)} fields where the header has {len(header)} "
                f"({','.join(header)}); add or remove fields"
            )
        else:
            yield _Row(line, dict(zip(header, fields, strict=True)))
    if not header:
        raise InputError(f"{name}: is empty; the first line must name the columns x,y,z,r,c")


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


def _header(name: str, line: int, fields: list[str]) -> list[str]:
    header = [f.lower() for f in fields]
    where = f"{name}:{line}"
    if len(header) == 1 and ";" in header[0]:
        raise InputError(f"{where}: columns are separated by ';'; use commas or tabs")
    seen: set[str] = set()
    for column in header:
        if column in seen:
            raise InputError(f"{where}: column {quoted(column)} stands twice; keep one")
        seen.add(column)
    missing = [c for c in REQUIRED if c not in header]
    if missing:
        raise InputError(
            f"{where}: no column {', '.join(repr(c) for c in missing)}; "
            "the header must name x,y,z,r,c"
        )
    for column in header:
        if column not in KNOWN:
            raise InputError(
                f"{where}: unknown column {quoted(column)}; remove it or use one of "
                f"{', '.join(KNOWN)}"
            )
    return header


def _number(name: str, row: _Row, column: str) -> float:
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


def axis_names(axis: str) -> tuple[str, ...]:
    """Axes that the option ``--axis r|c|both`` means."""
    if axis == "both":
        return AXES
    if axis in AXES:
        return (axis,)
    raise InputError(f"axis must be r, c or both, not {axis!r}")
