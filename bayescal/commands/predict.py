"""``bayescal predict``: world points to pixels, with their uncertainty."""

from __future__ import annotations

import argparse

from bayescal.commands.shared.camera import (
    add_camera,
    add_rows,
    camera_of,
    check_rows,
    publish_answers,
)
from bayescal.commands.shared.camera import read_rows as read_table
from bayescal.commands.shared.option import option

DESCRIPTION = (
    "Predict pixels of world points by a calibrated camera: mean and sd of the mapping, sd of a "
    "new measurement and its 95% interval, from one model or averaged over all plausible ones. "
    "Pixels are counted as in the points file of the calibration."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    add_camera(parser)
    option(parser, "points POINTS", "a table with columns x,y,z (world units); - reads it")
    add_rows(parser)


def run(options: argparse.Namespace) -> int:
    """Read, predict, print and write; return the exit code."""
    check_rows(options, options.points, options.camera)
    camera = camera_of(options)
    table = read_table(options, options.points, ("x", "y", "z"))
    from bayescal.prediction.predict import predict

    found = predict(camera, table.columns("x", "y", "z"))
    from bayescal.prediction.columns import prediction_columns
    from bayescal.report.document import using
    from bayescal.report.views.prediction import prediction_view

    columns = using.asked_and_found(table, ("x", "y", "z"), prediction_columns(found))
    return publish_answers(
        options,
        using.PREDICTION,
        camera,
        columns,
        lambda: prediction_view(camera, table, found),
        method=found.method,
        probability=found.probability,
        notes=list(found.notes),
    )
