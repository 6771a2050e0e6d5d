"""``bayescal calibrate``: which lens model photographs of a target support."""

from __future__ import annotations

import argparse

from bayescal.commands import options as shared
from bayescal.commands.output import add_output, check_output, code_of, publish

HELP = "compare lens models over many views of a target"
DESCRIPTION = (
    "Compare lens models over many photographs of a target, by evidence with the poses "
    "integrated out. What makes the errors (neighbouring points that share them, points of the "
    "target that are off, a target that bows) is settled before a lens is judged."
)
STEPS = 17  # of a sweep, about


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    parser.add_argument(
        "views",
        nargs="?",
        metavar="VIEWS",
        help="table with columns view,x,y,z,r,c, or a file of another tool; - reads standard "
        "input; by default the bundled chessboard, 13 views",
    )
    given = parser.add_argument_group("views")
    given.add_argument("--board", metavar="9x6", help="points along x and y, for files of pixels")
    given.add_argument("--square", type=float, metavar="SIDE", help="distance of its points (1)")
    given.add_argument("--image-width", type=float, metavar="PX", help="image width, px")
    given.add_argument("--image-height", type=float, metavar="PX", help="image height, px")
    model = parser.add_argument_group("model")
    model.add_argument(
        "--lens",
        action="append",
        metavar="NAME",
        help="a lens to compare, such as 'radial 2', 'radial 2 + p', 'fisheye 3', opencv5, eucm; "
        "may be given again (found: plain first, while the evidence rises)",
    )
    model.add_argument(
        "--sigma",
        type=shared.sigma,
        metavar="LEVEL",
        help="noise level, px, or inferred (inferred)",
    )
    model.add_argument(
        "--independent",
        action="store_true",
        help="take noise as independent and the target as exact",
    )
    model.add_argument("--square-pixels", action="store_true", help="hold fx = fy")
    model.add_argument(
        "--centred", action="store_true", help="hold the principal point in the middle"
    )
    run = parser.add_argument_group("run")
    run.add_argument("--seed", type=int, default=0, metavar="N", help="of all randomness (0)")
    run.add_argument(
        "--ess", type=int, default=400, metavar="N", help="effective samples wanted (400)"
    )
    add_output(parser, None)


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    from bayescal.errors import InputError

    options.out = None
    if options.sigma in ("replicates", "scale"):
        raise InputError(f"calibrate: sigma {options.sigma} is of points; give px or inferred")
    check_output(options)
    from bayescal.api.calibrate import calibrate
    from bayescal.points.bundled import chessboard
    from bayescal.points.view_reader import load_views
    from bayescal.report.kinds.lenses import LENSES
    from bayescal.report.lenses import lenses_view

    if options.views is None:
        views = chessboard()
    else:
        views = load_views(
            options.views,
            board=options.board,
            square=options.square,
            width=options.image_width,
            height=options.image_height,
        )
    with shared.Progress(options, STEPS, "judging", "lens") as progress:
        result = calibrate(
            views,
            lenses=options.lens,
            sigma=None if options.sigma == "inferred" else options.sigma,
            independent=options.independent,
            square=options.square_pixels,
            centred=options.centred,
            seed=options.seed,
            ess=options.ess,
            progress=progress.named,
        )
    publish(options, result, lenses_view, LENSES)
    return code_of(sound=result.sound)
