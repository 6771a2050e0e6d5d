"""Takes a text apart into fields: separator, header and decimal mark are found from the text."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain

from bayescal.errors import InputError
from bayescal.points.tables.text import quoted
from bayescal.rounding import counted

# How a separator is called in a note; runs of blanks count as one.
SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks"}
_WITH_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?$")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}$")  # 1,500: a thousand and a half, or 1.5
_NO_TABLES = {"[": "JSON", "{": "JSON", "<": "HTML or XML"}  # by their first characters
_WITH_POINT = re.compile(r"[+-]?(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?$")
_WORD = re.compile(r'"((?:[^"]|"")*)"|(\S+)')


@dataclass(frozen=True)
class Line:
    """One row: the file's line (or the row's number) and its fields, stripped."""

    line: int
    fields: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TextTable:
    """Rows of text below a header.

    Attributes
    ----------
    name : str
        The source, for messages.
    header : tuple of str
        Names as they stand there; "1", "2", ... where no line names the columns.
    line : int
        Where the header stands.
    named : bool
        Whether a line names the columns.
    separator : str
        Of `SEPARATORS`.
    place : str
        What stands between a source's name and a line, in messages.
    """

    name: str
    header: tuple[str, ...]
    rows: tuple[Line, ...]
    line: int = 1
    named: bool = True
    separator: str = ","
    place: str = ":"

    def where(self, line: int) -> str:
        """Source and line, for a message."""
        return f"{self.name}{self.place}{line}"

    def column(self, index: int) -> list[str]:
        """Fields of one column."""
        return [row.fields[index] for row in self.rows]

    def kept(self, rows: Iterable[Line]) -> TextTable:
        """Give the same table with other rows."""
        return replace(self, rows=tuple(rows))


def parse_table(
    name: str, text: str, names: str = "x,y,z,r,c", ragged: list[str] | None = None
) -> TextTable:
    """Take a text apart: comments (#) and blank lines are left out.

    Parameters
    ----------
    name : str
        The source, for messages.
    names : str
        What the columns should be called, likewise.
    ragged : list of str, optional
        Takes the complaints about rows of another number of fields, which are then left out.

    Raises
    ------
    InputError
        Where it is empty, or a line's quotes or number of fields are wrong.
    """
    lines = io.StringIO(text, newline=None).read().split("\n")
    # Comments become blank lines, so that the reader's count stays the file's.
    kept = ["" if line.lstrip().startswith("#") else line for line in lines]
    start = next((i for i, line in enumerate(kept) if line.strip()), None)
    if start is None:
        raise InputError(f"{name}: is empty; the first line must name the columns {names}")
    other = _NO_TABLES.get(kept[start].lstrip()[0])
    if other is not None:
        raise InputError(
            f"{name}:{start + 1}: looks like {other}; give a table with columns {names}"
        )
    separator = _separator(kept[start])
    records = _records(name, kept, separator)
    line, first = next(records)
    named = not _is_data(first)
    if named:
        header = first
    else:
        records = chain([(line, first)], records)
        comment = next((i for i in reversed(range(start)) if lines[i].strip()), None)
        words = () if comment is None else _comment_header(lines[comment], separator)
        named = len(words) == len(first) and not _is_data(words)
        header = words if named else tuple(str(i + 1) for i in range(len(first)))
        line = line if comment is None or not named else comment + 1
    rows = [Line(number, fields) for number, fields in records]
    header, rows = _even(header, rows)
    whole = []
    for row in rows:
        if len(row.fields) == len(header):
            whole.append(row)
            continue
        complaint = (
            f"{name}:{row.line}: has {counted(len(row.fields), 'field')} where "
            f"{'the header' if named else 'the first line'} has {len(header)} "
            f"({quoted(','.join(header if named else first))}, line {line}); add or remove fields"
        )
        if ragged is None:
            raise InputError(complaint)
        ragged.append(complaint)
    return TextTable(name, header, tuple(whole), line, named, separator)


def _separator(line: str) -> str:
    """Say what separates the fields of the first line, outside of quotes."""
    bare = re.sub(r'"[^"]*"', "q", line)
    found = next((mark for mark in "\t;," if mark in bare), " ")
    words = bare.split()
    if found == "," and len(words) > 1 and all(_WITH_COMMA.match(word) for word in words):
        return " "  # numbers with decimal commas
    return found


def _records(name: str, lines: list[str], separator: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Yield (line, stripped fields) of every line that is not blank."""
    if separator == " ":
        for number, line in enumerate(lines, 1):
            words = _words(line)
            if words:
                yield number, words
        return
    reader = csv.reader((line + "\n" for line in lines), delimiter=separator, strict=True)
    start = 1  # of the record: a quoted field may go on over several lines
    try:
        for record in reader:
            fields = tuple(f.strip() for f in record)
            if any(fields):
                yield start, fields
            start = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{name}:{start}: {error}; correct the line's quotes") from None


def _words(line: str) -> tuple[str, ...]:
    found = _WORD.finditer(line)
    return tuple(m[2] if m[1] is None else m[1].replace('""', '"').strip() for m in found)


def _comment_header(line: str, separator: str) -> tuple[str, ...]:
    """Names in the comment above data that have no header, as numpy.savetxt writes them."""
    bare = line.lstrip().lstrip("#").strip()
    if separator == " ":
        return _words(bare)
    return tuple(field.strip().strip('"') for field in bare.split(separator))


def _is_data(fields: tuple[str, ...]) -> bool:
    """Whether a line holds numbers rather than names."""
    return 2 * sum(map(_is_number, fields)) >= len(fields)


def _is_number(text: str) -> bool:
    return bool(_WITH_COMMA.match(text)) or to_float(text) is not None


def _even(header: tuple[str, ...], rows: list[Line]) -> tuple[tuple[str, ...], list[Line]]:
    """Drop a last column without name or content; name the row names that R leaves unnamed."""
    n = len(header)
    if (
        n > 1
        and header[-1] == ""
        and not any(row.fields[n - 1 : n] not in ((), ("",)) for row in rows)
    ):
        header, n = header[:-1], n - 1
    if rows and all(len(row.fields) == n + 1 for row in rows):
        names = [row.fields[0] for row in rows]
        numbered = names == [str(i + 1) for i in range(len(rows))] and len(rows) > 1
        if all(row.fields[-1] == "" for row in rows):
            rows = [Line(row.line, row.fields[:-1]) for row in rows]
        elif numbered or not any(map(_is_number, names)):
            header = ("", *header)
    return header, rows


def to_float(text: str) -> float | None:
    """Read a number as Python does, without its digit groups; None where it is none."""
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def has_decimal_commas(table: TextTable, columns: Iterable[int]) -> bool:
    """Whether the numbers in some columns have decimal commas, and none a decimal point."""
    fields = [row.fields[i] for i in columns for row in table.rows]
    if not any(_WITH_COMMA.match(field) for field in fields):
        return False
    return not any(_WITH_POINT.match(field) for field in fields)


def _refuse_thousands(table: TextTable, columns: Iterable[int]) -> None:
    """Refuse quoted numbers between commas whose own commas may all be of thousands."""
    found = [
        (row, row.fields[i])
        for row in table.rows
        for i in columns
        if _WITH_COMMA.match(row.fields[i])
    ]
    if table.separator == "," and all(_GROUPED.match(text) for _, text in found):
        row, text = found[0]
        raise InputError(
            f"{table.where(row.line)}: {quoted(text)} may be {text.replace(',', '.')} or "
            f"{text.replace(',', '')}; write it without a comma"
        )


def with_points(table: TextTable, columns: tuple[int, ...]) -> tuple[TextTable, bool]:
    """Turn decimal commas in some columns into points; say whether there were any.

    Raises
    ------
    InputError
        Where they may be the commas of thousands.
    """
    commas = has_decimal_commas(table, columns)
    if not commas:
        return table, False
    _refuse_thousands(table, columns)
    lines = []
    for row in table.rows:
        fields = list(row.fields)
        for i in columns:
            if _WITH_COMMA.match(fields[i]):
                fields[i] = fields[i].replace(",", ".")
        lines.append(Line(row.line, tuple(fields)))
    return table.kept(lines), True
