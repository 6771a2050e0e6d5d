"""``bayescal undistort``: photographs as a camera without distortion would have taken them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from bayescal.commands.shared import options as shared
from bayescal.commands.shared.option import option
from bayescal.commands.shared.output import DONE, add_manner
from bayescal.errors import InputError, OutputError

if TYPE_CHECKING:
    from bayescal.cameras.undistortion import Field, IdealCamera, Seeing, Table

DESCRIPTION = (
    "Make photographs as a camera without distortion would have taken them, from a run, a camera "
    "file, or what bayescal calibrate --camera opencv FILE.yml, OpenCV or ROS wrote. The folder "
    "gets the photographs under their own names and camera.yml, the camera that they now come "
    "from; this needs OpenCV: pip install 'bayescal[images]'. --pixels takes measured pixels "
    "instead."
)
FIELDS: tuple[Literal["same", "inside", "full"], ...] = ("same", "inside", "full")
CAMERA = "camera.yml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's options."""
    option(
        parser,
        "camera CAMERA",
        "a run, a camera file (camera.npz), or YAML of OpenCV or ROS's camera_info",
    )
    option(
        parser,
        "images IMAGES",
        "photographs by that camera, or a pattern of their names such as 'images/*.jpg'",
        nargs="*",
    )
    option(
        parser,
        "--field FIELD",
        "what the result sees: the same focal length and principal point (same); as much as "
        "leaves no black pixel (inside); as much as loses no pixel (full); or so many degrees "
        "from left to right, such as 90",
        default="same",
    )
    rows = parser.add_argument_group("pixels")
    option(rows, "--pixels TABLE", "a table with columns r,c; - reads it")
    option(rows, "--columns r=u,c=v", "the table's columns by name or number (from 1)")
    option(rows, "--strict", "refuse a table with a bad row")
    output = parser.add_argument_group("output")
    option(output, "--out PLACE", "folder; of pixels a CSV file, - prints it", required=True)
    add_manner(output, "say nothing of what was done")


def run(options: argparse.Namespace) -> int:
    """Undistort all photographs, say so, and name those that are none; return the exit code."""
    from bayescal.cameras.undistortion import ideal_camera, table

    field, folder = _field(options.field), Path(options.out)
    if (options.pixels is None) == (not options.images):
        raise InputError("name photographs, or --pixels TABLE: one of the two")
    real = _camera(options.camera)
    if options.pixels is not None:
        return _pixels(options, real, field)
    from bayescal.detection.detect import image_paths

    places = _places(image_paths(options.images), folder, force=options.force)
    ideal = ideal_camera(real, field)
    where, failed = table(real, ideal), []
    with shared.Progress(options, len(places), "undistorting") as progress:
        for path, place in places.items():
            progress.named(path.name)
            why = _undistort(path, place, where, real, force=options.force)
            if why:
                failed.append(f"{path}: {why}")
    if len(failed) == len(places):
        raise InputError(f"{failed[0]}; nothing was undistorted")
    _write_camera(ideal, folder, force=options.force)
    if not options.quiet:
        print("\n".join(_told(ideal, where, places, failed, folder)))
    return DONE


def _camera(given: str) -> Seeing:
    """Take the camera of a run, of a camera file, or of another tool's file."""
    path = Path(given)
    if path.is_dir() or path.suffix == ".npz":
        from bayescal.prediction.undistorting import ChosenCamera
        from bayescal.report.camera import camera_at

        return ChosenCamera(camera_at(path))
    from bayescal.cameras.camera import Camera
    from bayescal.cameras.undistortion import RealCamera
    from bayescal.report.cameras.read import load_camera

    fitted = load_camera(given)
    return RealCamera(Camera(fitted.lens), fitted.intrinsics, fitted.coefficients, *fitted.size)


def _pixels(options: argparse.Namespace, real: Seeing, field: Field) -> int:
    """Undistort the pixels of a table."""
    import sys

    from bayescal.cameras.undistortion import ideal_camera
    from bayescal.commands.shared.camera import read_rows
    from bayescal.files import check_free, write_whole
    from bayescal.prediction.columns import undistorted_columns
    from bayescal.prediction.undistorting import Undistortion
    from bayescal.report.document.using import asked_and_found, rows_text

    if options.out != "-":
        check_free(Path(options.out), force=options.force)
    table = read_rows(options, options.pixels, ("r", "c"))
    undistortion, pixels = Undistortion(real, ideal_camera(real, field)), table.columns("r", "c")
    columns = undistorted_columns(undistortion.pixels(pixels), undistortion.outside(pixels))
    text = rows_text(asked_and_found(table, ("r", "c"), columns))
    if options.out == "-":
        sys.stdout.write(text)
    else:
        write_whole(Path(options.out), text.encode(), force=options.force)
    return DONE


def _field(text: str) -> Field:
    """Read the field of view: a word, or degrees."""
    for field in FIELDS:
        if text == field:
            return field
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--field {text}: use {', '.join(FIELDS)} or degrees") from None


def _places(paths: list[Path], folder: Path, *, force: bool) -> dict[Path, Path]:
    """Where each photograph goes, every place free."""
    from bayescal.files import check_free

    places: dict[Path, Path] = {}
    for path in paths:
        place = folder / path.name
        if place in places.values():
            raise InputError(f"two photographs are called {path.name}; undistort them apart")
        if place.resolve() in {one.resolve() for one in paths} or path.name == CAMERA:
            raise InputError(f"{place}: would replace a photograph; choose another --out")
        places[path] = place
    for place in (*places.values(), folder / CAMERA) if folder.is_dir() else (folder,):
        check_free(place, force=force)
    return places


def _undistort(path: Path, place: Path, where: Table, real: Seeing, *, force: bool) -> str:
    """Undistort one photograph; say why where it can't be."""
    from bayescal.detection.images import encoded, read_image, remapped
    from bayescal.files import write_whole

    image, why = read_image(path)
    if image is None:
        return why
    height, width = image.shape[:2]
    if (width, height) != (real.width, real.height):
        return f"is of {width} by {height} px, the camera of {real.width} by {real.height}"
    raw = encoded(remapped(image, where.r, where.c), path.suffix)
    if raw is None:
        return f"OpenCV writes no {path.suffix or 'file without a suffix'}"
    _make(place.parent)
    write_whole(place, raw, force=force)
    return ""


def _make(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: {error.strerror}") from None


def _write_camera(ideal: IdealCamera, folder: Path, *, force: bool) -> None:
    """Write the camera without distortion beside the photographs."""
    from bayescal.cameras.lenses import lens_named
    from bayescal.report.cameras.camera import FittedCamera
    from bayescal.report.cameras.write import save_camera

    lens = lens_named("radial", order=0, tangential=False)
    size = (ideal.width, ideal.height)
    camera = FittedCamera.from_arrays(lens, ideal.intrinsics, [], size, model="undistorted")
    save_camera(camera, folder / CAMERA, "opencv", force=force)


def _told(
    ideal: IdealCamera, where: Table, places: dict[Path, Path], failed: list[str], folder: Path
) -> Iterator[str]:
    """Say what was done."""
    from bayescal.rounding import counted

    fx, fy, cx, cy = ideal.intrinsics.tolist()
    across, down = (
        math.degrees(math.atan(low / f) + math.atan((side - 1 - low) / f))
        for low, side, f in ((cx, ideal.width, fx), (cy, ideal.height, fy))
    )
    done = len(places) - len(failed)
    yield f"{done} of {counted(len(places), 'photograph')} undistorted in {folder}"
    yield (
        f"they see {across:.1f} by {down:.1f} degrees: fx {fx:.2f}, fy {fy:.2f}, cx {cx:.2f}, "
        f"cy {cy:.2f} px ({folder / CAMERA})"
    )
    inside = (where.r > -0.5) & (where.r < ideal.width - 0.5)
    inside &= (where.c > -0.5) & (where.c < ideal.height - 0.5)
    if not inside.all():
        yield f"black: {100 * (1 - inside.mean()):.1f}% of their pixels, which no photograph shows"
    yield from (f"not used: {line}" for line in failed)
