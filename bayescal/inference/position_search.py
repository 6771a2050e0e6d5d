"""Where a free camera position is: by least squares, and the normal about it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from bayescal.arrays import Array
from bayescal.inference.free_position import FreePositionModel, MovingAxis
from bayescal.inference.optimum import Mode
from bayescal.inference.t_mixture import cholesky
from bayescal.models.camera_prior import PositionPrior

NEWTON = 3


def best_position(
    axes: Sequence[MovingAxis], prior: PositionPrior, log_likelihood: Callable[[Array], float]
) -> tuple[Array, float]:
    """Position of highest likelihood, the coefficients eliminated (Golub & Pereyra 1973).

    Parameters
    ----------
    axes : sequence of MovingAxis
    prior : PositionPrior
        Where to start, and how far apart to look.
    log_likelihood : callable
        From the axes' weighted sums of squares to the maximised log likelihood.

    Returns
    -------
    position : Array
        ``(3,)``, world units.
    log_likelihood : float
    """
    z, mean, sd = axes[0].world[:, 2], prior.mean, prior.sd
    side = np.sign(z - mean[2])

    def objective(u: Array) -> tuple[float, Array]:
        position = mean + u * sd
        if (np.sign(z - position[2]) != side).any():
            return 1e300, np.zeros(3)
        rss, slopes = zip(*(profile(axis, position) for axis in axes), strict=True)
        values = np.array(rss)
        top = log_likelihood(values)
        # ln L depends on each sum of squares q as -n/2 ln q or -q / (2 sigma^2).
        slope = np.zeros(3)
        for axis, q, d in zip(axes, rss, slopes, strict=True):
            known = axis.noise.value
            slope += d * (len(z) / (2 * q) if known is None else 1 / (2 * known**2))
        return -top, slope * sd

    found = minimize(objective, np.zeros(3), jac=True, method="BFGS", options={"gtol": 1e-6})
    return mean + found.x * sd, -float(found.fun)


def profile(axis: MovingAxis, position: Array) -> tuple[float, Array]:
    """Weighted sum of squares at the best coefficients, and its slope in the position.

    The slope is -2 e' (dX/dposition) b, e the residuals: those in the coefficients vanish
    (Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413).
    """
    step = 1e-30
    moved = axis.design(position + step * 1j * np.eye(3))
    design, slopes = moved[0].real, moved.imag / step
    sd = np.ones(len(design)) if axis.data.sd is None else axis.data.sd
    b, *_ = np.linalg.lstsq(design / sd[:, None], axis.data.t / sd, rcond=None)
    e = (axis.data.t - design @ b) / sd
    return float(e @ e), np.array([-2 * e @ ((dx @ b) / sd) for dx in slopes])


def position_mode(model: FreePositionModel) -> Mode:
    """Laplace approximation of the position's posterior, by Newton steps.

    The steps of the differences come from the slopes of the sums of squares; some forty
    evaluations where a search that knows nothing takes hundreds.
    """
    step = np.zeros(3)
    for axis in model.axes:
        rss, _ = profile(axis, model.start)
        n, known = len(axis.world), axis.noise.value
        sigma2 = rss / n if known is None else known**2
        step += np.array([_curvature(axis, model.start, e) for e in np.eye(3)]) / sigma2
    step = 0.3 / np.sqrt(step + model.prior.sd**-2) / model.prior.sd
    theta = np.zeros(3)
    for _ in range(NEWTON):
        centre, slope, hessian = _differences(model, theta, step)
        values, vectors = np.linalg.eigh(hessian)
        values = np.maximum(values, 1e-2)
        move = vectors @ (vectors.T @ slope / values) * step
        root = cholesky((step[:, None] * vectors / values) @ (step[:, None] * vectors).T)
        if float(model.log_prob((theta + move)[None])[0]) < centre:
            break
        theta = theta + move
    return Mode(theta, float(model.log_prob(theta[None])[0]), root)


def _curvature(axis: MovingAxis, position: Array, direction: Array) -> float:
    """Sum of squares that a unit step of the position adds, the coefficients following."""
    moved = axis.design(position + 1e-30j * direction[None])[0]
    sd = np.ones(len(moved)) if axis.data.sd is None else axis.data.sd
    design, slope = moved.real / sd[:, None], moved.imag * 1e30 / sd[:, None]
    b, *_ = np.linalg.lstsq(design, axis.data.t / sd, rcond=None)
    change = slope @ b
    c, *_ = np.linalg.lstsq(design, change, rcond=None)
    return float(((change - design @ c) ** 2).sum())


def _differences(model: FreePositionModel, theta: Array, step: Array) -> tuple[float, Array, Array]:
    """Log density, its slope and minus its curvature, per step."""
    unit = np.diag(step)
    i, j = np.triu_indices(3, 1)
    corners = [a * unit[i] + b * unit[j] for a in (1, -1) for b in (1, -1)]
    values = model.log_prob(theta + np.concatenate([np.zeros((1, 3)), unit, -unit, *corners]))
    centre, up, down = values[0], values[1:4], values[4:7]
    pp, pm, mp, mm = values[7:].reshape(4, 3)
    hessian = np.diag(2 * centre - up - down)
    hessian[i, j] = hessian[j, i] = (pm + mp - pp - mm) / 4
    return float(centre), (up - down) / 2, np.nan_to_num(hessian)
