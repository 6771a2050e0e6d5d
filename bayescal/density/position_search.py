"""Where a free camera position is: by least squares, and the normal about it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.direct_linear import direct_linear
from bayescal.density.free_position import FreePositionModel
from bayescal.density.moving_axis import MovingAxis
from bayescal.inference.optimum import Mode, ascend, differences
from bayescal.inference.t_mixture import cholesky
from bayescal.prior.camera import PositionPrior

NEWTON = 3
REACH = 0.1  # of the points' median distance from the prior's mean: the unit of starts and steps
ALONG = (-2.0, -1.0, 1.0, 2.0)  # starts along the line to the points
MOST_STEPS, HALVINGS = 100, 20
LONGEST = 3.0  # step, in the same unit, or in the prior's deviations where the prior is weighed
SETTLED = 1e-9  # nat that a step gains
FLATTEST = 1e-2  # curvature of the log posterior taken for less, of what the slopes say
SHARE = 0.3  # step of the differences, in deviations


def best_position(axes: Sequence[MovingAxis], prior: PositionPrior) -> Array:
    """Position of highest likelihood, the coefficients eliminated (Golub & Pereyra 1973).

    Gauss-Newton from several starts: the prior's mean, a tenth and a fifth of the points' distance
    before and behind it along the line to the points, and the position of the linear camera; how
    wide the prior is plays no part. Each axis is
    weighted by the sigma that its residuals have, within the bounds of its prior: without these,
    pixels without noise would make the likelihood a spike without a top.

    Parameters
    ----------
    prior : PositionPrior
        Where to start, and on which side of the points to stay.

    Returns
    -------
    Array
        ``(3,)``, world units.
    """
    found = [climb(axes, prior, start) for start in _starts(axes, prior)]
    return max(found, key=lambda pair: pair[1])[0]


def _starts(axes: Sequence[MovingAxis], prior: PositionPrior) -> list[Array]:
    world = axes[0].world
    ahead = world.mean(axis=0) - prior.mean
    along = ahead * (_reach(world, prior) / (float(np.linalg.norm(ahead)) or 1.0))
    out = [prior.mean + k * along for k in (0.0, *ALONG)]
    camera = direct_linear(world, np.column_stack([a.data.t for a in axes]))
    if camera is not None:
        out.append(camera.position)
    return [start for start in out if prior.possible(world, start[None])[0]]


def _reach(world: Array, prior: PositionPrior) -> float:
    """Length that a position is searched by, world units."""
    return REACH * float(np.median(np.linalg.norm(world - prior.mean, axis=1))) or 1.0


def climb(
    axes: Sequence[MovingAxis], prior: PositionPrior, start: Array, *, weigh: bool = False
) -> tuple[Array, float]:
    """Climb by Gauss-Newton with halved steps; the position and its log likelihood.

    `weigh` adds the prior to the likelihood.
    """
    unit = np.full(3, _reach(axes[0].world, prior))
    if weigh:
        unit = np.minimum(unit, prior.sd)

    def step(position: Array) -> Array:
        e, slope = _stacked(axes, prior, position, weigh=weigh)
        # A direction that changes nothing is not taken.
        found = np.linalg.lstsq(slope * unit, -e, rcond=1e-12)[0]
        return np.asarray(found * (unit / max(1.0, float(np.linalg.norm(found)) / LONGEST)))

    def height(position: Array) -> float:
        if not prior.possible(axes[0].world, position[None])[0]:
            return -math.inf
        return _height(axes, prior, position, weigh=weigh)

    return ascend(height, step, start, most=MOST_STEPS, halvings=HALVINGS, settled=SETTLED)


def _stacked(
    axes: Sequence[MovingAxis], prior: PositionPrior, position: Array, *, weigh: bool
) -> tuple[Array, Array]:
    """Residuals of both axes in their sigmas, and of the prior; and their slopes."""
    values, slopes = [], []
    for axis in axes:
        e, slope = linearised(axis, position)
        sigma = axis.noise.bounded(float(e @ e), len(e))
        values.append(e / sigma)
        slopes.append(slope / sigma)
    if weigh:
        values.append((position - prior.mean) / prior.sd)
        slopes.append(np.diag(1 / prior.sd))
    return np.concatenate(values), np.concatenate(slopes)


def _height(
    axes: Sequence[MovingAxis], prior: PositionPrior, position: Array, *, weigh: bool
) -> float:
    """Log likelihood at the best coefficients and the best sigma within its bounds.

    But for constants; with the prior where it is weighed.
    """
    total = float(prior.log_density(position[None])[0]) if weigh else 0.0
    for axis in axes:
        e, _ = linearised(axis, position, slopes=False)
        rss = float(e @ e)
        sigma = axis.noise.bounded(rss, len(e))
        total -= rss / sigma**2 / 2 + len(e) * math.log(sigma)
    return total


def position_sd(model: FreePositionModel) -> Array:
    """Give standard errors of the position of highest likelihood, of it alone, ``(3,)``."""
    _, slope = _stacked(model.axes, model.prior, model.start, weigh=False)
    _, d, vt = np.linalg.svd(slope, full_matrices=False)
    with np.errstate(divide="ignore"):
        return np.asarray(np.linalg.norm(vt.T / d, axis=1))


def linearised(axis: MovingAxis, position: Array, *, slopes: bool = True) -> tuple[Array, Array]:
    """Weighted residuals at the best coefficients, and their slopes as these follow.

    Parameters
    ----------
    position : Array
        ``(3,)``.
    slopes : bool, optional
        False leaves them out.

    Returns
    -------
    residuals : Array
        ``(n_points,)``, px, or in units of the points' own deviations.
    slopes : Array
        ``(n_points, 3)`` per world unit: of the design alone, projected on what the coefficients
        can't follow (Kaufman 1975, BIT 15, 49). The slope of the sum of squares, 2 e' times it,
        is exact; empty without slopes.
    """
    sd, step = axis.data.deviations, 1e-30
    places = position + step * 1j * np.eye(3) if slopes else position[None]
    moved = axis.design(places) / sd[:, None]
    q, r = np.linalg.qr(moved[0].real)
    t = axis.data.t / sd
    projected = q.T @ t
    e = t - q @ projected
    if not slopes:
        return e, np.empty((len(e), 0))
    b, *_ = np.linalg.lstsq(r, projected, rcond=None)
    change = (moved.imag / step @ b).T
    return e, q @ (q.T @ change) - change


def position_mode(model: FreePositionModel) -> Mode:
    """Laplace approximation of the position's posterior, by Newton steps.

    Differences go along the axes of what Gauss-Newton makes of the slopes: some forty
    evaluations where a search that knows nothing takes hundreds, and valleys a thousand times
    as long as wide are no trouble.
    """
    world = model.axes[0].world
    # A narrow prior may hold the mode many of its deviations away from the likelihood's.
    starts = [s for s in (model.start, model.prior.mean) if model.prior.possible(world, s[None])[0]]
    found = [climb(model.axes, model.prior, start, weigh=True) for start in starts]
    place = max(found, key=lambda pair: pair[1])[0]
    _, slope = _stacked(model.axes, model.prior, place, weigh=True)
    _, d, vt = np.linalg.svd(slope * model.prior.sd, full_matrices=False)
    step = SHARE * vt.T / d
    theta = (place - model.start) / model.prior.sd
    for _ in range(NEWTON):
        centre, gradient, hessian = _differences(model, theta, step)
        values, vectors = np.linalg.eigh(hessian)
        values = np.maximum(values, FLATTEST * SHARE**2)
        axes = step @ vectors
        root = cholesky((axes / values) @ axes.T)
        move = axes @ (vectors.T @ gradient / values)
        if not float(model.log_prob((theta + move)[None])[0]) > centre:
            break
        theta = theta + move
    return Mode(theta, float(model.log_prob(theta[None])[0]), root)


def _differences(model: FreePositionModel, theta: Array, step: Array) -> tuple[float, Array, Array]:
    """Log density, its slope and minus its curvature, per step: a column of `step` each."""
    centre, up, down, mixed = differences(model.log_prob, theta, step.T)
    i, j = np.triu_indices(3, 1)
    with np.errstate(invalid="ignore"):
        hessian = np.diag(2 * centre - up - down)
        hessian[i, j] = hessian[j, i] = mixed
        gradient = (up - down) / 2
    # Beside an impossible position: no slope, and the curvature of the steps' own making.
    gradient = np.where(np.isfinite(gradient), gradient, 0.0)
    return centre, gradient, np.where(np.isfinite(hessian), hessian, SHARE**2 * np.eye(3))
