"""What a source holds, read no further than a stated size."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from bayescal.errors import InputError
from bayescal.points.tables.text import decode, reason

# About a million points; and a setup says what it has to say in far less.
LARGEST_TABLE, LARGEST_SETUP = 64_000_000, 1_000_000


@dataclass(frozen=True)
class Content:
    """Bytes of a file or of standard input, with the name that messages give it."""

    name: str
    raw: bytes
    path: Path | None = None

    def text(self) -> str:
        """Decode the bytes; refuse what is no UTF-8 text."""
        return decode(self.name, self.raw)


def read_content(source: str | Path, what: str, limit: int = LARGEST_TABLE) -> Content:
    """Read a file, or standard input where the source is ``"-"``; see `read_file`."""
    if str(source) != "-":
        return read_file(source, what, limit)
    if sys.stdin is None:  # closed by the shell
        raise InputError(f"standard input: is closed; pipe {what} in or name a file")
    return _bounded("standard input", sys.stdin.buffer, what, limit)


def read_file(path: str | Path, what: str, limit: int = LARGEST_TABLE) -> Content:
    """Read a file whole, or refuse it as soon as it proves too large.

    A device, an endless pipe or a sparse file costs no more memory than `limit`.

    Parameters
    ----------
    what : str
        What should have been named, for messages.
    limit : int
        Bytes.

    Raises
    ------
    InputError
        Where it can't be read or holds more.
    """
    try:
        with Path(path).open("rb") as stream:
            return replace(_bounded(str(path), stream, what, limit), path=Path(path))
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {reason(error)}; give {what}") from None


def _bounded(name: str, stream: BinaryIO, what: str, limit: int) -> Content:
    raw = stream.read(limit + 1)
    if len(raw) > limit:
        raise InputError(
            f"{name}: holds more than {limit / 1e6:g} MB, the most that is read; give {what} of "
            "reasonable size"
        )
    return Content(name, raw)
