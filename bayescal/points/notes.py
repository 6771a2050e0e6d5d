"""What is odd about some points, or was assumed of them because nobody said otherwise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.rounding import counted


def point_notes(points: Correspondences) -> list[str]:
    """Say it, a line each: assumptions, points off the image, or repeated."""
    setup = points.setup
    found = list(points.notes)
    if "position" in setup.assumed:
        found.append(f"camera position {setup.position} is assumed")
    found += [
        f"image {name} {getattr(setup, name):g} px is assumed"
        for name in ("width", "height")
        if name in setup.assumed
    ]
    # Among many points they were counted as they were read.
    off = _off_the_image(points) if points.drawn_from is None else []
    return found + off + _repeated(points)


def _of(count: int, points: Correspondences, one: str, more: str) -> str:
    return f"{count} of {counted(len(points), 'point')} {one if count == 1 else more}"


def off_the_image(points: Correspondences) -> NDArray[np.bool_]:
    """Whether each pixel is none of an image of the stated size, ``(n_points,)``."""
    off = np.zeros(len(points), dtype=bool)
    for axis in AXES:
        size, t = points.setup.size(axis), points.pixel(axis)
        if size is not None:
            off |= (t < -0.5) | (t > size + 0.5)
    return off


def _off_the_image(points: Correspondences) -> list[str]:
    """Pixels that an image of the stated size can't hold; half a pixel beyond an edge is on it."""
    off = off_the_image(points)
    if not off.any():
        return []
    first = int(np.argmax(off))
    r, c = points.pixels[first].tolist()
    return [
        f"{_of(int(off.sum()), points, 'lies', 'lie')} off the image (the first at "
        f"{points.place(first)}: r = {r:g}, c = {c:g}); check its size, or the readings"
    ]


def _repeated(points: Correspondences) -> list[str]:
    """Rows that are a copy of one before, world point and pixels alike."""
    rows = np.column_stack([points.world, points.pixels])
    _, first = np.unique(rows, axis=0, return_index=True)
    copies = len(points) - len(first)
    if not copies:
        return []
    which = int(np.setdiff1d(np.arange(len(points)), first)[0])
    return [
        f"{_of(copies, points, 'repeats', 'repeat')} another exactly (the first at "
        f"{points.place(which)}); each counts as a reading of its own, and copies of one reading "
        "would make every interval too narrow"
    ]
