"""The man page and the completions of shells, made of the command's own parser."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import shtab
from argparse_manpage.manpage import Manpage

from bayescal.cli import make_parser

# Under the prefix of an installation.
PLACES = {
    "bayescal.1": "share/man/man1/bayescal.1",
    "bayescal.bash": "share/bash-completion/completions/bayescal",
    "_bayescal": "share/zsh/site-functions/_bayescal",
}


def made() -> dict[str, str]:
    """Text of each file by its name."""
    return {
        "bayescal.1": man_page(),
        "bayescal.bash": completion("bash"),
        "_bayescal": completion("zsh"),
    }


def completion(shell: str) -> str:
    """Give a shell's completion, of names of files where they are wanted."""
    parser = make_parser()
    for action in _actions(parser):
        names = action.metavar if isinstance(action.metavar, str) else ""
        if any(word in names for word in ("FILE", "POINTS", "VIEWS", "RUN", "IMAGE", "DIR")):
            action.complete = shtab.DIRECTORY if names == "DIR" else shtab.FILE  # type: ignore[attr-defined]
    return shtab.complete(parser, shell)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the options and arguments of every command."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        else:
            yield action


def man_page() -> str:
    """Write the manual in troff, without a date: the same source gives the same bytes."""
    parser = make_parser()
    parser.man_short_description = "Bayesian uncertainty analysis for camera calibration"
    page = Manpage(parser, format="single-commands-section")
    page.date = ""
    page.manual = "bayescal"
    return str(page)
