"""Tables of text in chunks: NumPy reads the numbers, and the patient reader what it can't."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bayescal.arrays import Array
from bayescal.points.chunks.chunk import HELD, Found, Lazily, chunk_of, numbered
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import COLUMNS, points_of
from bayescal.points.setup import Setup
from bayescal.points.tables.columns import TEXTS, match_columns, reading_note
from bayescal.points.tables.sniffing import parse_table, with_points
from bayescal.points.tables.table import read_rows
from bayescal.points.tables.text import decode

# Bytes of a chunk; and of the beginning, from which header and separator are found.
BYTES, HEAD = 4_000_000, 250_000


@dataclass(frozen=True)
class Layout:
    """How the lines of a table are laid out.

    Attributes
    ----------
    name : str
        The source, for messages.
    above : str
        The lines above the first point.
    index : dict of str to int
        Column of each quantity.
    stated : mapping of str to str or None
        What the user says of columns.
    marks : int
        Separators of every line.
    numbers_only : bool
        Whether there is no column but those of numbers.
    """

    name: str
    above: str
    index: dict[str, int]
    stated: Mapping[str, str] | None
    separator: str
    decimal_commas: bool
    marks: int
    numbers_only: bool

    @property
    def first(self) -> int:
        """Line of the first point."""
        return self.above.count("\n") + 1


def of_text(path: Path, stated: Mapping[str, str] | None) -> Found | None:
    """Read a table of text chunk by chunk; None where its points are few."""
    with path.open("rb") as stream:
        head = stream.read(HEAD)
        lines = new = head.count(b"\n")
        while new and lines <= 2 * HELD:  # no line ends in so much: not a table
            lines += (new := stream.read(HEAD).count(b"\n"))
        size = stream.seek(0, 2)
    if b"\n" not in head or lines <= HELD:
        return None
    head = head[: head.rindex(b"\n") + 1]
    text = _newlines(decode(str(path), head))
    table = parse_table(str(path), text)
    if not table.rows:
        return None
    index = match_columns(table, COLUMNS, stated)
    numeric = tuple(i for quantity, i in index.items() if quantity not in TEXTS)
    commas = with_points(table, numeric)[1]
    rows = text.split("\n")
    line = table.rows[0].line
    layout = Layout(
        str(path),
        "".join(f"{row}\n" for row in rows[: line - 1]),
        index,
        stated,
        table.separator,
        commas,
        rows[line - 1].count(table.separator),
        sorted(numeric) == list(range(rows[line - 1].count(table.separator) + 1)),
    )
    if lines < layout.first + HELD:
        return None
    notes = reading_note(table, index, decimal_commas=commas)
    about = int(size / len(head) * len(table.rows))

    def read(setup: Setup) -> Iterator[Correspondences]:
        return _chunks(path, layout, setup)

    return Found(about, frozenset(index), read, notes)


def _newlines(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _chunks(path: Path, layout: Layout, setup: Setup) -> Iterator[Correspondences]:
    """Read block by block, each cut at the end of a line."""
    start, line = 0, layout.first
    with path.open("rb") as stream:
        for _ in range(layout.first - 1):
            stream.readline()
        while raw := stream.read(BYTES):
            if not raw.endswith(b"\n"):
                raw += stream.readline(HEAD)
            lines = _newlines(_decoded(layout.name, raw, line)).removesuffix("\n").split("\n")
            made = _quickly(layout, lines, start, line, setup)
            if made is None:
                made = _patiently(layout, lines, start, line, setup)
            if made is not None:
                yield made
                start += len(made)
            line += len(lines)


def _decoded(name: str, raw: bytes, line: int) -> str:
    """Decode a block; a complaint names the line of the file."""
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return decode(name, b"\n" * (line - 1) + raw)


def _quickly(
    layout: Layout, lines: Sequence[str], start: int, line: int, setup: Setup
) -> Correspondences | None:
    """Let NumPy read a block; None where a line is not like the others."""
    separator = layout.separator
    kept = [line.replace(",", ".") for line in lines] if layout.decimal_commas else lines
    if not layout.numbers_only and any(row.count(separator) != layout.marks for row in lines):
        return None
    wanted = {q: i for q, i in layout.index.items() if q not in TEXTS}
    try:
        table = np.loadtxt(
            kept,
            delimiter=None if separator == " " else separator,
            usecols=None if layout.numbers_only else list(wanted.values()),
            comments=None,
            ndmin=2,
        )
    except ValueError:
        return None
    if len(table) != len(lines):  # blank lines
        return None
    places = wanted if layout.numbers_only else dict(zip(wanted, range(len(wanted)), strict=True))
    columns: dict[str, Array] = {quantity: table[:, i] for quantity, i in places.items()}
    texts = {
        quantity: _fields(lines, separator, i)
        for quantity, i in layout.index.items()
        if quantity in TEXTS
    }
    numbers = range(line, line + len(lines))
    return chunk_of(layout.name, start, columns, setup, texts=texts, lines=numbers)


def _fields(lines: Sequence[str], separator: str, index: int) -> Sequence[str]:
    """One column of text, each field cut out where it is asked for."""
    return Lazily(len(lines), lambda i: lines[i].split(separator)[index].strip().strip('"'))


def _patiently(
    layout: Layout, lines: Sequence[str], start: int, line: int, setup: Setup
) -> Correspondences | None:
    """Read a block as a small file is read, which says what is wrong and where."""
    blanks = "\n" * (line - layout.first)
    rows = read_rows(layout.name, layout.above + blanks + "\n".join(lines), COLUMNS, layout.stated)
    if not rows.rows:
        return None
    made = points_of(layout.name, rows, setup, None)
    if "label" in layout.index:
        return made
    return replace(made, labels=numbered(start, len(made)))
