"""Standard streams that are closed, full, narrow or gone never change what a command did."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sys
import textwrap
from collections.abc import Iterator
from typing import Any, TextIO

NARROW = 20  # columns below which nothing is folded any more


def say(message: str, who: str = "bayescal") -> None:
    """Say something on standard error: a line, between words folded where a terminal is narrow."""
    folded = " ".join(f"{who}: {message}".split())
    line = "".join(c if c.isprintable() else "?" for c in folded)  # nothing commands a terminal
    if sys.stderr.isatty():
        width = max(shutil.get_terminal_size().columns, NARROW)
        line = textwrap.fill(line, width - 1, break_long_words=False, break_on_hyphens=False)
    print(line, file=sys.stderr, flush=True)


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
