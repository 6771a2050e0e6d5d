"""What the reader of a format finds in a file."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.points.setup import Setup
from bayescal.points.tables.sniffing import TextTable


@dataclass(frozen=True, eq=False)
class Found:
    """A table, what the file says of the camera, and what a person should know of both."""

    table: TextTable
    setup: Setup | None = None
    notes: tuple[str, ...] = ()
