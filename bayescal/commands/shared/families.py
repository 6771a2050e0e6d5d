"""What the commands that work on joint models of r and c share: options."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.errors import InputError


def add_families(parser: argparse.ArgumentParser, *, several: bool) -> None:
    """Add which families, and what is known of the camera position."""
    group = parser.add_argument_group("families")
    names = "separable, bivariate, pinhole"
    group.add_argument(
        "--family",
        type=words(("separable", "bivariate", "pinhole")) if several else str,
        metavar="F,G" if several else "F",
        help=f"r and c jointly, one table over families: {names}"
        if several
        else f"family to fit: {names}",
    )
    group.add_argument(
        "--position",
        type=words(("stated", "free")),
        metavar="stated,free" if several else "stated|free",
        help="camera position exact as stated, or inferred about it (stated; a pinhole's free)",
    )
    option(
        group,
        "--radial",
        "powers of the radius in the pinhole's distortion (even)",
        choices=("even", "all"),
    )
    if several:
        option(
            group,
            "--radial-orders K-L",
            "numbers of radial coefficients of the pinhole to compare (0-3)",
            shared.orders,
        )


def families_of(options: argparse.Namespace, command: str) -> dict[str, Any] | None:
    """Collect which families are asked for; None where none is.

    Raises
    ------
    InputError
        Where an option of the pinhole is given, but no pinhole is compared; or one axis alone.
    """
    names = ("radial", "radial_orders")
    given = {name: v for name in names if (v := getattr(options, name, None)) is not None}
    families = list(options.family or ["separable"])
    if given and "pinhole" not in families:
        option = "--" + next(iter(given)).replace("_", "-")
        raise InputError(f"{option} belongs to a pinhole: add --family pinhole, or leave it out")
    if options.family is None and options.position is None:
        return None
    if options.axis not in (None, "both"):
        drop = f"drop --axis {options.axis}"
        raise InputError(f"{command}: families are joint models of r and c; {drop}")
    return {"families": families, "position": options.position, **given}


def words(known: tuple[str, ...]) -> Callable[[str], list[str]]:
    """Make a parser of known words separated by commas."""

    def parse(text: str) -> list[str]:
        found = [part.strip() for part in text.split(",")]
        for part in found:
            if part not in known:
                raise argparse.ArgumentTypeError(f"{part[:40]!r} is none of {', '.join(known)}")
        return list(dict.fromkeys(found))

    return parse
