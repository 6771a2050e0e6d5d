"""The camera of a comparison of orders: the plausible pairs, axis by axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.key import Key
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials import bivariate, separable
from bayescal.polynomials.basis import Domain
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.prediction.calibrated.camera import CalibratedCamera, normalised
from bayescal.prediction.calibrated.draws import (
    AxisDraws,
    joined,
    joined_estimates,
    new_noise,
    of_posterior,
)
from bayescal.prediction.calibrated.hull import hull_of
from bayescal.prediction.calibrated.members import Member, Parameters
from bayescal.prediction.calibrated.polynomial_member import PolynomialMember

MOST = 12  # models kept of a pair of undecided axes


def orders_camera(result: Comparison) -> CalibratedCamera:
    """Make the camera of a comparison of orders.

    Raises
    ------
    InputError
        Where it is of arrays, or of one axis alone.
    """
    points = result.points
    if points is None:
        raise InputError("a polynomial of arrays is no camera: it has no points of the world")
    if set(result.axes) != set(AXES):
        missing = PIXEL_AXES[next(iter(result.axes))].other
        raise InputError(
            f"the comparison is of one axis alone; a camera needs {missing} too: leave out --axis"
        )
    axes = tuple(result.axes[name] for name in AXES)
    shares = [_shares(axis) for axis in axes]
    draws = [
        {k: of_posterior(axis[k].posterior, axis.data.sd) for k in share}
        for axis, share in zip(axes, shares, strict=True)
    ]
    pairs = sorted(
        ((p * q, k, m) for k, p in shares[0].items() for m, q in shares[1].items()),
        key=lambda pair: (-pair[0], pair[1:]),
    )[:MOST]
    members = [
        polynomial_member(Key(separable.NAME, (k, m)), points, (draws[0][k], draws[1][m]))
        for _, k, m in pairs
    ]
    decided = all(axis.verdict.decided or axis.verdict.order is None for axis in axes)
    weights = [pair[0] for pair in pairs]
    return points_camera(points, members, weights, sum(weights), not decided, result.notes)


def _shares(axis: AxisComparison) -> dict[int, float]:
    """Probability of each plausible order; of a flat prior, the chosen one alone."""
    if axis.verdict.order is None:
        return {axis.chosen.order: 1.0}
    return {k: axis[k].probability or 0.0 for k in axis.verdict.plausible}


def points_camera(
    points: Correspondences,
    members: Sequence[Member],
    weights: Sequence[float],
    covered: float,
    averaged: bool,
    notes: tuple[str, ...],
) -> CalibratedCamera:
    """Put the models of a camera's points together.

    Parameters
    ----------
    weights : sequence of float
        Probability of each, as far as they are `covered` by those kept.
    averaged : bool
        Whether predictions average over them.
    """
    setup = points.setup
    size = None
    if setup.width is not None and setup.height is not None:
        size = (setup.width, setup.height)
    away = points.camera_frame()
    return CalibratedCamera(
        tuple(members),
        normalised(weights),
        covered,
        averaged and len(members) > 1,
        size,
        setup.c_from_bottom,
        hull_of(points.pixels),
        float(np.median(np.linalg.norm(away, axis=1))),
        points.source,
        notes,
    )


def polynomial_member(
    key: Key,
    points: Correspondences,
    axes: tuple[AxisDraws, AxisDraws],
    positions: Array | None = None,
    *,
    name: str = "",
) -> PolynomialMember:
    """Put both axes of a linear family together, with the camera position where it is inferred."""
    stated = points.camera_frame()
    ratios = stated[:, :2] / stated[:, 2:]
    first, second = (Domain.of(ratios[:, i]) for i in (0, 1))
    position: Array | None = np.array(points.setup.position)
    parameters = joined(axes[0].parameters, axes[1].parameters)
    if positions is not None:
        parameters = Parameters.of_draws(np.concatenate([parameters.draws, positions], axis=1))
        moved = points.world - positions.mean(axis=0)
        ratios, position = moved[:, :2] / moved[:, 2:], None
    scaled = np.column_stack([d.scale(ratios[:, i]) for i, d in enumerate((first, second))])
    level = np.column_stack([axis.log_sigma for axis in axes])
    eta = np.stack([axis.eta for axis in axes], axis=1)
    return PolynomialMember(
        (key.orders[0], key.orders[-1]),
        (first, second),
        key.family == bivariate.NAME,
        hull_of(scaled),
        position,
        float(np.sign(np.median(stated[:, 2]))),
        name or f"{key.family} ({key.order})",
        parameters,
        new_noise(level, eta, axes[0].noise, (axes[0].sd, axes[1].sd)),
        joined_estimates(*(axis.estimate for axis in axes)),
    )
