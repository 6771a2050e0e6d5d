"""Tables to be answered row by row: a bad row is named, and the others are still read."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.correspondences import one_line
from bayescal.points.tables.columns import Columns
from bayescal.points.tables.content import Content, read_content
from bayescal.points.tables.sniffing import TextTable, parse_table
from bayescal.points.tables.table import number, rows_of


@dataclass(frozen=True, eq=False)
class PartialTable:
    """The rows of a table that can be used.

    Attributes
    ----------
    name : str
        The source, for messages.
    values : dict of str to Array
        Numbers by column, ``(n,)``.
    labels : tuple of str
        "1", "2", ... of the file's rows where it has none.
    lines : tuple of int
        The file's line of each row.
    problems : tuple of str
        What is wrong with the rows left out, one line each.
    notes : tuple of str
        What was assumed to read it.
    """

    name: str
    values: dict[str, Array]
    labels: tuple[str, ...]
    lines: tuple[int, ...]
    problems: tuple[str, ...]
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.labels)

    def columns(self, *names: str) -> Array:
        """Give some columns beside each other, ``(n, n_names)``."""
        return np.column_stack([self.values[name] for name in names])


def read_partial(
    source: str | Path,
    required: tuple[str, ...],
    stated: Mapping[str, str] | None = None,
    stored: Callable[[Content], TextTable | None] = lambda _: None,
) -> PartialTable:
    """Read the rows of a table that are complete and finite.

    Parameters
    ----------
    source : str or Path
        A file, or ``"-"`` for standard input.
    required : tuple of str
        Columns of numbers.
    stated : mapping of str to str, optional
        Names or numbers of columns, as the user says.
    stored : callable, optional
        Gives the table of a file that is no text, None of one that is.

    Raises
    ------
    InputError
        Where there is no table, a column is missing, or no row is left.
    """
    content = read_content(source, f"a table with columns {','.join(required)}")
    known = Columns(required, (*required, "label"))
    problems: list[str] = []
    table = stored(content)
    if table is None:
        table = parse_table(content.name, content.text(), ",".join(required), problems)
    read = rows_of(table, known, stated)
    numbers: list[list[float]] = []
    labels, lines = [], []
    for i, row in enumerate(read.rows, 1):
        try:
            numbers.append([number(content.name, row, column) for column in required])
        except InputError as error:
            problems.append(str(error))
            continue
        labels.append(row.fields.get("label", "") or str(i))
        lines.append(row.line)
    if not numbers:
        reason = f"; the first: {problems[0]}" if problems else ""
        raise InputError(f"{content.name}: holds no row that can be used{reason}")
    array = np.array(numbers)
    return PartialTable(
        content.name,
        {column: array[:, j] for j, column in enumerate(required)},
        one_line(tuple(labels)),
        tuple(lines),
        tuple(sorted(problems, key=_line_of)),
        read.notes,
    )


def _line_of(problem: str) -> int:
    """Line that a complaint about a row names."""
    found = re.search(r"(?::|, row )(\d+):", problem)
    return int(found[1]) if found else 0
