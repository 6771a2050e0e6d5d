"""Least squares over a lens and all poses: Levenberg-Marquardt with the poses eliminated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.reduction import reduce
from bayescal.calibration.fitting.stacking import Poses, Stacked, stacked
from bayescal.calibration.model.error_model import INDEPENDENT
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations

MOST_STEPS = 200
SETTLED = 1e-11  # relative fall of the sum of squares
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-15, 1e12
RAISED, LOWERED = 3.0, 5.0  # by so much: along a curved valley tens end where steps are short


@dataclass(frozen=True, eq=False)
class Fit:
    """A lens and poses at the least sum of squares under independent noise.

    Attributes
    ----------
    x : Array
        Coordinates of the lens, ``(dimension,)``.
    sum_of_squares : float
        Weighted, px^2; infinite where a point can't be seen.
    """

    x: Array
    poses: Poses
    sum_of_squares: float
    converged: bool


def rms(data: Observations, sum_of_squares: float) -> float:
    """Root mean square distance of points from their predictions, px."""
    return math.sqrt(sum_of_squares / data.n_points)


def cost(stack: Stacked) -> float:
    """Sum of squared weighted residuals; infinite where a point can't be seen."""
    with np.errstate(over="ignore"):
        total = float((stack.residuals**2).sum())
    return total if stack.possible and math.isfinite(total) else math.inf


def least_squares(
    model: LensModel, data: Observations, x: Array, poses: Poses, most_steps: int = MOST_STEPS
) -> Fit:
    """Climb down from a lens and poses.

    Parameters
    ----------
    x : Array
        Where to start, ``(dimension,)``.

    Returns
    -------
    Fit
        Marquardt 1963, J. SIAM 11, 431; the damping acts on poses and lens alike.
    """
    stack = stacked(model, data, x, poses)
    value, damping, converged = cost(stack), FIRST_DAMPING, False
    if not math.isfinite(value):
        return Fit(x, poses, math.inf, False)
    for _ in range(most_steps):
        while damping < MOST_DAMPING:
            step, moves = _step(stack, data, damping)
            trial = x + step, poses.moved(moves)
            # Most trials are lower: the next step takes the derivatives found with the residuals.
            found = stacked(model, data, *trial)
            new = cost(found)
            if new <= value:
                break
            damping = max(RAISED * damping, 1e-9)
        else:
            converged = True  # nothing nearby is lower
            break
        (x, poses), stack, gain = trial, found, value - new
        value, damping = new, max(damping / LOWERED, LEAST_DAMPING)
        if gain <= SETTLED * value:
            converged = True
            break
    return Fit(x, poses, value, converged)


def _step(stack: Stacked, data: Observations, damping: float) -> tuple[Array, Array]:
    views = reduce(stack, data, INDEPENDENT, offsets=False, damping=damping)
    gram = views.gram.sum(axis=0)
    precision, slope = gram[:-1, :-1], gram[:-1, -1]
    scale = 1 / np.sqrt(np.maximum(np.diag(precision), np.finfo(float).tiny))
    scaled = precision * scale * scale[:, None] + damping * np.eye(len(scale))
    try:
        step = scale * np.linalg.solve(scaled, slope * scale)
    except np.linalg.LinAlgError:
        step = scale * np.linalg.lstsq(scaled, slope * scale)[0]
    return step, views.pose_step[..., -1] - views.pose_step[..., :-1] @ step


def carried(old: LensModel, x: Array, new: LensModel) -> Array:
    """Coordinates of a lens in those of another: terms of the same name keep their values."""
    intrinsics, k, bow = old.physical(x)
    known = dict(zip(old.lens.names, k, strict=True))
    start = zip(new.lens.names, new.lens.start, strict=True)
    taken = np.array([known.get(name, value) for name, value in start])
    return new.coordinates(intrinsics, taken, bow if old.bow else None)
