"""``bayescal fit``: one model in full."""

from __future__ import annotations

import argparse

from bayescal.commands import options as shared
from bayescal.commands.output import add_output, check_output, deliver
from bayescal.errors import InputError

HELP = "fit one model and print it in full"
DESCRIPTION = "Fit one order per axis, sampled with emcee, and print the model in full."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    parser.add_argument("--order-r", type=int, metavar="K", help="order of r(x/z)")
    parser.add_argument("--order-c", type=int, metavar="K", help="order of c(y/z)")
    shared.add_points(parser)
    shared.add_model(parser)
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Fit, print and write; return the exit code."""
    if options.order_r is None and options.order_c is None:
        raise InputError("fit: give --order-r, --order-c or both")
    from bayescal.api import fit
    from bayescal.report.terminal import fit_view

    check_output(options)
    points = shared.points(options)
    with shared.Progress(options, 2) as progress:
        result = fit(
            points,
            options.order_r,
            options.order_c,
            progress=progress,
            **shared.settings(options),
        )
    return deliver(options, result, fit_view)
