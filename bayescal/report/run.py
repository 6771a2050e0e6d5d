"""A run: a folder that holds a result, its points and its draws, and can be reopened.

``result.json``       the result document (what marks a folder as a run)
``run.json``          the format's number, who wrote it, the hash of every file below and above
``points.csv``        the points, every digit of them
``setup.toml``        what is known of the camera
``draws/NAME.nc``     draws of one model, such as ``r-order-4``, as NetCDF that ArviZ opens
``corner-*.png``      pictures, for people only

What the result is, and how it is written and read, is said by `comparison_run`,
`outliers_run` and `families_run`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bayescal.files import RESULT, FolderKind, check_folder, write_folder
from bayescal.inference.arviz_bridge import Draws, write_netcdf
from bayescal.points.correspondences import Correspondences
from bayescal.points.writer import to_csv, to_toml
from bayescal.polynomials.axis_data import AxisData
from bayescal.version import __version__

# Rises when an older version could no longer read what a newer one writes.
FORMAT = 1
MANIFEST, POINTS, SETUP = "run.json", "points.csv", "setup.toml"
DRAWS = "draws"
RUN = FolderKind("run", RESULT, (MANIFEST, POINTS, SETUP, DRAWS, "corner-*.png"))


def check_run(folder: Path, *, force: bool) -> None:
    """Refuse, before any work is done, a place a run can't be written to.

    Raises
    ------
    OutputError
        Where something other than an earlier run stands there, or an earlier run
        without `force`, or the folder around it does not exist.
    """
    check_folder(folder, RUN, force=force)


def fill_run(
    folder: Path,
    points: Correspondences,
    result_json: str,
    draws: Mapping[str, Draws],
    pictures: Callable[[Path], None] | None = None,
    *,
    force: bool,
) -> None:
    """Write what every run holds, whole or not at all.

    Parameters
    ----------
    folder : Path
    points : Correspondences
    result_json : str
        The result document.
    draws : mapping of str to Draws
        By the model's name.
    pictures : callable, optional
        Given the folder, adds what nothing is read from.
    force : bool
        Replace an earlier run.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """

    def fill(made: Path) -> None:
        texts = {RESULT: result_json, POINTS: to_csv(points), SETUP: to_toml(points.setup)}
        for name, text in texts.items():
            (made / name).write_bytes(text.encode())
        (made / DRAWS).mkdir()
        for name, kept in draws.items():
            write_netcdf(made / DRAWS / f"{name}.nc", kept)
        names = sorted(p.relative_to(made).as_posix() for p in made.rglob("*") if p.is_file())
        hashes = {name: digest((made / name).read_bytes()) for name in names}
        (made / MANIFEST).write_bytes((json.dumps(_manifest(points, hashes)) + "\n").encode())
        if pictures is not None:
            pictures(made)

    write_folder(folder, RUN, fill, force=force)


def _manifest(points: Correspondences, files: dict[str, str]) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "bayescal": __version__,
        "files": files,
        # The points' lines in the file they once came from, for messages.
        "lines": None if points.lines is None else list(points.lines),
        # What had to be assumed to read it.
        "notes": list(points.notes),
    }


def digest(raw: bytes) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(raw).hexdigest()


def described(draws: Draws, data: AxisData, order: int) -> Draws:
    """Add to draws what a reader who knows nothing of bayescal needs: data, axis, units."""
    draws.groups["observed_data"] = {"pixel": data.t, "regressor": data.x}
    draws.described.update(
        {
            "axis": data.axis,
            "regressor": data.regressor,
            "order": order,
            "units": "coefficients and sigma in px, tau a fraction of the image, scale a factor",
            "inference_library": "emcee",
        }
    )
    return draws
