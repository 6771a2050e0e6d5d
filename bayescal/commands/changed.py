"""``bayescal changed``: whether two calibrations are of the same camera still."""

from __future__ import annotations

import argparse
from pathlib import Path

from bayescal.commands.shared.camera import add_average, add_output, check_rows, publish_rows
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE
from bayescal.errors import InputError

DESCRIPTION = (
    "Compare two calibrations of one camera, such as before and after a knock: how far their "
    "predictions lie apart over the image, and whether by more than noise allows. "
    "Lenses of many views are compared after the turn of one frame to the other, cameras with a "
    "place in the world with their place."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    for name in ("first", "second"):
        option(parser, f"{name} RUN", f"the {name} run, or camera file")
    add_average(parser)
    option(parser, "--seed N", "seed of the random numbers (0)", int, default=0)
    output = add_output(parser)
    option(output, "--figure FILE", "draw the map: .png, .svg or .pdf")


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    check_rows(options, options.first, options.second)
    if Path(options.first).resolve() == Path(options.second).resolve():
        raise InputError(f"{options.first}: is given twice; name two calibrations")
    if options.seed < 0:
        raise InputError(f"seed must be 0 or more, not {options.seed}")
    picture = None if options.figure is None else _picture(options)
    from bayescal.api.camera import camera
    from bayescal.prediction.changed import changed
    from bayescal.prediction.columns import change_columns
    from bayescal.report.document.using import change_document
    from bayescal.report.views.changed import changed_view

    first, second = (
        camera(given, average=options.average) for given in (options.first, options.second)
    )
    names = options.first, options.second
    found = changed(first, second, seed=options.seed)
    publish_rows(
        options,
        change_columns(found),
        lambda: change_document(first, second, found, names, options.command_line),
        lambda: changed_view(first, second, found, names),
    )
    if picture is not None:
        from bayescal.files import write_whole
        from bayescal.report.figures.registry import CHANGE_MAP
        from bayescal.report.figures.style import figure_bytes

        raw = figure_bytes(CHANGE_MAP.draw(found), picture.suffix[1:].lower())
        write_whole(picture, raw, force=options.force)
    return DONE


def _picture(options: argparse.Namespace) -> Path:
    """Where the figure goes, a place that is free."""
    from bayescal.files import check_free
    from bayescal.report.figures.style import FORMATS

    path = Path(options.figure)
    if path.suffix[1:].lower() not in FORMATS:
        raise InputError(f"{path}: a figure is written as .{', .'.join(FORMATS)}; name it so")
    check_free(path, force=options.force)
    return path
