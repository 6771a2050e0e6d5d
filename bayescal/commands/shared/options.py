"""Options that commands share, and what is made of them."""

from __future__ import annotations

import argparse
import dataclasses
from typing import TYPE_CHECKING, Any, TypeVar

from bayescal.commands.shared.option import option
from bayescal.commands.shared.progress import Progress as Progress
from bayescal.errors import InputError
from bayescal.noise import NAMES

if TYPE_CHECKING:
    from collections.abc import Callable

    from bayescal.points.chunks.many import ManyPoints
    from bayescal.points.correspondences import Correspondences

    Points = TypeVar("Points", Correspondences, ManyPoints)

CAMERA = (
    "columns",
    "view",
    "setup",
    "camera_position",
    "image_width",
    "image_height",
    "c_from_bottom",
)
COMPARED = ("orders", "axis")
MODEL = ("sigma", "prior", "tau", "noise", "nu", "bad_offset", "tolerance", "seed", "ess")


def add_points(parser: argparse.ArgumentParser, *, or_run: bool = False) -> None:
    """Add the points file, or the run that may stand in its place, and the camera's setup."""
    option(
        parser,
        "points POINTS",
        "a table with columns x,y,z,r,c (or E,N,h,col,row and the like) and optionally label, "
        "group, sigma_r, sigma_c; - reads standard input; by default the bundled thesis data"
        + ("; or a RUN, the folder that --out wrote" if or_run else ""),
        nargs="?",
    )
    option(
        parser,
        "--columns x=E,y=N,...",
        "the table's columns by name or number (from 1), where their names can't be guessed",
    )
    option(parser, "--view NAME", "the photograph to take, where the file holds several")
    for name, what in (("world", "x, y, z"), ("pixels", "r, c")):
        option(
            parser,
            f"--{name} FILE",
            f"table of {what}, where world and pixels are in two files (no POINTS)",
        )
    add_setup(parser)


def add_setup(parser: argparse.ArgumentParser) -> None:
    """Add what is known of the camera."""
    camera = parser.add_argument_group("camera")
    option(camera, "--setup FILE.toml", "camera position, image size, priors")
    option(camera, "--camera-position X Y Z", "x, y, z of the camera, world units (0 0 0)", float)
    option(camera, "--image-width PX", "image width, px", float)
    option(camera, "--image-height PX", "image height, px", float)
    option(
        camera,
        "--c-from-bottom",
        "count c from the bottom: c = height - row",
        action=argparse.BooleanOptionalAction,
    )


def add_orders(parser: argparse.ArgumentParser) -> None:
    """Add the orders to compare."""
    option(parser, "--orders K-L", "orders to compare, such as 1-5 or 1,3,5 (1-5)", orders)


def add_axis(parser: argparse.ArgumentParser) -> None:
    """Add the axis to compare, or both."""
    option(parser, "--axis", "which pixel axis (both)", choices=("r", "c", "both"))


def add_model(parser: argparse.ArgumentParser, *, one_noise: bool = True) -> None:
    """Add noise, prior, seed and sampling effort.

    None of them has a default here: what is not given is left to the public functions, and
    what is given can be told apart.
    """
    model = parser.add_argument_group("model")
    option(
        model,
        "--sigma LEVEL",
        "noise level: a known number of px; inferred; replicates, from repeated points; or scale, "
        "a factor on the file's sigma_r, sigma_c (these as they stand where the file has them, "
        "else inferred)",
        level_or("inferred", "replicates", "scale"),
    )
    option(
        model,
        "--prior",
        "prior of the coefficients (the setup's where it states one, else field)",
        choices=("field", "flat", "stated"),
    )
    option(
        model,
        "--tau T",
        "fix the strength of the non-linearity, a fraction of the image (inferred)",
        float,
    )
    option(
        model,
        "--tolerance PX",
        "difference of predictions that does not matter to you: an order suffices where the others "
        "that can't be excluded differ by less (a quarter of the noise)",
        float,
    )
    _add_noise(parser, choose=one_noise)
    run = parser.add_argument_group("run")
    option(run, "--seed N", "seed of the random numbers (0)", int)
    option(run, "--ess N", "effective samples wanted of each parameter (4000)", int)


def _add_noise(parser: argparse.ArgumentParser, *, choose: bool) -> None:
    """Add the noise model (where one is chosen) and the options of each."""
    noise = parser.add_argument_group("noise")
    if choose:
        option(
            noise,
            "--noise",
            "shape of the noise: gaussian; student-t has heavy tails; outlier-mixture has "
            "good and bad points (gaussian; the others take longer)",
            choices=NAMES,
        )
    option(noise, "--nu N", "fix the degrees of freedom of student-t (inferred)", float)
    option(
        noise,
        "--bad-offset",
        "let the bad points of outlier-mixture be off to one side (off to all sides alike)",
        default=None,
    )


def orders(text: str) -> list[int]:
    """Parse orders such as 1-5 or 1,3,5."""
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        ends = [first, last] if dash else [first]
        if not all(end.isascii() and end.isdigit() and len(end) < 10 for end in ends):
            raise argparse.ArgumentTypeError(
                f"{text[:40]!r} is not a list of orders such as 1-5 or 1,3,5"
            )
        low, high = int(ends[0]), int(ends[-1])
        if high < low:
            raise argparse.ArgumentTypeError(f"{part.strip()!r} runs backwards; write {high}-{low}")
        found.update(range(low, min(high, low + 1000) + 1))
    return sorted(found)


def level_or(*words: str) -> Callable[[str], float | str]:
    """Make a parser of noise levels: a number of px or a word."""

    def parse(text: str) -> float | str:
        if text in words:
            return text
        try:
            return float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(
                f"{text!r} is neither {', '.join(words)} nor a number of px"
            ) from None

    return parse


def points(options: argparse.Namespace) -> Correspondences:
    """Read the points that the options name, with the camera they state."""
    from bayescal.points.bundled import thesis
    from bayescal.points.reader import load

    source, second = files(options)
    how = {"columns": options.columns, "view": options.view, "pixels": second}
    return with_camera(thesis() if source is None else load(source, **how), options)


def with_camera(found: Points, options: argparse.Namespace) -> Points:
    """Give points the camera that the options state."""
    from bayescal.points.setup_file import load_setup

    base = load_setup(options.setup) if options.setup is not None else found.setup
    flags: dict[str, Any] = {
        "position": tuple(options.camera_position) if options.camera_position else None,
        "width": options.image_width,
        "height": options.image_height,
        "c_from_bottom": options.c_from_bottom,
    }
    changes = {name: value for name, value in flags.items() if value is not None}
    if changes:
        assumed = tuple(name for name in base.assumed if name not in changes)
        base = dataclasses.replace(base, **changes, assumed=assumed)
    return dataclasses.replace(found, setup=base)


def files(options: argparse.Namespace) -> tuple[str | None, str | None]:
    """Name the file of the points, or those of their world coordinates and of their pixels."""
    pair = (options.world, options.pixels)
    if pair == (None, None):
        if options.points is None and (options.columns or options.view):
            raise InputError("--columns and --view say how a file is read; name the file")
        return options.points, None
    if None in pair or options.points is not None:
        raise InputError("give --world and --pixels together, and no other file of points")
    return pair


def is_run(options: argparse.Namespace, settled: tuple[str, ...]) -> bool:
    """Whether POINTS names a run (a folder with a result document) rather than points.

    Parameters
    ----------
    settled : tuple of str
        Options that belong to points, and that a run has settled.

    Raises
    ------
    InputError
        Where it is a folder, but no run, or an option is given that a run has settled.
    """
    if options.points in (None, "-"):
        return False
    from pathlib import Path

    from bayescal.files import RESULT

    folder = Path(options.points)
    try:
        if not folder.is_dir():
            return False  # reading the points says what is wrong with them
        found = (folder / RESULT).is_file()
    except OSError:
        return False
    if not found:
        raise InputError(
            f"{folder}: is a folder, but not a run: it holds no {RESULT}; name a points file or a "
            "folder that compare --out wrote"
        )
    for name in settled:
        given = getattr(options, name)
        if given is not None:
            option = f"--{'no-' if given is False else ''}{name.replace('_', '-')}"
            raise InputError(
                f"{folder}: is a run, which has its own {option}; leave the "
                "option out, or name points in place of the run"
            )
    return True


def settings(options: argparse.Namespace) -> dict[str, Any]:
    """Collect the keyword arguments of an analysis that are given."""
    found = {name: getattr(options, name, None) for name in (*COMPARED, *MODEL)}
    return {name: value for name, value in found.items() if value is not None}


def orders_of(options: argparse.Namespace) -> list[int]:
    """Orders to compare, given or not."""
    from bayescal.comparison.settings import DEFAULT_ORDERS

    return list(DEFAULT_ORDERS) if options.orders is None else options.orders


def axes_of(options: argparse.Namespace) -> int:
    """How many axes are compared."""
    return 1 if options.axis in ("r", "c") else 2
