"""An interrupted command goes on where it stopped."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from pathlib import Path

from bayescal.commands.shared.streams import say
from bayescal.errors import BayescalError


@contextlib.contextmanager
def resumable(options: argparse.Namespace) -> Iterator[Path | None]:
    """Give the folder beside --out that keeps what took long until all is written.

    Raises
    ------
    KeyboardInterrupt
        With what is said of an interruption, where models are kept.
    """
    if options.out is None:
        yield None
        return
    from bayescal.report.run.unfinished import clear, kept_in
    from bayescal.rounding import counted

    out = Path(options.out)
    folder = out.with_name(f"{out.name}.unfinished")
    if kept_in(folder):
        told = "holds models of an interrupted run: those of the same request are taken from it"
        say(f"{folder} {told}")
    try:
        yield folder
    except KeyboardInterrupt:
        count = kept_in(folder)
        if not count:
            clear(folder)
            raise
        raise KeyboardInterrupt(
            f"interrupted; {folder} keeps {counted(count, 'model')}: run the same command again to "
            "go on"
        ) from None
    except BayescalError:
        if not kept_in(folder):
            clear(folder)
        raise
    clear(folder)
