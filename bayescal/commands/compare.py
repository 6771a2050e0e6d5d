"""``bayescal compare``: which polynomial order."""

from __future__ import annotations

import argparse

from bayescal.commands import options as shared
from bayescal.commands.output import add_output, check_output, deliver

HELP = "compare polynomial orders"
DESCRIPTION = "Compare polynomial orders of r(x/z) and c(y/z), each sampled with emcee."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_orders(parser)
    shared.add_axis(parser)
    parser.add_argument(
        "--defend",
        action="store_true",
        help="answer a referee too: leave-one-out, prior sensitivity, stability, orders beyond "
        "the range (some seconds more)",
    )
    shared.add_points(parser)
    shared.add_model(parser)
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    from bayescal.api import compare
    from bayescal.report.terminal import comparison_view

    check_output(options)
    points = shared.points(options)
    models = len(shared.orders_of(options)) * shared.axes_of(options)
    with shared.Progress(options, models) as progress:
        result = compare(
            points,
            defend=options.defend,
            progress=progress,
            **shared.settings(options),
        )
    return deliver(options, result, comparison_view)
