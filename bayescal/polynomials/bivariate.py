"""The bivariate family: r and c each a polynomial of x/z and y/z together.

Order k has every product (x/z)^i (y/z)^j with i + j <= k. The separable family's order
k is not nested in it only where k is larger; a camera turned away from the stated
axes, which no separable polynomial can follow, shows in the mixed terms.
"""

from __future__ import annotations

from dataclasses import replace

from bayescal.points.correspondences import Correspondences
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.pixel_axis import PIXEL_AXES

NAME = "bivariate"


def axis_data(points: Correspondences, axis: str) -> AxisData:
    """Regression problem of one axis, on both regressors.

    The first regressor is the axis's own (x/z for r, y/z for c), as in the separable
    family, so that the first index of a coefficient is its power.

    Parameters
    ----------
    axis : str
        ``"r"`` or ``"c"``.

    Raises
    ------
    InputError
        As `bayescal.polynomials.separable.axis_data`.
    """
    own = separable.axis_data(points, axis)
    other = separable.axis_data(points, PIXEL_AXES[axis].other)
    return replace(own, regressor=f"{own.regressor} and {other.regressor}", other=other.x)
