"""The command line: parse, call, print."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from bayescal.commands import (
    calibrate,
    changed,
    compare,
    detect,
    fit,
    fleet,
    locate,
    map,
    outliers,
    plot,
    predict,
    report,
    reproduce,
    simulate,
    undistort,
)
from bayescal.commands.output import BAD_INPUT, DONE
from bayescal.commands.streams import discard, prepared
from bayescal.errors import BayescalError
from bayescal.version import __version__

COMMANDS = {
    "calibrate": calibrate,
    "changed": changed,
    "compare": compare,
    "detect": detect,
    "fit": fit,
    "fleet": fleet,
    "locate": locate,
    "map": map,
    "outliers": outliers,
    "plot": plot,
    "predict": predict,
    "report": report,
    "reproduce": reproduce,
    "simulate": simulate,
    "undistort": undistort,
}


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, and takes -1e3 for a number, not an option."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {_one_line(message)}; see {self.prog} --help\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the process.

    Returns
    -------
    int
        0 done; 2 bad usage or bad input; 3 done, but the draws did not converge
        or disagree with the closed form, or an evidence should not be trusted.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    with prepared():
        return _answered(given)


def _answered(given: list[str]) -> int:
    """Run, with one line of complaint for whatever goes wrong."""
    try:
        try:
            return _run(given)
        finally:
            sys.stdout.flush()
    except BayescalError as error:
        _say(str(error))
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has had enough
        discard(sys.stdout)
        return DONE
    except OSError as error:
        discard(sys.stdout)
        _say(f"the output can't be written: {str(error.strerror or error).lower()}")
        return BAD_INPUT
    except MemoryError:
        _say("there is not enough memory for this; give fewer points, orders or draws (--ess)")
        return BAD_INPUT
    except ImportError as error:
        _say(f"{error}: a library can't be loaded; free memory, or install bayescal anew")
        return BAD_INPUT
    except KeyboardInterrupt:
        _say("interrupted; nothing was written")
        return 130


def _run(given: list[str]) -> int:
    parser = make_parser()
    options, rest = parser.parse_known_args(given)
    # Before Python 3.13 an optional POINTS or VIEWS that stands behind options is left over.
    for name in ("points", "views"):
        if len(rest) == 1 and getattr(options, name, "") is None and not _option(rest[0]):
            setattr(options, name, rest.pop())
    if rest:
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    import logging  # not needed by --help

    # Figures are drawn into files; what the environment would show windows with is of no use.
    os.environ["MPLBACKEND"] = "agg"

    # Where matplotlib can't keep a cache it says so at length, which helps nobody here.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    options.command_line = shlex.join(["bayescal", *given])
    run: Callable[[argparse.Namespace], int] = options.run
    return run(options)


def _option(word: str) -> bool:
    return word.startswith("-") and word != "-"


def _say(message: str) -> None:
    """Complain on standard error."""
    print(f"bayescal: {_one_line(message)}", file=sys.stderr, flush=True)


def _one_line(message: str) -> str:
    """Fold white space, and drop what could command a terminal."""
    folded = " ".join(message.split())
    return "".join(c if c.isprintable() else "?" for c in folded)


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of every command, without anything heavy."""
    parser = _Parser(
        prog="bayescal",
        description="Bayesian uncertainty analysis for camera calibration: "
        "compares polynomial orders of the world-to-pixel map, so that the choice can be defended.",
        epilog="exit codes: 0 done; 2 bad usage or input, nothing written; 3 done, but the draws "
        "did not converge or disagree with the closed form, or an evidence should not be trusted",
    )
    parser.add_argument("--version", action="version", version=f"bayescal {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, module in COMMANDS.items():
        command = commands.add_parser(name, help=module.HELP, description=module.DESCRIPTION)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser
