"""``bayescal outliers``: which points are bad, and whether the order depends on them."""

from __future__ import annotations

import argparse

from bayescal.commands import options as shared
from bayescal.commands.output import add_output, check_json, code_of, publish

HELP = "find bad points, and whether the order depends on them"
DESCRIPTION = (
    "Measure every point on each axis (residual, leverage, Cook's distance, chi-squared rejection, "
    "posterior probability of being bad, influence on the order), explain the suspicious ones, and "
    "compare the orders before and after elimination and under each noise model."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    parser.add_argument(
        "--orders",
        type=shared.orders,
        default="1-5",
        metavar="K-L",
        help="such as 1-5 or 1,3,5 (1-5)",
    )
    parser.add_argument(
        "--axis", choices=("r", "c", "both"), default="both", help="which pixel axis (both)"
    )
    parser.add_argument("--all", action="store_true", help="show every point, not the worst alone")
    parser.add_argument(
        "--significance",
        type=float,
        default=0.05,
        metavar="P",
        help="of the chi-squared elimination, for all points together (0.05)",
    )
    shared.add_points(parser)
    shared.add_model(parser, one_noise=False)
    add_output(parser, None)


def run(options: argparse.Namespace) -> int:
    """Find, print and write; return the exit code."""
    check_json(options)
    from bayescal.outlier_analysis import outliers

    points = shared.points(options)
    models = 2 * (2 if options.axis == "both" else 1)
    with shared.Progress(options, models) as progress:
        study = outliers(
            points,
            options.orders,
            axis=options.axis,
            sigma=options.sigma,
            prior=options.prior,
            tau=options.tau,
            nu=options.nu,
            bad_offset=options.bad_offset,
            significance=options.significance,
            seed=options.seed,
            progress=progress.named,
        )
    from bayescal.report.facts import dumps
    from bayescal.report.outliers import outliers_document, outliers_view

    publish(
        options,
        lambda: dumps(outliers_document(study, options.command_line)),
        None,
        lambda: outliers_view(study, everything=options.all),
    )
    return code_of(sound=study.sound)
