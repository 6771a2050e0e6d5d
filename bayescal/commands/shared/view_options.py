"""Options of commands that take many views of a target."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bayescal.points.views.views import Views


def add_views(parser: argparse.ArgumentParser) -> None:
    """Add the file of views and what is said of it."""
    parser.add_argument(
        "views",
        nargs="?",
        metavar="VIEWS",
        help="table with columns view,x,y,z,r,c, or another tool's .npz, .mat, corners.vnl, "
        ".cameramodel or folder of .orpc; - reads standard input; by default the bundled "
        "chessboard, 13 views",
    )
    given = parser.add_argument_group("views")
    add_board(given)
    given.add_argument(
        "--columns", metavar="view=a,x=b,...", help="names or numbers of a table's columns"
    )
    given.add_argument(
        "--without",
        action="append",
        default=[],
        metavar="VIEW[:POINT]",
        help="leave out a view, or its point of that label or number: left05.jpg, left05.jpg:21; "
        "may be given again",
    )
    given.add_argument("--setup", metavar="FILE.toml", help="a setup that states the image size")
    given.add_argument("--image-width", type=float, metavar="PX", help="image width, px")
    given.add_argument("--image-height", type=float, metavar="PX", help="image height, px")


def add_board(given: argparse._ArgumentGroup) -> None:
    """Add the target of files that hold pixels alone, and which views are kept."""
    given.add_argument(
        "--board",
        metavar="9x6",
        help="points along x and y, for files of pixels alone; or the .dsc of .orpc files",
    )
    given.add_argument("--square", type=float, metavar="SIDE", help="distance of its points (1)")
    given.add_argument("--only", metavar="PATTERN", help="keep the views so called: '*cam0*'")


def views(options: argparse.Namespace) -> Views:
    """Read the views that the options name, without those that are left out."""
    return read(options).without(*options.without)


def read(options: argparse.Namespace) -> Views:
    """Read all views that the options name."""
    from bayescal.points.bundled import chessboard
    from bayescal.points.views.reader import load_views

    if options.views is None:
        refuse_said(options)
        return chessboard()
    return load_views(
        options.views,
        board=options.board,
        square=options.square,
        columns=options.columns,
        only=options.only,
        setup=options.setup,
        width=options.image_width,
        height=options.image_height,
    )


def refuse_said(options: argparse.Namespace) -> None:
    """Refuse what is said of a file where none is named.

    Raises
    ------
    InputError
    """
    from bayescal.errors import InputError

    for name in ("board", "square", "columns", "only", "setup", "image_width", "image_height"):
        if getattr(options, name) is not None:
            option = f"--{name.replace('_', '-')}"
            raise InputError(f"{option} is of a file of views, and none is named; name it")
