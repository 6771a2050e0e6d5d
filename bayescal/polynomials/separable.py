"""The thesis's family: r a polynomial of x/z alone, c of y/z alone (eq. 35-53)."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.points.correspondences import LARGEST, Correspondences
from bayescal.points.pixel import pixel_of
from bayescal.polynomials.axis_data import AxisData, pixel_span
from bayescal.polynomials.pixel_axis import PIXEL_AXES

NAME = "separable"


def axis_data(points: Correspondences, axis: str) -> AxisData:
    """Regression problem of one axis.

    The regressors are w = x/z for r and u = y/z for c, after the camera position
    is subtracted (thesis eq. 35-36 and Appendix B).

    Parameters
    ----------
    axis : str
        ``"r"`` or ``"c"``.

    Raises
    ------
    InputError
        Where a point lies in the camera's plane (z = 0) or so close to it that
        the regressor overflows, or a pixel more than an image size outside the image.
    """
    own = PIXEL_AXES[axis]
    camera = points.camera_frame()
    depth = camera[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x = camera[:, own.column] / depth
    bad = np.flatnonzero(~(np.abs(x) < LARGEST) | (depth == 0))
    if bad.size:
        raise InputError(
            f"{points.place(int(bad[0]))}: z is {points.world[bad[0], 2] + 0.0:g}, in the "
            f"camera's plane, where {own.regressor} is infinite; remove the point or correct the "
            "camera position"
        )
    t = points.checked_pixel(axis)
    size = points.setup.size(axis)
    return AxisData(
        axis=axis,
        regressor=own.regressor,
        symbol=own.symbol,
        x=frozen(x),
        t=frozen(t),
        sd=points.sigma.get(axis),
        labels=points.labels,
        size=pixel_span(t) if size is None else size,
        size_known=size is not None,
        source=points.source,
        x_sd=_regressor_deviations(points, own.column),
    )


def axis_pixel(points: Correspondences, axis: str) -> float:
    """Give what stands for a pixel on an axis, in units of its readings."""
    size = points.setup.size(axis)
    span = pixel_span(points.pixel(axis)) if size is None else size
    return pixel_of(span, known=size is not None)


def _regressor_deviations(points: Correspondences, column: int) -> Array | None:
    """First-order deviations of x/z or y/z from those of the world coordinates."""
    sigma = points.world_sigma()
    if sigma is None:
        return None
    camera = points.camera_frame()
    depth = camera[:, 2]
    return np.hypot(sigma[:, column] / depth, camera[:, column] * sigma[:, 2] / depth**2)
