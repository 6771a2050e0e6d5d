"""A camera as one small file: arrays as NumPy keeps them (npz), all else as JSON within.

npz needs nothing but NumPy to be read, so that the first answer costs little more than importing
it (HDF5 and its wrappers take longer to import than to read); it is a zip archive that any
language opens, and it is read without pickle: a file from elsewhere can't run anything.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bayescal.arrays import Array, from_npz, to_npz
from bayescal.errors import InputError
from bayescal.files import write_whole
from bayescal.points.tables.content import read_file
from bayescal.polynomials.basis import Domain
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import Estimate, Member, Parameters
from bayescal.prediction.calibrated.noise import NewNoise
from bayescal.version import __version__

SCHEMA = "bayescal-camera-1"
HEAD = "camera"
LARGEST = 64_000_000  # bytes
ARCHIVE = b"PK"  # how npz files begin
GIVEN = "a run's folder or a camera file"


def keep_camera(camera: CalibratedCamera, path: str | Path, *, force: bool = False) -> None:
    """Write a calibrated camera to one file, which `bayescal.camera` reads.

    Parameters
    ----------
    camera : CalibratedCamera
    path : str or Path
        Such as ``camera.npz``.
    force : bool, optional
        Replace an existing file.

    Raises
    ------
    OutputError
        Where it can't be written.
    """
    write_whole(Path(path), camera_bytes(camera), force=force)


def load_camera(path: str | Path) -> CalibratedCamera:
    """Read a calibrated camera that `keep_camera`, or a run, wrote.

    Returns
    -------
    CalibratedCamera

    Raises
    ------
    InputError
        Where it is no such file, or is damaged.
    """
    return camera_from(read_file(path, GIVEN, LARGEST).raw, str(path))


def camera_bytes(camera: CalibratedCamera) -> bytes:
    """Encode a camera; the same camera gives the same bytes."""
    arrays: dict[str, Array] = {"pixel_hull": camera.pixel_hull}
    head = {
        "schema": SCHEMA,
        "bayescal": __version__,
        "probabilities": camera.probabilities,
        "covered": camera.covered,
        "averaged": camera.averaged,
        "size": camera.size,
        "c_from_bottom": camera.c_from_bottom,
        "distance": camera.distance,
        "source": camera.source,
        "notes": camera.notes,
        "members": [_packed(m, f"{i}.", arrays) for i, m in enumerate(camera.members)],
    }
    return to_npz(head, arrays, HEAD)


def camera_from(raw: bytes, name: str) -> CalibratedCamera:
    """Decode a camera; `name` is the file's, for messages.

    Raises
    ------
    InputError
    """
    if not raw.startswith(ARCHIVE):
        raise InputError(f"{name}: is no camera file; give {GIVEN}, before all else")
    try:
        head, arrays = from_npz(raw, HEAD)
        schema = head["schema"]
        if schema == SCHEMA:
            return _camera(head, arrays)
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{name}: is no camera file, or is damaged ({' '.join(str(error).split())}); "
            "write it again"
        ) from None
    raise InputError(
        f"{name}: is a camera of schema {schema!r}, written by bayescal {head.get('bayescal')}; "
        f"bayescal {__version__} reads {SCHEMA!r}; write it again"
    )


def _packed(member: Member, at: str, arrays: dict[str, Array]) -> dict[str, Any]:
    """Put a member's arrays beside the others; give what is no array."""
    kept, noise = member.parameters, member.noise
    arrays.update(
        {
            f"{at}mean": kept.mean,
            f"{at}root": kept.root,
            f"{at}draws": kept.draws,
            f"{at}log_sigma": noise.log_sigma,
            f"{at}eta": noise.eta,
        }
    )
    if noise.neighbours is not None:
        arrays[f"{at}neighbours"] = noise.neighbours
    arrays[f"{at}hull"] = member.hull
    if member.estimate is not None:
        arrays[f"{at}estimate"] = member.estimate.value
        arrays[f"{at}estimate_root"] = member.estimate.root
        arrays[f"{at}estimate_levels"] = np.array(member.estimate.levels, dtype=np.float64)
    values: dict[str, Any] = {
        "name": member.name,
        "exact": kept.exact,
        "noise": {"name": noise.name, "nu": noise.nu, "bad_offset": noise.bad_offset},
    }
    return values | member.plain()


def _camera(head: dict[str, Any], arrays: dict[str, Array]) -> CalibratedCamera:
    return CalibratedCamera(
        tuple(_member(m, f"{i}.", arrays) for i, m in enumerate(head["members"])),
        tuple(head["probabilities"]),
        head["covered"],
        head["averaged"],
        None if head["size"] is None else (head["size"][0], head["size"][1]),
        head["c_from_bottom"],
        arrays["pixel_hull"],
        head["distance"],
        head["source"],
        tuple(head["notes"]),
    )


def _member(values: dict[str, Any], at: str, arrays: dict[str, Array]) -> Member:
    parameters = Parameters(
        arrays[f"{at}mean"], arrays[f"{at}root"], arrays[f"{at}draws"], values["exact"]
    )
    noise = NewNoise(
        arrays[f"{at}log_sigma"],
        arrays[f"{at}eta"],
        **values["noise"],
        neighbours=arrays.get(f"{at}neighbours"),
    )
    estimate = None
    if f"{at}estimate" in arrays:
        levels = arrays[f"{at}estimate_levels"].tolist()
        estimate = Estimate(
            arrays[f"{at}estimate"],
            arrays[f"{at}estimate_root"],
            tuple((int(columns), dof) for columns, dof in levels),
        )
    if "lens" in values:
        from bayescal.prediction.calibrated.lens_member import LensMember

        return LensMember(
            values["name"],
            values["lens"],
            values["options"],
            _array(values["turn"]),
            _array(values["anchor"]),
            arrays[f"{at}hull"],
            parameters,
            noise,
            estimate,
        )
    from bayescal.prediction.calibrated.polynomial_member import PolynomialMember

    first, second = (Domain(*ends) for ends in values["domains"])
    return PolynomialMember(
        (values["orders"][0], values["orders"][1]),
        (first, second),
        values["bivariate"],
        arrays[f"{at}hull"],
        _array(values["position"]),
        values["side"],
        values["name"],
        parameters,
        noise,
        estimate,
    )


def _array(values: Any) -> Array | None:
    return None if values is None else np.array(values)
