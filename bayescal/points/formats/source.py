"""A file to be read, as every format is given it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.board import Board


@dataclass(frozen=True)
class Source:
    """A file's bytes, and what the user says of it.

    Attributes
    ----------
    name : str
        For messages.
    raw : bytes
    path : Path or None
        None for standard input.
    board : Board or None
        The target's points, where the file holds only pixels.
    """

    name: str
    raw: bytes
    path: Path | None = None
    board: Board | None = None

    @property
    def suffix(self) -> str:
        """Extension, lower case, with its dot."""
        return self.path.suffix.lower() if self.path is not None else ""

    def refuse_board(self) -> None:
        """Refuse a board where the file has the target's points itself.

        Raises
        ------
        InputError
        """
        if self.board is not None:
            raise InputError(f"{self.name}: states the target's points itself; leave --board out")
