"""``bayescal reproduce``: the thesis's own procedure, as written and as coded."""

from __future__ import annotations

import argparse

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, add_output, check_output, publish

DESCRIPTION = (
    "Least squares of orders 1-5 of r and c as the thesis writes them (eq. 33-53) and as its "
    "listing codes them (Appendix B: r's third and higher powers from y/z), and the elimination "
    "of bad points by a chi-squared test, before and after beside each other."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_points(parser)
    elimination = parser.add_argument_group("elimination")
    option(
        elimination,
        "--significance P",
        "level: the chance that any point is removed where none is bad (0.05)",
        float,
        default=0.05,
    )
    option(elimination, "--per-point", "take that for the chance of calling any one good point bad")
    option(elimination, "--common", "compare all orders on the points that every order keeps")
    option(
        elimination,
        "--sigma inferred|PX",
        "noise level: inferred from the residuals, or known, px (inferred)",
        shared.level_or("inferred"),
        default="inferred",
    )
    add_output(
        parser, "write figures 6-10 (PNG, SVG) and all numbers, reproduction.json", progress=False
    )


def run(options: argparse.Namespace) -> int:
    """Reproduce, print and write; return the exit code."""
    from bayescal.reproduction.kind import FOLDER, REPRODUCTION
    from bayescal.reproduction.procedure import reproduce

    check_output(options, FOLDER)
    result = reproduce(
        shared.points(options),
        significance=options.significance,
        per_point=options.per_point,
        sigma=options.sigma,
        common=options.common,
    )
    publish(options, result, kind=REPRODUCTION)
    return DONE
