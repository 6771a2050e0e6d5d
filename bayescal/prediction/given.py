"""What is given to a calibrated camera: points, pixels, and the surface they look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.errors import InputError
from bayescal.points.given import table

LARGEST = 1e100  # of depths and planes: squares of distances are doubles


@dataclass(frozen=True)
class Surface:
    """A plane a x + b y + c z = d of the world (of the camera's frame for a lens without pose).

    Attributes
    ----------
    normal : tuple of float
        a, b, c.
    offset : float
        d.
    sd : float
        Of d, the same error for all pixels.
    """

    normal: tuple[float, float, float]
    offset: float
    sd: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite([*self.normal, self.offset, self.sd]).all() and any(self.normal)):
            raise InputError("a plane needs finite a, b, c, d, of which a, b, c are not all 0")
        if max(*map(abs, self.normal), abs(self.offset), self.sd) >= LARGEST:
            raise InputError(f"a depth, and a plane's a, b, c, d, must be below {LARGEST:g}")
        if self.sd < 0:
            raise InputError(f"the depth's sd is {self.sd:g}: it can't be negative")


def surface_of(
    depth: float | None, depth_sd: float, plane: Sequence[float] | None
) -> Surface | None:
    """Make the surface of a depth z, or of a plane's a, b, c, d; None where neither is given.

    Raises
    ------
    InputError
        Where both are given, or a plane is none.
    """
    if depth is not None and plane is not None:
        raise InputError("depth and plane both say where the points lie: keep one")
    if depth is not None:
        if not abs(depth) < LARGEST:
            raise InputError(f"the depth is {depth:g}: give a finite z in world units")
        return Surface((0.0, 0.0, 1.0), depth, depth_sd)
    if plane is None:
        return None
    if len(plane) != 4:
        raise InputError(f"a plane needs a, b, c, d, not {len(plane)} numbers")
    a, b, c, d = plane
    return Surface((a, b, c), d)


def checked(values: ArrayLike, columns: int, what: str) -> Array:
    """Points or pixels as an array ``(n, columns)`` of finite numbers.

    Raises
    ------
    InputError
    """
    array = table(values, columns, what, "n")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise InputError(f"{what}, row {int(bad[0]) + 1}: holds a number that is not finite")
    return array
