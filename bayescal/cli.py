"""The command line: parse, call, print."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from bayescal import __version__
from bayescal.commands import compare, fit
from bayescal.commands.output import BAD_INPUT, DONE
from bayescal.errors import BayescalError

COMMANDS = {"compare": compare, "fit": fit}


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


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
        or disagree with the closed form.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = _parser().parse_args(given)
    options.command_line = shlex.join(["bayescal", *given])
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        run: Callable[[argparse.Namespace], int] = options.run
        code = run(options)
        sys.stdout.flush()
    except BayescalError as error:
        print(f"bayescal: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:  # the reader of a pipe has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except KeyboardInterrupt:
        print("bayescal: interrupted; nothing was written", file=sys.stderr)
        return 130
    return code


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bayescal",
        description="Bayesian uncertainty analysis for camera calibration: "
        "compares polynomial orders of the world-to-pixel map, so that the choice can be defended.",
        epilog="exit codes: 0 done; 2 bad usage or input, nothing written; 3 done, but the draws "
        "did not converge or disagree with the closed form",
    )
    parser.add_argument("--version", action="version", version=f"bayescal {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, module in COMMANDS.items():
        command = commands.add_parser(name, help=module.HELP, description=module.DESCRIPTION)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser
