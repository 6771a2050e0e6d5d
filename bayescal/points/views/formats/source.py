"""A file to be read, as every format is given it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.tables.content import Content
from bayescal.points.views.board import Board


@dataclass(frozen=True)
class Source(Content):
    """A file's bytes, and what the user says of it.

    Attributes
    ----------
    board : Board or None
        The target's points, where the file holds only pixels.
    target : Path or None
        A file that describes the target.
    columns : mapping of str to str or None
        What the user says of a table's columns.
    """

    board: Board | None = None
    target: Path | None = None
    columns: Mapping[str, str] | None = None

    @property
    def sha256(self) -> str:
        """Hash of the bytes."""
        return hashlib.sha256(self.raw).hexdigest()

    @property
    def suffix(self) -> str:
        """Extension, lower case, with its dot."""
        return self.path.suffix.lower() if self.path is not None else ""

    @property
    def is_folder(self) -> bool:
        """Whether it is a folder of files."""
        return self.path is not None and self.path.is_dir()

    def refuse_board(self) -> None:
        """Refuse a board where the file has the target's points itself.

        Raises
        ------
        InputError
        """
        if self.board is not None or self.target is not None:
            raise InputError(f"{self.name}: states the target's points itself; leave --board out")
