"""``bayescal calibrate``: which lens model photographs of a target support."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import add_output, check_file, check_output, code_of, publish
from bayescal.commands.shared.resume import resumable
from bayescal.commands.shared.view_options import add_views, views
from bayescal.comparison.lenses.request import NOISES, checked_noise
from bayescal.errors import InputError

if TYPE_CHECKING:
    from bayescal.comparison.lenses.results import LensComparison

DESCRIPTION = (
    "Compare lens models over many photographs of a target, by evidence with the poses "
    "integrated out. What makes the errors (neighbouring points that share them, points of the "
    "target that are off, a target that bows) is settled before a lens is judged."
)
STEPS = 17  # of a sweep, about


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    add_views(parser)
    model = parser.add_argument_group("model")
    add_lenses(model)
    option(
        model,
        "--sigma LEVEL",
        "noise level: px, inferred, or per-view: each view its own (inferred)",
        shared.level_or("inferred", "replicates", "scale", "per-view"),
    )
    option(
        model,
        "--noise",
        "gaussian; or outlier-mixture: each point may also be bad, and anywhere in the image, for "
        "corners taken for others (gaussian)",
        _noise,
        choices=NOISES,
        default=NOISES[0],
    )
    run = parser.add_argument_group("run")
    option(run, "--seed N", "seed of the random numbers (0)", int, default=0)
    option(run, "--ess N", "effective samples wanted of each parameter (400)", int, default=400)
    add_output(parser, "write a run: result.json, views, draws (NetCDF), the camera")
    option(parser, "--report FILE.html", "write the page that report RUN writes")
    camera = parser.add_argument_group("camera")
    option(
        camera,
        "--camera FORMAT FILE",
        "write the most probable lens for another tool: opencv, ros, kalibr, mrcal or colmap; "
        "may be given again",
        action="append",
        default=[],
    )


def add_lenses(model: argparse._ArgumentGroup) -> None:
    """Add which lenses are compared, and under which errors."""
    option(
        model,
        "--lens NAME",
        "a lens to compare, such as 'radial 2', 'radial 2 + p', 'fisheye 3', opencv5, eucm; "
        "may be given again (found: plain first, while the evidence rises)",
        action="append",
    )
    option(model, "--independent", "take noise as independent and the target as exact")
    option(model, "--square-pixels", "hold fx = fy")
    option(model, "--centred", "hold the principal point in the middle")


def run(options: argparse.Namespace) -> int:
    """Compare, print and write; return the exit code."""
    check_output(options)
    if options.report is not None:
        check_file(options, Path(options.report))
    _check_cameras(options)
    from bayescal.api.calibrate import calibrate

    found = views(options)
    with resumable(options) as resume:
        with shared.Progress(options, STEPS, "judging") as progress:
            result = calibrate(
                found,
                lenses=options.lens,
                sigma=options.sigma,
                noise=options.noise,
                independent=options.independent,
                square=options.square_pixels,
                centred=options.centred,
                seed=options.seed,
                ess=options.ess,
                resume=resume,
                progress=progress.named,
            )
        publish(options, result)
    if options.report is not None:
        from bayescal.files import write_whole
        from bayescal.report.page.page import html, page_of

        made = html(page_of(result, options.command_line))
        write_whole(Path(options.report), made.encode(), force=options.force)
    _write_cameras(options, result)
    return code_of(sound=result.sound)


def _noise(text: str) -> str:
    """Parse a noise model, or say why views can't have it."""
    if text in NOISES:
        return text
    try:
        return checked_noise(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _check_cameras(options: argparse.Namespace) -> None:
    """Refuse cameras that can't be written before anything is computed."""
    if not options.camera:
        return
    from bayescal.report.cameras.write import BESIDE, FORMATS, check_format

    places = []
    for form, name in options.camera:
        check_format(form)
        beside = [] if FORMATS[form].COVARIANCE else [Path(f"{name}{BESIDE}")]
        places += [Path(name), *beside]
    if options.json not in (None, "-"):
        places.append(Path(options.json))
    for place in places:
        check_file(options, place)
    if len({place.resolve() for place in places}) < len(places):
        raise InputError("two outputs name the same file; name two")


def _write_cameras(options: argparse.Namespace, result: LensComparison) -> None:
    """Write the most probable lens for other tools."""
    if not options.camera:
        return
    from bayescal.report.cameras.fitted import fitted_camera
    from bayescal.report.cameras.write import check_format, save_camera

    camera = fitted_camera(result)
    for form, _ in options.camera:  # all or none
        check_format(form, camera.lens)
    for form, name in options.camera:
        save_camera(camera, name, form, force=options.force)
