"""Writes fitted cameras for other tools; a new format is one module and one line here."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from types import ModuleType

from bayescal.cameras.lenses import Lens
from bayescal.errors import InputError
from bayescal.files import check_free, write_whole
from bayescal.report.cameras import colmap, kalibr, mrcal, opencv, ros
from bayescal.report.cameras.camera import FittedCamera

FORMATS: dict[str, ModuleType] = {
    "opencv": opencv,
    "ros": ros,
    "kalibr": kalibr,
    "mrcal": mrcal,
    "colmap": colmap,
}
BESIDE = ".covariance.csv"


def check_format(name: str, lens: Lens | None = None) -> None:
    """Refuse a format that is none, or that has no such lens.

    Raises
    ------
    InputError
    """
    if name not in FORMATS:
        raise InputError(f"no format is called {name[:40]!r}; there are {', '.join(FORMATS)}")
    if lens is None or FORMATS[name].holds(lens):
        return
    having = [other for other, module in FORMATS.items() if module.holds(lens)]
    where = f"write it for {', '.join(having)}" if having else "no format here has it"
    raise InputError(
        f"{FORMATS[name].NAME} has no {lens.name} lens with {', '.join(lens.names)}; {where}"
    )


def camera_text(camera: FittedCamera, form: str) -> str:
    """Format a camera for another tool.

    Parameters
    ----------
    form : str
        ``"opencv"``, ``"ros"``, ``"kalibr"``, ``"mrcal"`` or ``"colmap"``.

    Raises
    ------
    InputError
        Where there is no such format, or it has no such lens.
    """
    check_format(form, camera.lens)
    made: str = FORMATS[form].text(camera)
    return made


def camera_files(camera: FittedCamera, path: str | Path, form: str) -> dict[Path, str]:
    """Contents of the files that `save_camera` writes, by their places."""
    files = {Path(path): camera_text(camera, form)}
    if camera.covariance is not None and not FORMATS[form].COVARIANCE:
        files[Path(f"{path}{BESIDE}")] = _covariance(camera)
    return files


def save_camera(
    camera: FittedCamera, path: str | Path, form: str = "opencv", *, force: bool = False
) -> None:
    """Write a camera for another tool; its covariance within, or beside as ``PATH.covariance.csv``.

    Parameters
    ----------
    camera : FittedCamera
    path : str or Path
    form : str, optional
        ``"opencv"``, ``"ros"``, ``"kalibr"``, ``"mrcal"`` or ``"colmap"``.
    force : bool, optional
        Replace what is there.

    Raises
    ------
    InputError
        Where the format has no such lens.
    OutputError
        Where a file exists or can't be written.
    """
    files = camera_files(camera, path, form)
    for place in files:
        check_free(place, force=force)
    for place, content in files.items():
        write_whole(place, content.encode(), force=force)


def _covariance(camera: FittedCamera) -> str:
    """Covariance as a table: a row and a column per parameter, our pixel origin."""
    assert camera.covariance is not None, "asked of a camera that has one"
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["", *camera.names])
    for name, row in zip(camera.names, camera.covariance.tolist(), strict=True):
        writer.writerow([name, *map(repr, row)])
    return text.getvalue()
