"""MATLAB files: Bouguet's ``Calib_Results.mat``, and points of the Computer Vision Toolbox.

Bouguet's toolbox keeps, for each image k, ``X_k`` (3, n) on the target and ``x_k`` (2, n), px, with
(0, 0) at the first pixel's centre; ``nx, ny``, the image size; ``active_images``, which are used.
The Computer Vision Toolbox counts pixels from 1 (its "intrinsic coordinates"): ``imagePoints``
(n, 2, views), NaN where a point is missing, and ``worldPoints`` (n, 2) or (n, 3), as
detectCheckerboardPoints and generateCheckerboardPoints return them; ``imageSize`` is rows, columns.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.views.formats.arrays import Seen, assembled, image_size, plain, views_of
from bayescal.points.views.formats.mat_contents import numeric_variables
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views
from bayescal.rounding import counted

NAME = "MATLAB file"
_BOUGUET = re.compile(r"([Xx])_(\d{1,5})")
_TOOLBOX = ("imagepoints", "worldpoints", "imagesize")
_SCALARS = ("nx", "ny", "active_images")


def recognises(source: Source) -> bool:
    """Whether it says that it is one, or is called so."""
    return source.raw.startswith(b"MATLAB 5.0 MAT-file") or source.suffix == ".mat"


def read(source: Source) -> Views:
    """Read the file.

    Raises
    ------
    InputError
        Where it can't be used.
    """
    found = _load(source)
    pairs = _bouguet(found)
    if pairs:
        source.refuse_board()
        seen, notes = _active(pairs, found.get("active_images"))
        return assembled(source, seen, image_size(found), notes)
    shaped = {name: _toolbox(name, array) for name, array in found.items()}
    views = views_of(source, shaped)
    views = [Seen(one.name, one.world, one.pixels - 1.0) for one in views]
    size = shaped.get("imageSize")
    stated = image_size({"image_shape": size}) if size is not None else (None, None)
    note = "pixels counted from 1, as MATLAB does, were taken one less"
    return assembled(source, views, stated, (note,))


def _wanted(name: str) -> bool:
    return bool(_BOUGUET.fullmatch(name)) or plain(name) in _TOOLBOX or name in _SCALARS


def _load(source: Source) -> dict[str, Array]:
    """Read the variables that matter, where they are arrays of real numbers."""
    if source.raw[:128].startswith(b"MATLAB 7.3") or source.raw.startswith(b"\x89HDF"):
        raise InputError(f"{source.name}: is of MATLAB's version 7.3; save it with -v7")
    found = numeric_variables(source.name, source.raw, _wanted)
    if not found:
        raise InputError(
            f"{source.name}: holds neither Bouguet's X_1, x_1, ... nor arrays imagePoints and "
            "worldPoints; save those (an object such as cameraParams can't be read)"
        )
    return found


def _bouguet(found: Mapping[str, Array]) -> list[tuple[int, Array, Array]]:
    """Collect number, X ``(n, 3)`` and x ``(n, 2)`` of each image that has both."""
    kept = []
    for name, array in found.items():
        match = _BOUGUET.fullmatch(name)
        pixels = found.get(f"x_{match[2]}") if match and match[1] == "X" else None
        if match is None or pixels is None:
            continue
        if array.ndim == pixels.ndim == 2 and array.shape == (3, pixels.shape[1]):
            kept.append((int(match[2]), array.T, pixels[:2].T))
    return sorted(kept, key=lambda pair: pair[0])


def _active(
    pairs: list[tuple[int, Array, Array]], active: Array | None
) -> tuple[list[Seen], tuple[str, ...]]:
    """Leave out the images that the toolbox's user put aside."""
    flags = np.ones(0) if active is None else active.ravel()
    used = [p for p in pairs if not (p[0] <= len(flags) and flags[p[0] - 1] == 0)]
    aside = len(pairs) - len(used)
    notes = (f"{counted(aside, 'view')} put aside in the toolbox left out",) if aside else ()
    return [Seen(str(number), world, pixels) for number, world, pixels in used], notes


def _toolbox(name: str, array: Array) -> Array:
    """Bring MATLAB's (points, 2, views) to (views, points, 2)."""
    return np.moveaxis(array, 2, 0) if array.ndim == 3 and plain(name) == "imagepoints" else array
