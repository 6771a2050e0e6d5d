"""The camera that a run, or a file, holds: read without the run's draws where it is kept."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera, no_camera
from bayescal.prediction.calibrated.saved import camera_from, load_camera
from bayescal.report.run.bounded import CAMERA, MANIFEST, bounded


def camera_at(place: str | Path) -> CalibratedCamera:
    """Take the camera out of a run, or of a file that `keep_camera` wrote.

    A run that was written without one is reopened, which takes longer.

    Raises
    ------
    InputError
        Where there is none, or the file is not what was written.
    """
    path = Path(place)
    if not path.is_dir():
        return load_camera(path)
    file = path / CAMERA
    if not file.is_file():
        return _reopened(path)
    raw = bounded(file, "make the run again")
    if (path / MANIFEST).exists() and hashlib.sha256(raw).hexdigest() != _expected(path):
        raise InputError(
            f"{file}: is not what was written there (its SHA-256 differs from the one in "
            f"{MANIFEST}): changed or cut off; restore it, or make the run again"
        )
    return camera_from(raw, str(file))


def camera_of(result: object) -> CalibratedCamera:
    """Make the camera of a comparison of orders, of families, or of lens models.

    Raises
    ------
    InputError
        Where the result is of no camera: of arrays, or of one axis alone.
    """
    from bayescal.report.runs import kinds

    kind = next((kind for kind in kinds() if isinstance(result, kind.result)), None)
    if kind is None:
        raise no_camera(result)
    return kind.camera(result)


def _expected(folder: Path) -> str | None:
    """Hash of the camera as the run's manifest has it."""
    try:
        return str(json.loads(bounded(folder / MANIFEST, "make the run again"))["files"][CAMERA])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _reopened(folder: Path) -> CalibratedCamera:
    """Make the camera of a run that holds none."""
    from bayescal.report.runs import open_run

    result = open_run(folder)
    try:
        return camera_of(result)
    except InputError as error:
        raise InputError(f"{folder}: {error}") from None
