"""``bayescal fleet``: many cameras, and which of them are odd."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bayescal.commands.calibrate import add_lenses
from bayescal.commands.shared import options as shared
from bayescal.commands.shared import view_options
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, NOT_SOUND, add_progress
from bayescal.commands.shared.streams import say
from bayescal.comparison.lenses.request import checked_noise
from bayescal.errors import InputError
from bayescal.rounding import counted

if TYPE_CHECKING:
    from bayescal.fleets.fleet import Fleet
    from bayescal.fleets.listed import Listed

DESCRIPTION = (
    "Judge many cameras as bayescal compare does (with --calibrate as bayescal calibrate), on many "
    "processes or on a Dask cluster, and say which of them are not like the others. The folder "
    "gets a table (Parquet, a row per camera), an overview page and the result document, and "
    "keeps what is done: the same command again does only what is missing. "
    "Needs Dask: pip install 'bayescal[fleet]'."
)
# What is of points and what is of views; the rest is of both.
OF_POINTS = (
    *("orders", "axis", "no_families", "view", "camera_position", "c_from_bottom"),
    *("prior", "tau", "tolerance", "nu", "bad_offset"),
)
OF_VIEWS = ("lens", "independent", "square_pixels", "centred", "board", "square", "only")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    option(
        parser,
        "cameras CAMERAS",
        "a file of points for each camera, patterns of their names such as 'cameras/*.csv', "
        "or a manifest: a CSV file with the column file and optionally camera (its name), setup",
        nargs="+",
    )
    run = parser.add_argument_group("processes")
    option(run, "--workers N", "processes on this machine (one for each core)", int)
    option(run, "--scheduler ADDRESS", "of a Dask cluster, such as tcp://host:8786")
    output = parser.add_argument_group("output")
    option(output, "--out DIR", "folder to keep all in", required=True)
    option(output, "--json -", "print the result document", choices=("-",))
    option(output, "--quiet", "print no tables")
    add_progress(output)
    shared.add_orders(parser)
    shared.add_axis(parser)
    option(
        parser,
        "--no-families",
        "do not look whether another family or a free position is decisively better",
    )
    option(
        parser,
        "--columns x=E,y=N,...",
        "the tables' columns by name or number (from 1), where their names can't be guessed",
    )
    option(parser, "--view NAME", "the photograph to take, where files hold several")
    shared.add_setup(parser)
    shared.add_model(parser)
    views = parser.add_argument_group("views of a target")
    option(
        views,
        "--calibrate",
        "each camera's file holds views of a target, whose lenses are compared",
    )
    add_lenses(views)
    view_options.add_board(views)


def run(options: argparse.Namespace) -> int:
    """Judge all cameras, say what was found, and name those that failed; return the exit code."""
    _check(options)
    from bayescal.api.fleet import fleet
    from bayescal.fleets.listed import listed

    cameras = {camera.name: camera for camera in listed(options.cameras)}
    try:
        with shared.Progress(options, len(cameras), "judging") as progress:
            found = fleet(
                cameras,
                views=options.calibrate,
                folder=options.out,
                scheduler=options.scheduler,
                workers=options.workers,
                seed=options.seed or 0,
                setup=options.setup,
                read=lambda camera: _read(options, camera),
                progress=progress.named,
                command=options.command_line,
                **(_lens_settings(options) if options.calibrate else _settings(options)),
            )
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; what is done is kept in {options.out}; the same command goes on"
        ) from None
    _publish(options, found)
    return _code(found)


def _check(options: argparse.Namespace) -> None:
    """Refuse options of the other kind of camera.

    Raises
    ------
    InputError
    """
    foreign, of = (OF_POINTS, "points") if options.calibrate else (OF_VIEWS, "views")
    for name in foreign:
        if getattr(options, name) not in (None, False):
            hint = "drop it, or --calibrate" if options.calibrate else "add --calibrate"
            raise InputError(f"fleet: --{name.replace('_', '-')} is of {of}; {hint}")
    if options.calibrate and options.noise is not None:
        checked_noise(options.noise)
    if options.calibrate and options.sigma in ("replicates", "scale"):
        raise InputError(f"fleet: sigma {options.sigma} is of points; give px or inferred")


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    """Options of `compare`."""
    given = {name: v for name, v in shared.settings(options).items() if name != "seed"}
    return {**given, "hint": not options.no_families}


def _lens_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Options of `calibrate`."""
    given = {
        "lenses": options.lens,
        "sigma": None if options.sigma == "inferred" else options.sigma,
        "noise": options.noise,
        "independent": options.independent,
        "square": options.square_pixels,
        "centred": options.centred,
        "ess": options.ess,
    }
    return {name: value for name, value in given.items() if value is not None}


def _read(options: argparse.Namespace, camera: Listed) -> Any:
    """Read a camera's file as the options say; its own setup goes before theirs."""
    own = {"points": camera.file, "views": camera.file, "world": None, "pixels": None}
    setup = options.setup if camera.setup is None else camera.setup
    given = argparse.Namespace(**{**vars(options), **own, "setup": setup})
    return view_options.read(given) if options.calibrate else shared.points(given)


def _publish(options: argparse.Namespace, found: Fleet) -> None:
    """Print what was found, and where it is kept."""
    from bayescal.report.page.fleet import DOCUMENT, PAGE, TABLE
    from bayescal.report.terminal import render
    from bayescal.report.views.fleet import brief

    folder = Path(options.out)
    if options.json == "-":
        sys.stdout.write((folder / DOCUMENT).read_text(encoding="utf-8"))
    elif not options.quiet:
        sys.stdout.write(render(brief(found), terminal=sys.stdout.isatty()))
        print(f"\nwritten: {folder / PAGE}, {folder / TABLE}")


def _code(found: Fleet) -> int:
    """Give the exit code: 3 where cameras failed or are not sound, which is said."""
    if found.sound:
        return DONE
    if not found.records:
        first = found.failed[0]
        raise InputError(f"{first.error}; no camera could be judged")
    wrong = [f"{counted(len(found.failed), 'camera')} failed"] if found.failed else []
    wrong += [f"{counted(len(found.unsound), 'camera')} not sound"] if found.unsound else []
    say(f"{', '.join(wrong)} (exit code 3)")
    return NOT_SOUND
