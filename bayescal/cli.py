"""The command line: parse, call, print."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any, NoReturn

from bayescal.commands.shared.output import BAD_INPUT, DONE
from bayescal.commands.shared.streams import discard, prepared, say
from bayescal.errors import BayescalError
from bayescal.version import __version__

# A command is a module in commands/ of its name, imported where it is asked for.
COMMANDS = {
    "calibrate": "compare lens models over many views of a target",
    "changed": "compare two calibrations: is it still the same camera?",
    "compare": "compare polynomial orders, or families of camera models",
    "detect": "find a target's points in photographs (needs OpenCV)",
    "fit": "fit one model and print it in full",
    "fleet": "judge many cameras, and say which are odd (needs Dask)",
    "locate": "find what pixels look at: directions, points, distances, a target's pose",
    "map": "map the uncertainty over the image",
    "outliers": "find bad points, and whether the order depends on them",
    "plot": "draw one figure",
    "predict": "predict where points appear in the image",
    "report": "write one page to attach to a calibration (HTML, PDF)",
    "reproduce": "run the thesis's own procedure, as written and as coded",
    "simulate": "make points from a known truth",
    "undistort": "take the distortion out of photographs, or of pixels",
}


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, and takes -1e3 for a number, not an option."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        say(f"{message}; see {self.prog} --help", self.prog)
        self.exit(BAD_INPUT)


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
        say(str(error))
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has had enough
        discard(sys.stdout)
        return DONE
    except OSError as error:
        discard(sys.stdout)
        say(f"the output can't be written: {str(error.strerror or error).lower()}")
        return BAD_INPUT
    except MemoryError:
        say("there is not enough memory for this; give fewer points, orders or draws (--ess)")
        return BAD_INPUT
    except ImportError as error:
        say(f"{error}: a library can't be loaded; free memory, or install bayescal anew")
        return BAD_INPUT
    except KeyboardInterrupt as stop:
        say(str(stop) or "interrupted; nothing was written")
        return 130


def _run(given: list[str]) -> int:
    # Nothing but options of the parser's own stands before a command.
    parser = make_parser(word for word in given if word in COMMANDS)
    options, rest = parser.parse_known_args(given)
    # Before Python 3.13 an optional POINTS or VIEWS that stands behind options is left over.
    for name in ("points", "views"):
        if len(rest) == 1 and getattr(options, name, "") is None and not _option(rest[0]):
            setattr(options, name, rest.pop())
    if rest:
        options.refuse(f"unrecognized arguments: {' '.join(rest)}")
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


def make_parser(names: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """Make the parser, with the arguments of some commands, by default of all."""
    parser = _Parser(
        prog="bayescal",
        description="Bayesian uncertainty analysis for camera calibration: which polynomial order "
        "or lens model your points support, how strongly, and where in the image the calibrated "
        "camera can be believed.",
        epilog="COMMAND --help shows its options, with defaults in parentheses. Exit codes: 0 "
        "done; 2 bad usage or input, nothing written; 3 done, but the draws did not converge or "
        "disagree with the closed form, or an evidence should not be trusted; 130 interrupted.",
    )
    parser.add_argument("--version", action="version", version=f"bayescal {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    wanted = set(names)
    for name, told in COMMANDS.items():
        if name not in wanted:
            commands.add_parser(name, help=told)
            continue
        module = import_module(f"bayescal.commands.{name}")
        command = commands.add_parser(name, help=told, description=module.DESCRIPTION)
        module.add_arguments(command)
        command.set_defaults(run=module.run, refuse=command.error)
    return parser
