"""Output that commands share: tables, the result document, a run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bayescal.comparison.results import Comparison

DONE, BAD_INPUT, NOT_SOUND = 0, 2, 3


def add_output(parser: argparse.ArgumentParser) -> None:
    """Add where results go."""
    output = parser.add_argument_group("output")
    output.add_argument(
        "--json", metavar="FILE|-", help="write the result document; - prints it instead of tables"
    )
    output.add_argument(
        "--out", metavar="DIR", help="write a run: result.json, draws (NetCDF), corner plots"
    )
    output.add_argument("--force", action="store_true", help="replace existing output")
    output.add_argument("--quiet", action="store_true", help="print no tables")
    output.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="progress bar (on a terminal, after a second)",
    )


def check_output(options: argparse.Namespace) -> None:
    """Refuse output that can't be written before anything is computed."""
    if options.json not in (None, "-"):
        from bayescal.files import check_free

        check_free(Path(options.json), force=options.force)
    if options.out is not None:
        from bayescal.report.run import check_run

        check_run(Path(options.out), force=options.force)


def deliver(
    options: argparse.Namespace, result: Comparison, view: Callable[[Comparison], Any]
) -> int:
    """Write and print a comparison; return the exit code."""
    if options.json is not None or options.out is not None:
        from bayescal.report.document import document, dumps

        text = dumps(document(result, options.command_line))
        if options.out is not None:
            from bayescal.report.run import write_run

            write_run(Path(options.out), result, text, force=options.force)
        if options.json == "-":
            sys.stdout.write(text)
        elif options.json is not None:
            from bayescal.files import write_whole

            write_whole(Path(options.json), text.encode(), force=options.force)
    if not options.quiet and options.json != "-":
        from bayescal.report.terminal import render

        sys.stdout.write(render(view(result), terminal=sys.stdout.isatty()))
    if not result.sound:
        print(
            "bayescal: some draws did not converge or disagree with the closed form (exit code 3)",
            file=sys.stderr,
        )
        return NOT_SOUND
    return DONE
