"""What a joint model leaves over at its highest likelihood, point by point."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.families.models import linear_axes
from bayescal.comparison.families.results import FamilyComparison, JointModel
from bayescal.comparison.key import PINHOLE
from bayescal.density.moving_axis import MovingAxis
from bayescal.density.pinhole import PinholeModel


def joint_residuals(found: FamilyComparison, model: JointModel) -> Array:
    """Measured less predicted, by least squares at the model's best camera position.

    Parameters
    ----------
    found : FamilyComparison
    model : JointModel
        One of `found.models`.

    Returns
    -------
    Array
        Of r and of c, ``(2, n_points)``, px.
    """
    if model.name.family == PINHOLE:
        return _pinhole(model)
    request, orders = found.request, model.name.orders
    axes = linear_axes(found.points, model.name.family, found.settings, request.orders[-1])
    out = []
    for i, (axis, k) in enumerate(zip(axes, (orders[0], orders[-1]), strict=True)):
        data, prior = axis.data, axis.rule.of_degrees(axis.data.degrees(k))
        moving = MovingAxis(data, found.points.world, i, k, axis.noise, prior)
        design = moving.design(model.position[None])[0]
        sd = np.ones(len(data)) if data.sd is None else data.sd
        b, *_ = np.linalg.lstsq(design / sd[:, None], data.t / sd, rcond=None)
        out.append(data.t - design @ b)
    return np.stack(out)


def _pinhole(model: JointModel) -> Array:
    assert model.posterior is not None, "every pinhole is sampled"
    pinhole = model.posterior.model
    assert isinstance(pinhole, PinholeModel), "it was sampled as one"
    geometry = pinhole.geometry
    pixels, _ = geometry.project(geometry.full(pinhole.fit.free[None]))
    return np.asarray(pinhole.data.pixels - pixels[0])
