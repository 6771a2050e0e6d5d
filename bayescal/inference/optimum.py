"""Modes of a log density, and the normal that fits each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import LOG_2PI, Array
from bayescal.inference.t_mixture import cholesky

LogDensity = Callable[[Array], Array]

# Modes closer than this in units of their own spread are the same.
SAME = 0.5
# Modes lower than the best by more than this hold nothing that matters, nat.
NEGLIGIBLE = 30.0
# The log density should fall by about this over the steps of the finite differences.
DROP = 0.5
SCALES = 10.0 ** np.linspace(-8, 3, 34)
# Deviations along any direction are at most this many of the steps.
WIDEST = 30.0
LOWEST = -1e100


@dataclass(frozen=True, eq=False)
class Mode:
    """A local maximum with the normal that has its curvature (Laplace).

    Attributes
    ----------
    theta : Array
        ``(dimension,)``.
    value : float
        Log density.
    root : Array
        Lower Cholesky root of the inverse curvature, ``(dimension, dimension)``.
    """

    theta: Array
    value: float
    root: Array

    @property
    def log_mass(self) -> float:
        """Log integral of the density in the Laplace approximation."""
        d = len(self.theta)
        return self.value + d / 2 * LOG_2PI + float(np.log(np.diag(self.root)).sum())


def find_modes(log_density: LogDensity, starts: Array) -> tuple[Mode, ...]:
    """Climb from every start; keep the distinct modes that matter, the highest first.

    Parameters
    ----------
    log_density : callable
        From ``(n, dimension)`` to ``(n,)``; may be -inf.
    starts : Array
        ``(n_starts, dimension)``.

    Returns
    -------
    tuple of Mode
        Empty where the density is 0 at every start.
    """
    found: list[Mode] = []
    for start in starts:
        if not math.isfinite(float(log_density(start[None])[0])):
            continue
        mode = climb(log_density, start)
        same = (np.abs(np.linalg.solve(m.root, mode.theta - m.theta)).max() < SAME for m in found)
        if not any(same):
            found.append(mode)
    found.sort(key=lambda m: -m.value)
    return tuple(m for m in found if m.log_mass > max(o.log_mass for o in found) - NEGLIGIBLE)


def climb(log_density: LogDensity, start: Array) -> Mode:
    """Climb in coordinates scaled to the density's own width, which are then renewed."""
    from scipy.optimize import minimize  # where nothing is climbed, a sixth of a second less

    theta, root = start, np.diag(_steps(log_density, start))
    for _ in range(3):
        centre, factor = theta, root

        def value_and_slope(
            u: Array, centre: Array = centre, factor: Array = factor
        ) -> tuple[float, Array]:
            h = 1e-4
            around = np.concatenate([u[None], u + h * np.eye(len(u)), u - h * np.eye(len(u))])
            values = np.maximum(log_density(centre + around @ factor.T), LOWEST)
            d = len(u)
            return -float(values[0]), -(values[1 : d + 1] - values[d + 1 :]) / (2 * h)

        result = minimize(
            value_and_slope, np.zeros(len(theta)), jac=True, method="BFGS",
            options={"gtol": 1e-4, "maxiter": 200},
        )  # fmt: skip
        theta = centre + factor @ result.x
        root = _curvature_root(log_density, theta)
        if np.abs(np.linalg.solve(root, theta - centre)).max() < 1e-3:
            break
    return Mode(theta, float(log_density(theta[None])[0]), root)


def _steps(log_density: LogDensity, theta: Array) -> Array:
    """Step of each coordinate over which the log density changes by about DROP."""
    d = len(theta)
    ladder = SCALES[:, None, None] * np.maximum(np.abs(theta), 1.0) * np.eye(d)
    both = np.stack([theta + ladder, theta - ladder])
    values = log_density(both.reshape(-1, d)).reshape(2, len(SCALES), d)
    # The smaller change of the two sides: the other may lie beyond the support's edge.
    change = np.abs(values - float(log_density(theta[None])[0])).min(axis=0)
    index = np.array([np.searchsorted(np.maximum.accumulate(c), DROP) for c in change.T])
    at = np.minimum(index, len(SCALES) - 1)
    return np.asarray(ladder[at, np.arange(d), np.arange(d)])


def differences(
    log_density: LogDensity, theta: Array, unit: Array
) -> tuple[float, Array, Array, Array]:
    """Values at a place, a step up and a step down, and minus mixed second differences.

    Steps are the rows of `unit`, ``(d, d)``; mixed ones are of each pair of them, in the order of
    ``numpy.triu_indices``.
    """
    d = len(theta)
    i, j = np.triu_indices(d, 1)
    corners = [a * unit[i] + b * unit[j] for a in (1, -1) for b in (1, -1)]
    values = log_density(theta + np.concatenate([np.zeros((1, d)), unit, -unit, *corners]))
    pp, pm, mp, mm = values[2 * d + 1 :].reshape(4, -1)
    with np.errstate(invalid="ignore"):
        mixed = (pm + mp - pp - mm) / 4
    return float(values[0]), values[1 : d + 1], values[d + 1 : 2 * d + 1], mixed


def ascend(
    height: Callable[[Array], float],
    step: Callable[[Array], Array],
    start: Array,
    *,
    most: int,
    halvings: int,
    settled: float,
) -> tuple[Array, float]:
    """Climb by steps that are halved until they gain; where that ends, and how high.

    Parameters
    ----------
    height : callable
        Of a place; -inf where it is none.
    step : callable
        From a place.
    most, halvings : int
        Steps, and trials of each.
    settled : float
        Gain of a step below which it ends.
    """
    place, reached = start, height(start)
    for _ in range(most):
        move, gain = step(place), 0.0
        for halving in range(halvings):
            trial = place + move * 0.5**halving
            found = height(trial)
            if found > reached:
                place, gain, reached = trial, found - reached, found
                break
        if gain < settled:
            break
    return place, reached


def _curvature_root(log_density: LogDensity, theta: Array) -> Array:
    """Root of the inverse of the negative Hessian, by central differences."""
    step = _steps(log_density, theta)
    centre, up, down, mixed = differences(log_density, theta, np.diag(step))
    # Beyond the support's edge the other side is mirrored; a corner there says nothing.
    up, down = np.where(np.isfinite(up), up, down), np.where(np.isfinite(down), down, up)
    second = np.where(np.isfinite(up), 2 * centre - up - down, 0.0)
    hessian = np.diag(second)  # of minus the log density, per step^2
    i, j = np.triu_indices(len(theta), 1)
    hessian[i, j] = hessian[j, i] = np.where(np.isfinite(mixed), mixed, 0.0)
    eigenvalues, vectors = np.linalg.eigh(hessian)
    widths = 1 / np.sqrt(np.maximum(eigenvalues, WIDEST**-2))
    scaled = vectors * np.minimum(widths, WIDEST)
    return cholesky(step[:, None] * (scaled @ scaled.T) * step)
