r"""Evidence of a lens model by linear algebra, where residuals are linear in the lens.

What is left of the data is a quadratic S in the lens's coordinates x (`reduction`). With poses
and offsets integrated by Laplace and ln sigma uniform over its bounds,

    p(data | x) = p(poses)^V |R|^(-1/2) |H|^(-1/2) \int (2 pi sigma^2)^(-nu / 2)
                  exp(-S(x) / (2 sigma^2)) d ln sigma / ln(high / low),     nu = 2N - 6V,

H the precision of poses and offsets. At each combination of strengths the prior is normal, and
x is integrated by Laplace about the mode of S^(-nu/2) times the prior.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import gammaln, logsumexp

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.calibration.reduction import Reduced
from bayescal.calibration.strengths import Strengths
from bayescal.prior.strength import Strength

SIGMA_BOUNDS = (0.01, 10.0)  # px
REACH = 50.0  # diagonals: positions of the target are uniform within it
# Rotations are uniform (8 pi^2 is their volume), positions within a ball.
LOG_POSE = -math.log(8 * math.pi**2) - math.log(4 / 3 * math.pi * REACH**3)
NEGLIGIBLE = 16.0  # nat below the best: combinations of strengths that are dropped after a step
LIKELY = 9.0  # nat below the best: those that are enough where evidences are compared
STEPS = 4  # of sigma and mode in turn at most: it falls by about a thousand a step near the mode
SETTLED = 1e-6  # relative change of sigma^2 that needs no further step


@dataclass(frozen=True)
class Level:
    """What is known of sigma: a value in px, or None where it is inferred."""

    sigma: float | None = None

    def log_density(self, squares: Array, nu: int) -> Array:
        """Log density of residuals by their sum of squares, sigma integrated out."""
        if self.sigma is None:
            low, high = (math.log(b) for b in SIGMA_BOUNDS)
            flat = Strength((low, high), nu).log_density(np.ravel(squares))
            return np.asarray(flat).reshape(np.shape(squares))
        constant = -nu / 2 * LOG_2PI - nu * math.log(self.sigma)
        return np.asarray(constant - squares / (2 * self.sigma**2))

    def variance(self, squares: Array, nu: int) -> Array:
        """Most probable sigma^2, px^2, within the bounds."""
        if self.sigma is not None:
            return np.full(np.shape(squares), self.sigma**2)
        return np.clip(squares / nu, SIGMA_BOUNDS[0] ** 2, SIGMA_BOUNDS[1] ** 2)


INFERRED = Level()


class Seen(Protocol):
    """What of observations an evidence needs beside their normal equations."""

    @property
    def n_points(self) -> int:
        """Points in all views."""

    @property
    def n_views(self) -> int:
        """Views."""

    @property
    def log_weight(self) -> float:
        """Sum of the logs of the weights."""


def degrees(data: Seen) -> int:
    """Values less six for each pose: what is left to tell of sigma and the lens."""
    return 2 * data.n_points - 6 * data.n_views


@dataclass(frozen=True, eq=False)
class Laplace:
    """The posterior as a mixture of normals, one for each combination of strengths.

    Attributes
    ----------
    log_mass : Array
        Log evidence of each combination that matters times its share, ``(n_combinations,)``.
    step : Array
        Mode of each, from where residuals were linearised, ``(n_combinations, d)``.
    covariances : Array
        ``(n_combinations, d, d)``.
    kept : IntArray
        Which of the combinations offered these are, ``(n_combinations,)``.
    """

    log_evidence: float
    log_mass: Array
    step: Array
    covariances: Array
    kept: IntArray

    @property
    def likely(self) -> IntArray:
        """Which of the combinations offered hold all but a negligible share."""
        return self.kept[self.log_mass > self.log_mass.max() - LIKELY]

    @property
    def mean(self) -> Array:
        """Mean of the step, ``(d,)``."""
        return np.asarray(self._shares @ self.step)

    @property
    def _shares(self) -> Array:
        shares = np.exp(self.log_mass - self.log_mass.max())
        return np.asarray(shares / shares.sum())

    @property
    def covariance(self) -> Array:
        """Covariance of the coordinates, ``(d, d)``."""
        shares, gap = self._shares, self.step - self.mean
        kept = shares > 1e-6
        within = np.einsum("c,cij->ij", shares[kept], self.covariances[kept])
        return np.asarray(within + (gap * shares[:, None]).T @ gap)


def laplace(
    reduced: Reduced,
    x: Array,
    data: Seen,
    prior: Strengths,
    log_det_noise: float,
    level: Level = INFERRED,
) -> Laplace:
    """Integrate over a lens model's coordinates, sigma and strengths.

    Parameters
    ----------
    x : Array
        Where residuals were linearised, ``(d,)``.
    log_det_noise : float
        Log determinant of the noise's covariance over sigma^2.
    """
    nu, d = degrees(data), len(x)
    a, towards = semidefinite(reduced.precision), prior.mean - x
    kept = np.arange(len(prior.log_weight))
    variance = level.variance(np.full(len(kept), reduced.sum_of_squares), nu)
    for turn in range(STEPS):
        precision = a / variance[:, None, None] + _diagonal(prior.precision)
        pull = prior.precision * towards
        step = _solve(precision, reduced.slope / variance[:, None] + pull)
        uphill = step @ a - reduced.slope  # half the slope of S
        squares = reduced.sum_of_squares + ((uphill - reduced.slope) * step).sum(axis=1)
        squares = np.maximum(squares, np.finfo(float).tiny)
        before, variance = variance, level.variance(squares, nu)
        if turn == 0 and len(variance) > 1:
            fit = _fit(level, squares, nu, prior, step - towards)
            rough = fit - np.linalg.slogdet(precision)[1] / 2
            kept = np.flatnonzero(rough > rough.max() - NEGLIGIBLE)
            prior = prior.only(kept)
            step, uphill, squares, before, variance = (
                v[kept] for v in (step, uphill, squares, before, variance)
            )
        if np.abs(variance / before - 1).max() < SETTLED:
            break
    curvature = a / variance[:, None, None] + _diagonal(prior.precision)
    ratio = np.zeros(len(squares))
    if level.sigma is None:
        # -2 ln p = nu ln S bends less than S / sigma^2 does, which the integral over a t has
        # in its gamma functions.
        bent = curvature - 2 / (nu * variance[:, None, None] ** 2) * (
            uphill[:, :, None] * uphill[:, None, :]
        )
        curvature = _positive(bent, curvature)
    covariance = np.linalg.inv(curvature)
    if level.sigma is None:
        share = np.clip(np.einsum("cij,ij->c", covariance, a) / variance, 0, d)
        ratio = gammaln((nu - share) / 2) - gammaln(nu / 2) + share / 2 * math.log(nu / 2)
    log_mass = _fit(level, squares, nu, prior, step - towards) + ratio
    log_mass += d / 2 * LOG_2PI - 0.5 * np.linalg.slogdet(curvature)[1]
    log_mass = log_mass + constant(data, reduced.log_det, log_det_noise)
    return Laplace(float(logsumexp(log_mass)), log_mass, step, covariance, kept)


def _fit(level: Level, squares: Array, nu: int, prior: Strengths, deviation: Array) -> Array:
    """Log density of data and lens at the mode of each combination, times its share."""
    away = 0.5 * (prior.precision * deviation**2).sum(axis=1)
    found = level.log_density(squares, nu) + prior.log_weight + prior.log_density - away
    return np.asarray(found)


def constant(data: Seen, log_det: float, log_det_noise: float) -> float:
    """Sum what does not depend on the lens: weights, determinants and the poses' prior, nat."""
    return data.log_weight - (log_det + log_det_noise) / 2 + data.n_views * LOG_POSE


def semidefinite(matrix: Array) -> Array:
    """Take from a precision ``(d, d)`` what rounding made negative.

    Eliminating poses leaves differences: coefficients that hardly differ in what they do are
    told apart by nothing but rounding.
    """
    try:
        np.linalg.cholesky(matrix)  # far sooner than eigenvalues
    except np.linalg.LinAlgError:
        scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
        rooted = vectors * np.sqrt(np.maximum(values, 0.0)) * scale[:, None]
        return np.asarray(rooted @ rooted.T)
    return matrix


def _positive(wanted: Array, instead: Array) -> Array:
    """Take matrices ``(n, d, d)`` where they are positive definite, else those `instead`."""
    try:
        np.linalg.cholesky(wanted)  # far sooner than eigenvalues
    except np.linalg.LinAlgError:
        sound = np.linalg.eigvalsh(wanted)[:, 0] > 0
        return np.where(sound[:, None, None], wanted, instead)
    return wanted


def _diagonal(rows: Array) -> Array:
    return np.asarray(rows[:, :, None] * np.eye(rows.shape[1]))


def _solve(matrices: Array, vectors: Array) -> Array:
    """Solve scaled systems, ``(n, d, d)`` and ``(n, d)``."""
    scale = 1 / np.sqrt(np.diagonal(matrices, axis1=1, axis2=2))
    scaled = matrices * scale[:, :, None] * scale[:, None, :]
    return np.asarray(np.linalg.solve(scaled, (vectors * scale)[..., None])[..., 0] * scale)
