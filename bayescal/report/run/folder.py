"""What a run's folder holds, and how it is filled.

``result.json``       the result document (what marks a folder as a run)
``run.json``          the format's number, who wrote it, the hash of every file below and above
``points.csv``        the points, every digit of them
``reduction.npz``     of many points, of which points.csv holds a sample: their factorisation
``setup.toml``        what is known of the camera
``views.csv``         views of a target, in place of points and setup
``camera.npz``        the calibrated camera (bayescal.prediction), where the result is of one
``derived.npz``         what else took long (bayescal.encoding), for `open_run` alone
``draws/NAME.nc``     draws of one model, such as ``r-order-4``, as NetCDF that ArviZ opens
``covariance.csv``      how the parameters of every model move together, for other programs
``corner-*.png``      pictures, for people only

Beside it, while it is made, ``RUN.unfinished`` (`bayescal.report.run.unfinished`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from bayescal.arrays import Array
from bayescal.encoding import encoded
from bayescal.files import RESULT, FolderKind
from bayescal.inference.arviz_bridge import Draws, write_netcdf
from bayescal.report.run.bounded import CAMERA, bounded
from bayescal.report.run.bounded import MANIFEST as MANIFEST
from bayescal.report.run.covariance import COVARIANCE
from bayescal.report.run.reduction import REDUCTION
from bayescal.version import __version__

# Rises when an older version could no longer read what a newer one writes.
FORMAT = 1
POINTS, SETUP, VIEWS = "points.csv", "setup.toml", "views.csv"
DERIVED, DRAWS = "derived.npz", "draws"
MADE_OF = "made of"
RUN = FolderKind(
    "run",
    RESULT,
    (
        MANIFEST,
        POINTS,
        REDUCTION,
        SETUP,
        VIEWS,
        "lenses.npz",  # of 0.1
        CAMERA,
        COVARIANCE,
        DERIVED,
        DRAWS,
        "corner-*.png",
    ),
)


class Read(Protocol):
    """Points or views, as they were read."""

    @property
    def lines(self) -> tuple[int, ...] | None:
        """Lines of their file."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed."""
        ...


def fill_run(
    folder: Path,
    files: Mapping[str, bytes],
    draws: Mapping[str, Draws],
    derived: Mapping[str, Any],
    read: Read,
) -> None:
    """Write beside the document what a run is reopened from.

    Parameters
    ----------
    folder : Path
        Holds the document.
    files : mapping of str to bytes
        What the result is of, its camera and what else it takes up again, by their names.
    draws : mapping of str to Draws
        By the model's name.
    derived : mapping of str to Any
        What else took long, by name.
    read : Read
        What was read, once.
    """
    for name, raw in files.items():
        (folder / name).write_bytes(raw)
    (folder / DERIVED).write_bytes(encoded({**derived, MADE_OF: made_of(folder)}))
    (folder / DRAWS).mkdir()
    for name, kept in draws.items():
        write_netcdf(folder / DRAWS / f"{name}.nc", kept)
    names = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    hashes = {name: digest((folder / name).read_bytes()) for name in names}
    manifest: dict[str, Any] = {
        "format": FORMAT,
        "bayescal": __version__,
        "files": hashes,
        # The points' lines in the file they once came from, for messages.
        "lines": None if read.lines is None else list(read.lines),
        # What had to be assumed to read it.
        "notes": list(read.notes),
    }
    (folder / MANIFEST).write_bytes((json.dumps(manifest) + "\n").encode())


def made_of(folder: Path) -> str:
    """Hash of what derived values follow from: points, camera, settings, and who computed them."""
    settings = json.loads((folder / RESULT).read_bytes()).get("settings")
    kept = (folder / name for name in (POINTS, REDUCTION, SETUP, VIEWS))
    parts = [bounded(path, "make the run again") for path in kept if path.is_file()]
    return digest(b"".join([*parts, json.dumps(settings).encode(), __version__.encode()]))


def digest(raw: bytes) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(raw).hexdigest()


def described(
    draws: Draws, groups: dict[str, dict[str, Array]], *, library: str = "emcee", **words: Any
) -> Draws:
    """Add to draws what a reader who knows nothing of bayescal needs: data, model, units."""
    draws.groups.update(groups)
    draws.described.update({**words, "inference_library": library})
    return draws
