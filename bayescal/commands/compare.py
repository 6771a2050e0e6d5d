"""``bayescal compare``: which polynomial order."""

from __future__ import annotations

import argparse

from bayescal.commands import options as shared
from bayescal.commands.output import add_output, check_output, deliver
from bayescal.errors import InputError

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
    shared.add_families(parser, several=True)
    parser.add_argument(
        "--radial-orders",
        type=shared.orders,
        default="0-3",
        metavar="K-L",
        help="numbers of radial coefficients of the pinhole (0-3)",
    )
    parser.add_argument(
        "--no-families",
        action="store_true",
        help="do not look whether another family or a free position is decisively better",
    )
    shared.add_points(parser)
    shared.add_model(parser)
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    if options.family is not None or options.position is not None:
        return _across_families(options)
    from bayescal.api.axes import compare
    from bayescal.report.terminal import comparison_view

    check_output(options)
    points = shared.points(options)
    models = len(shared.orders_of(options)) * shared.axes_of(options)
    with shared.Progress(options, models) as progress:
        result = compare(
            points,
            defend=options.defend,
            hint=not options.no_families,
            progress=progress,
            **shared.settings(options),
        )
    return deliver(options, result, comparison_view)


def _across_families(options: argparse.Namespace) -> int:
    """Compare families of models of r and c together."""
    from bayescal.api.families import compare_families
    from bayescal.commands.families import deliver_families
    from bayescal.report.families import families_view

    if options.axis in ("r", "c") or options.defend:
        option = "--defend" if options.defend else f"--axis {options.axis}"
        raise InputError(f"compare: families are models of r and c together; drop {option}")
    check_output(options)
    points = shared.points(options)
    given = {name: value for name, value in shared.settings(options).items() if name != "axis"}
    with shared.Progress(options, 2 * len(options.family or ["separable"])) as progress:
        result = compare_families(
            points,
            options.family or ["separable"],
            position=options.position,
            radial=options.radial,
            radial_orders=options.radial_orders,
            progress=progress,
            **given,
        )
    return deliver_families(options, result, families_view)
