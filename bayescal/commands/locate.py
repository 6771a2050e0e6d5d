"""``bayescal locate``: pixels to the world, with their uncertainty."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING

from bayescal.commands.shared.camera import (
    add_camera,
    add_rows,
    camera_of,
    check_rows,
    publish_answers,
    publish_rows,
)
from bayescal.commands.shared.camera import read_rows as read_table
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.prediction.calibrated.camera import CalibratedCamera
    from bayescal.prediction.given import Surface

DESCRIPTION = (
    "Locate what measured pixels look at by a calibrated camera: directions, or points of the "
    "world at a known depth z or on a known plane, distances of pairs with their expanded "
    "uncertainty, or the pose of a known target. A lens without a pose has the camera's frame."
)
PAIR = ("r1", "c1", "r2", "c2")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    add_camera(parser)
    option(
        parser,
        "pixels PIXELS",
        "a table with columns r,c (px, as recorded); r1,c1,r2,c2 of --pairs; x,y,z,r,c of "
        "--target; - reads it",
    )
    where = parser.add_argument_group("where the points lie")
    option(where, "--depth Z", "at this z, world units", float)
    option(where, "--depth-sd S", "its standard deviation (0)", float)
    option(where, "--plane A B C D", "on the plane A x + B y + C z = D", float)
    option(where, "--pairs", "distances of pairs of pixels")
    target = parser.add_argument_group("a known target")
    option(
        target,
        "--target",
        "its pose from one new picture: x,y,z in its own frame, where each is seen",
    )
    option(target, "--sigma PX", "noise of these pixels", float)
    option(parser, "--seed N", "seed of the random numbers (0)", int, default=0)
    add_rows(parser)


def run(options: argparse.Namespace) -> int:
    """Read, locate, print and write; return the exit code."""
    surface = _surface(options)
    check_rows(options, options.pixels, options.camera)
    if options.seed < 0:
        raise InputError(f"seed must be 0 or more, not {options.seed}")
    camera = camera_of(options)
    if options.target:
        return _target(options, camera, surface)
    if options.sigma is not None:
        raise InputError("--sigma belongs to --target: other pixels have the calibration's noise")
    from bayescal.prediction import columns as named
    from bayescal.report.document import using
    from bayescal.report.views import location as shown

    if options.pairs:
        if surface is None:
            raise InputError("--pairs needs --depth or --plane: a pixel alone is a direction")
        table = read_table(options, options.pixels, PAIR)
        from bayescal.prediction.pairs import distances

        ends = table.columns("r1", "c1"), table.columns("r2", "c2")
        apart = distances(camera, *ends, surface, seed=options.seed)
        columns = using.asked_and_found(table, PAIR, named.pair_columns(apart))
        schema, probability = using.DISTANCES, apart.probability
        view = partial(shown.pair_view, camera, table, apart, surface)
    else:
        table = read_table(options, options.pixels, ("r", "c"))
        from bayescal.prediction.locate import locate

        found = locate(camera, table.columns("r", "c"), surface=surface, seed=options.seed)
        columns = using.asked_and_found(table, ("r", "c"), named.location_columns(found))
        schema, probability = using.LOCATION, found.probability
        view = partial(shown.location_view, camera, table, found)
    return publish_answers(options, schema, camera, columns, view, probability=probability)


def _target(options: argparse.Namespace, camera: CalibratedCamera, surface: Surface | None) -> int:
    """Find the pose of a target."""
    if surface is not None or options.pairs:
        raise InputError("--target says where the points lie: leave out --depth, --plane, --pairs")
    table = read_table(options, options.pixels, ("x", "y", "z", "r", "c"))
    from bayescal.prediction.columns import target_columns
    from bayescal.prediction.target import locate_target
    from bayescal.report.document.using import target_document
    from bayescal.report.views.target import target_view

    points, pixels = table.columns("x", "y", "z"), table.columns("r", "c")
    found = locate_target(camera, points, pixels, sigma=options.sigma, seed=options.seed)
    command = options.command_line
    publish_rows(
        options,
        target_columns(found),
        lambda: target_document(camera, found, command),
        lambda: target_view(camera, table, found),
    )
    return DONE


def _surface(options: argparse.Namespace) -> Surface | None:
    """Where the points lie, as the options say."""
    from bayescal.prediction.given import surface_of

    if options.depth is not None and options.plane is not None:
        raise InputError("--depth and --plane both say where the points lie: keep one")
    if options.depth is None and options.depth_sd is not None:
        raise InputError("--depth-sd belongs to --depth")
    return surface_of(options.depth, options.depth_sd or 0.0, options.plane)
