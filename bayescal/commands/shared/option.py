"""One option of a command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable


def option(
    place: argparse._ActionsContainer,
    usage: str,
    says: str,
    read: Callable[[str], Any] | None = None,
    **more: Any,
) -> None:
    """Add an option, or an argument, as its help shows it: ``"--tau T"``, ``"--plane A B C D"``.

    An option without a value is a flag, unless `more` says otherwise.

    Parameters
    ----------
    place : parser or group
    says : str
        What it is, in brackets what holds where it is not given.
    read : callable, optional
        Makes the value of a text, which it is by default.
    """
    name, *values = usage.split()
    if len(values) > 1:
        more = {"nargs": len(values), "metavar": tuple(values), **more}
    elif values:
        more = {"metavar": values[0], **more}
    elif name.startswith("-") and not {"action", "choices"} & more.keys():
        more["action"] = "store_true"
    if read is not None:
        more["type"] = read
    place.add_argument(name, help=says, **more)
