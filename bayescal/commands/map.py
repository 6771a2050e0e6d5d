"""``bayescal map``: where in the image a calibration can be believed."""

from __future__ import annotations

import argparse

from bayescal.commands.shared.camera import (
    add_camera,
    add_output,
    camera_of,
    check_rows,
    publish_answers,
)
from bayescal.commands.shared.option import option
from bayescal.errors import InputError

DESCRIPTION = (
    "Standard deviation of the mapping and of a new measurement over the image, and what each "
    "other plausible model would move, in pixels. Figures: bayescal plot sd-map RUN, "
    "difference-map."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    add_camera(parser)
    option(parser, "--grid COLUMNS ROWS", "places over the image (33 25)", int, default=(33, 25))
    add_output(parser)


def run(options: argparse.Namespace) -> int:
    """Map, print and write; return the exit code."""
    columns, rows = options.grid
    if not (2 <= columns <= 500 and 2 <= rows <= 500):
        raise InputError(f"--grid {columns} {rows}: use 2 to 500 of each")
    check_rows(options, options.camera)
    camera = camera_of(options)
    from bayescal.prediction.columns import map_columns
    from bayescal.prediction.maps import image_maps
    from bayescal.report.document import using
    from bayescal.report.views.maps import map_view

    found = image_maps(camera, columns=columns, rows=rows)
    return publish_answers(
        options,
        using.MAPS,
        camera,
        map_columns(found),
        lambda: map_view(camera, found),
        sentences=list(found.sentences),
    )
