"""``bayescal outliers``: which points are bad, and whether the order depends on them."""

from __future__ import annotations

import argparse

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import add_output, check_output, deliver
from bayescal.commands.shared.resume import resumable

DESCRIPTION = (
    "Measure every point on each axis (residual, leverage, Cook's distance, chi-squared rejection, "
    "posterior probability of being bad, influence on the order), explain the suspicious ones, and "
    "compare the orders before and after elimination and under each noise model."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    shared.add_orders(parser)
    shared.add_axis(parser)
    option(parser, "--all", "show every point, not only the worst")
    option(
        parser,
        "--significance P",
        "level of the chi-squared elimination, for all points together (0.05)",
        float,
        default=0.05,
    )
    shared.add_points(parser)
    shared.add_model(parser, one_noise=False)
    add_output(parser, "write a run: result.json, draws (NetCDF)")


def run(options: argparse.Namespace) -> int:
    """Find, print and write; return the exit code."""
    check_output(options)
    from bayescal.api.outliers import outliers

    points = shared.points(options)
    models = 2 * shared.axes_of(options)
    with resumable(options) as resume:
        with shared.Progress(options, models) as progress:
            study = outliers(
                points,
                significance=options.significance,
                resume=resume,
                progress=progress.named,
                **shared.settings(options),
            )
        return deliver(options, study, full=options.all)
