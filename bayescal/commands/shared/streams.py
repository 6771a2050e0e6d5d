"""Standard streams that are closed, full, narrow or gone never change what a command did."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO


class Deaf:
    """Standard error that carries on where nobody can hear: its disk is full, its reader gone."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write what can be written."""
        try:
            return self._stream.write(text)
        except OSError:
            self._give_up()
            return len(text)

    def flush(self) -> None:
        """Flush what can be flushed."""
        try:
            self._stream.flush()
        except OSError:
            self._give_up()

    def _give_up(self) -> None:
        """Send all that is still to come, and what is buffered, nowhere."""
        with contextlib.suppress(OSError, ValueError):
            discard(self._stream)
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def prepared() -> Iterator[None]:
    """Let the streams swallow what they can't hold while a command runs."""
    given = sys.stderr
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by the shell
            setattr(sys, name, io.StringIO())
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    deaf: Any = Deaf(sys.stderr)
    sys.stderr = deaf
    try:
        yield
    finally:
        sys.stderr.flush()
        sys.stderr = given


def print_utf8(text: str) -> None:
    """Print a text that says of itself that it is UTF-8, whatever the terminal takes."""
    raw: Any = getattr(sys.stdout, "buffer", None)
    if raw is None:
        sys.stdout.write(text)
        return
    sys.stdout.flush()
    raw.write(text.encode())


def discard(stream: TextIO) -> None:
    """Send what a stream is still to write nowhere, so that nothing fails again at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
