"""mrcal's ``.cameramodel`` with the observations it was made of.

The file is a Python literal; its 'optimization_inputs' are an .npz in base 85 whose
observations_board (observations, rows, columns, 3) hold x, y and weight (below 0: not seen, or
rejected by mrcal), indices_frame_camintrinsics_camextrinsics which camera saw them, and
calibration_object_spacing the side of a square (mrcal.cameramodel). The camera is the file's own,
'icam_intrinsics'. Nothing is ever unpickled.
"""

from __future__ import annotations

import ast
import base64
import warnings

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.tables.text import decode
from bayescal.points.views.board import Board
from bayescal.points.views.formats.archive import read_arrays
from bayescal.points.views.formats.arrays import Seen, assembled
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views
from bayescal.rounding import counted

NAME = ".cameramodel"
OBSERVED = "observations_board"
INDICES = "indices_frame_camintrinsics_camextrinsics"
SPACING = "calibration_object_spacing"
NEEDED = (OBSERVED, INDICES, SPACING, "imagersizes")


def recognises(source: Source) -> bool:
    """Whether it is called so, or is a literal that names a lens model of mrcal."""
    return source.suffix == ".cameramodel" or b"'lensmodel'" in source.raw


def read(source: Source) -> Views:
    """Read what the camera saw.

    Raises
    ------
    InputError
        Where there are no observations in it, or they can't be used.
    """
    source.refuse_board()
    model = _literal(source)
    packed, camera = model.get("optimization_inputs"), model.get("icam_intrinsics", 0)
    if not isinstance(packed, bytes):
        raise InputError(
            f"{source.name}: holds a camera without the observations it was made of; give one "
            "with optimization_inputs, or corners.vnl"
        )
    if not isinstance(camera, int) or not 0 <= camera < 1_000_000:
        raise InputError(f"{source.name}: icam_intrinsics is no number of a camera")
    try:
        raw = base64.b85decode(packed)
    except ValueError:
        raise InputError(f"{source.name}: its optimization_inputs are damaged") from None
    arrays = read_arrays(source.name, raw, NEEDED.__contains__)
    return _views(source, arrays, camera)


def _literal(source: Source) -> dict[object, object]:
    """Parse the file, which is data and no program."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes in a damaged file
            found = ast.literal_eval(decode(source.name, source.raw).lstrip())
    except InputError:
        raise
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError(f"{source.name}: is no sound .cameramodel; write it again")
    return found


def _views(source: Source, arrays: dict[str, Array], camera: int) -> Views:
    missing = [name for name in (OBSERVED, INDICES, SPACING) if name not in arrays]
    if missing:
        raise InputError(f"{source.name}: its optimization_inputs lack {missing[0]}")
    observed, indices, spacing = arrays[OBSERVED], arrays[INDICES], arrays[SPACING]
    shapes = observed.ndim == 4 and observed.shape[3] == 3 and spacing.size == 1
    if not shapes or indices.shape != (len(observed), 3):
        raise InputError(f"{source.name}: its observations don't go together; write it again")
    board = Board(observed.shape[2], observed.shape[1], spacing.item())
    mine = np.flatnonzero(indices[:, 1] == camera)
    seen, sigma, rejected = [], [], 0
    for one in mine.tolist():
        pixels, weight = observed[one].reshape(-1, 3)[:, :2], observed[one].reshape(-1, 3)[:, 2]
        there = weight > 0
        rejected += int(((weight <= 0) & (pixels >= 0).all(axis=1)).sum())
        name = f"frame {int(indices[one, 0])}"
        seen.append(Seen(name, board.points(), np.where(there[:, None], pixels, np.nan)))
        sigma.append(np.clip(1.0 / np.where(there, weight, 1.0), 1e-6, 1e6))
    if len({one.name for one in seen}) < len(seen):
        raise InputError(
            f"{source.name}: camera {camera} moved and saw the same board twice at once; views of "
            "one target are needed"
        )
    notes = [f"{counted(rejected, 'point')} that mrcal rejected left out"] if rejected else []
    if len(mine) < len(observed):
        notes.append(f"camera {camera} of several; the views of the others left out")
    return assembled(source, seen, _size(arrays, camera), tuple(notes), sigma)


def _size(arrays: dict[str, Array], camera: int) -> tuple[float | None, float | None]:
    sizes = arrays.get("imagersizes", np.empty(0))
    if sizes.ndim != 2 or sizes.shape[1] != 2 or not camera < len(sizes):
        return None, None
    return float(sizes[camera, 0]), float(sizes[camera, 1])
