"""Tables that people write, row by row under our names, and numbers checked one by one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from bayescal.errors import InputError
from bayescal.points.setup import LARGEST, LARGEST_PX, SMALLEST_PX
from bayescal.points.tables.columns import (
    PIXEL_SIGMAS,
    TEXTS,
    WORLD_SIGMAS,
    Columns,
    match_columns,
    reading_note,
)
from bayescal.points.tables.sniffing import TextTable, parse_table, with_points
from bayescal.points.tables.text import quoted


@dataclass(frozen=True)
class Row:
    """One data row: the file's line, its fields by column, and what stands before the line."""

    line: int
    fields: dict[str, str]
    place: str = ":"


@dataclass(frozen=True)
class Rows:
    """Data rows under our names of columns, with a note of what was assumed to read them."""

    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()


def read_rows(
    name: str, text: str, columns: Columns, stated: Mapping[str, str] | None = None
) -> Rows:
    """Read a table of text, whatever separates its fields and however its columns are called.

    Parameters
    ----------
    name : str
        The source, for messages.
    stated : mapping of str to str, optional
        Name or number of the column of some quantities, as the user says.

    Raises
    ------
    InputError
        Where a column is missing or ambiguous, or a row has too few or too many fields.
    """
    return rows_of(parse_table(name, text, ",".join(columns.required)), columns, stated)


def rows_of(table: TextTable, columns: Columns, stated: Mapping[str, str] | None = None) -> Rows:
    """Bring a table under our names of columns, and its numbers to decimal points."""
    index = match_columns(table, columns, stated)
    numeric = tuple(i for quantity, i in index.items() if quantity not in TEXTS)
    table, commas = with_points(table, numeric)
    rows = (
        Row(row.line, {quantity: row.fields[i] for quantity, i in index.items()}, table.place)
        for row in table.rows
    )
    return Rows(tuple(rows), reading_note(table, index, decimal_commas=commas))


def number(name: str, row: Row, column: str) -> float:
    """Parse a field of a row, refusing what no such column can hold."""
    text = row.fields[column]
    where = f"{name}{row.place}{row.line}: {column}"
    try:
        value = float("not a number" if "_" in text else text)
    except ValueError:
        raise InputError(f"{where}: {quoted(text)} where a number should be; correct it") from None
    check_number(where, column, value)
    return value


def check_number(where: str, column: str, value: float) -> None:
    """Refuse what no such column can hold.

    Parameters
    ----------
    where : str
        Source, line and column, for the message.
    """
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
        raise InputError(f"{where}: is {value:g}; no pixel is that far out; correct it")
    if abs(value) >= LARGEST:
        raise InputError(f"{where}: is {value:g}, too large; use other units")
