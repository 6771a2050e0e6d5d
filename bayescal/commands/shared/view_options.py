"""Options of commands that take many views of a target."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from bayescal.commands.shared.option import option

if TYPE_CHECKING:
    from bayescal.points.views.views import Views


def add_views(parser: argparse.ArgumentParser) -> None:
    """Add the file of views and what is said of it."""
    option(
        parser,
        "views VIEWS",
        "table with columns view,x,y,z,r,c, or another tool's .npz, .mat, corners.vnl, "
        ".cameramodel or folder of .orpc; - reads standard input; by default the bundled "
        "chessboard, 13 views",
        nargs="?",
    )
    given = parser.add_argument_group("views")
    add_board(given)
    option(given, "--columns view=a,x=b,...", "the table's columns by name or number (from 1)")
    option(
        given,
        "--without VIEW[:POINT]",
        "leave out a view, or its point of that label or number: left05.jpg, left05.jpg:21; "
        "may be given again",
        action="append",
        default=[],
    )
    option(given, "--setup FILE.toml", "a setup that states the image size")
    option(given, "--image-width PX", "image width, px", float)
    option(given, "--image-height PX", "image height, px", float)


def add_board(given: argparse._ArgumentGroup) -> None:
    """Add the target of files that hold pixels alone, and which views are kept."""
    option(
        given,
        "--board 9x6",
        "points along x and y, for files of pixels alone; or the .dsc of .orpc files",
    )
    option(
        given,
        "--square SIDE",
        "distance between neighbouring points, in your unit of length (1)",
        float,
    )
    option(given, "--only PATTERN", "keep only the views whose names match, such as '*cam0*'")


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
            raise InputError(f"{option} says how a file of views is read; name the file")
