"""Tables in files that are no text: workbooks and Parquet."""

from __future__ import annotations

from bayescal.points.exports import parquet, spreadsheet
from bayescal.points.exports.found import Found
from bayescal.points.tables.content import Content
from bayescal.points.tables.sniffing import TextTable


def stored_table(content: Content) -> TextTable | None:
    """Give the table of a workbook or a Parquet file; None where it is neither.

    Raises
    ------
    InputError
        Where a package is missing, or the file is damaged.
    """
    for program in (spreadsheet, parquet):
        if program.recognises(content):
            found: Found = program.read(content, None)
            return found.table
    return None
