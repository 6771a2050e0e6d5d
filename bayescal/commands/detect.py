"""``bayescal detect``: views of a target from photographs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, add_manner
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.detection.detect import Detection
    from bayescal.detection.pattern import Pattern

DESCRIPTION = (
    "Find the points of a chessboard, a ChArUco board or a grid of circles in photographs, by "
    "OpenCV, and write them as a table of views for bayescal calibrate: view,x,y,z,r,c. Pixel "
    "centres are at integers, r from the left, c from the top. Needs OpenCV: "
    "pip install 'bayescal[images]'."
)
PATTERNS = ("chessboard", "charuco", "circles", "asymmetric-circles")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    option(
        parser,
        "images IMAGES",
        "photographs of one camera, or a pattern of their names such as 'images/*.jpg'",
        nargs="+",
    )
    target = parser.add_argument_group("target")
    option(
        target,
        "--board COLUMNSxROWS",
        "its points along x and y, such as 9x6: inner corners of a chessboard, circles, or "
        "the squares of a ChArUco board",
        required=True,
    )
    option(
        target,
        "--square SIDE",
        "side of a square, or distance of circles (asymmetric: of neighbouring rows), in any "
        "unit; what is found of the target has it",
        float,
        required=True,
    )
    option(
        target, "--pattern", "kind of target (chessboard)", choices=PATTERNS, default="chessboard"
    )
    charuco = parser.add_argument_group("ChArUco")
    option(charuco, "--marker SIDE", "side of a marker, in the square's unit", float)
    option(charuco, "--dictionary NAME", "OpenCV's name of the markers, such as 4x4_50")
    option(charuco, "--legacy", "the board was printed from OpenCV before 4.6")
    output = parser.add_argument_group("output")
    option(output, "--out FILE.csv", "write the views there (printed)")
    option(
        output,
        "--contact-sheet FILE.png",
        "draw small pictures of all photographs with what was found",
    )
    add_manner(output, "say nothing of what was found")


def run(options: argparse.Namespace) -> int:
    """Detect, say what was found, and write it; return the exit code."""
    from bayescal.detection.detect import detect, image_paths
    from bayescal.files import check_free, write_whole
    from bayescal.points.views.writer import views_to_csv

    pattern = _pattern(options)
    paths = image_paths(options.images)
    for name in (options.out, options.contact_sheet):
        if name is not None:
            check_free(Path(name), force=options.force)
            if Path(name).resolve() in {path.resolve() for path in paths}:
                raise InputError(f"{name}: would replace a photograph; choose another name")
    places = [Path(name).resolve() for name in (options.out, options.contact_sheet) if name]
    if len(set(places)) < len(places):
        raise InputError("--out and --contact-sheet name the same file; name two")
    with shared.Progress(options, len(paths), "looking at") as progress:
        found = detect(paths, pattern, progress.named)
    text = views_to_csv(found.views, [f"{pattern.name}, by {found.detector}"])
    if options.contact_sheet is not None:
        from bayescal.detection.contact_sheet import contact_sheet

        sheet = contact_sheet(found.photographs)
        write_whole(Path(options.contact_sheet), sheet, force=options.force)
    if options.out is not None:
        write_whole(Path(options.out), text.encode(), force=options.force)
        stream = sys.stdout
    else:
        sys.stdout.write(text)
        stream = sys.stderr
    if not options.quiet:
        print("\n".join(_told(found, options)), file=stream)
    return DONE


def _pattern(options: argparse.Namespace) -> Pattern:
    """Make the target that the options describe."""
    from bayescal.detection.charuco import Charuco
    from bayescal.detection.chessboard import Chessboard
    from bayescal.detection.circles import Circles
    from bayescal.points.views.board import Board, board_named

    board = board_named(options.board, options.square)
    if options.pattern != "charuco":
        for name in ("marker", "dictionary", "legacy"):
            if getattr(options, name):
                raise InputError(f"--{name} belongs to --pattern charuco")
        if options.pattern == "chessboard":
            return Chessboard(board)
        return Circles(board, asymmetric=options.pattern == "asymmetric-circles")
    if options.marker is None or options.dictionary is None:
        raise InputError("a ChArUco board needs --marker SIDE and --dictionary NAME")
    corners = Board(board.columns - 1, board.rows - 1, board.square)
    return Charuco(corners, options.marker, options.dictionary, legacy=options.legacy)


def _told(found: Detection, options: argparse.Namespace) -> list[str]:
    """Say what was found, and name the photographs that make no view."""
    from bayescal.points.views.notes import view_notes
    from bayescal.rounding import counted

    views, count = found.views, len(found.photographs)
    lines = [
        f"{found.pattern.name} found in {len(views)} of {counted(count, 'photograph')}, "
        f"{counted(views.n_points, 'point')}, image {views.width} by {views.height} px",
        f"by {found.detector}",
    ]
    lines += [f"not used: {one.name}: {one.why}" for one in found.failed]
    lines += [f"note: {note}" for note in view_notes(views)]
    lines += [f"written: {name}" for name in (options.out, options.contact_sheet) if name]
    if options.out is not None:
        lines += ["", f"bayescal calibrate {options.out}"]
    return ["".join(c if c.isprintable() else "?" for c in line) for line in lines]
