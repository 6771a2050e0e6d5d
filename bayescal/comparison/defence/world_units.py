"""How many pixels one unit of error in a world coordinate is worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.pixel_axis import PIXEL_AXES


@dataclass(frozen=True)
class WorldUnit:
    """Slope of a pixel over one world coordinate at two points.

    Attributes
    ----------
    coordinate : str
        ``"x"``, ``"y"`` or ``"z"``.
    nearest, median : float
        Size of the slope at the nearest point and at the one of median depth, px per
        world unit.
    nearest_point, median_point : str
        Labels of these points.
    """

    coordinate: str
    nearest: float
    median: float
    nearest_point: str
    median_point: str


def world_units(data: AxisData, fit: LeastSquaresFit, camera: Array) -> tuple[WorldUnit, ...]:
    """Carry a unit of error in each world coordinate to pixels.

    Parameters
    ----------
    data : AxisData
        Of the separable family.
    fit : LeastSquaresFit
        Whose slope is used.
    camera : Array
        Points in the camera's frame, ``(n_points, 3)``, world units.

    Returns
    -------
    tuple of WorldUnit
        Of x and z for r, of y and z for c.
    """
    domain, depth = data.domain, camera[:, 2]
    derivative = np.polynomial.legendre.legder(fit.amplitudes) / domain.half_range
    slope = np.polynomial.legendre.legval(domain.scale(data.x), derivative)
    by_depth = np.argsort(np.abs(depth), kind="stable")
    near, middle = int(by_depth[0]), int(by_depth[(len(by_depth) - 1) // 2])
    across = PIXEL_AXES[data.axis].across
    worth = {across: np.abs(slope / depth), "z": np.abs(slope * data.x / depth)}
    return tuple(
        WorldUnit(name, float(px[near]), float(px[middle]), data.labels[near], data.labels[middle])
        for name, px in worth.items()
    )
