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
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy.special import gammaln

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.calibration.model.observations import Observations
from bayescal.calibration.model.strengths import Strengths
from bayescal.prior.strength import Strength

SIGMA_BOUNDS = (0.01, 10.0)  # px
REACH = 50.0  # diagonals: positions of the target are uniform within it
# Rotations are uniform (8 pi^2 is their volume), positions within a ball.
LOG_POSE = -math.log(8 * math.pi**2) - math.log(4 / 3 * math.pi * REACH**3)
NEGLIGIBLE = 16.0  # nat below the best: combinations of strengths that are dropped after a step
LIKELY = 9.0  # nat below the best: those that are enough where views are left out
ENOUGH = 5.0  # those that are enough where modes are sought and error models compared
UNTOLD = 1e-60  # precision of a coordinate of which points tell nothing
MANY = 64  # combinations of which some are worth dropping
STEPS = 4  # of sigma and mode in turn at most: it falls by about a thousand a step near the mode
SETTLED = 1e-6  # relative change of sigma^2 that needs no further step


@dataclass(frozen=True)
class Level:
    """What is known of sigma: a value in px, or None where it is inferred."""

    sigma: float | None = None

    def log_density(self, squares: Array, nu: int) -> Array:
        """Log density of residuals by their sum of squares ``(n,)``, sigma integrated out."""
        if self.sigma is None:
            low, high = (math.log(b) for b in SIGMA_BOUNDS)
            return Strength((low, high), nu).log_density(squares)
        constant = -nu / 2 * LOG_2PI - nu * math.log(self.sigma)
        return np.asarray(constant - squares / (2 * self.sigma**2))

    def variance(self, squares: Array, nu: int | IntArray) -> Array:
        """Most probable sigma^2, px^2, within the bounds."""
        if self.sigma is not None:
            return np.full(np.shape(squares), self.sigma**2)
        return np.clip(squares / nu, SIGMA_BOUNDS[0] ** 2, SIGMA_BOUNDS[1] ** 2)


INFERRED = Level()


def degrees(data: Observations) -> int:
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

    log_mass: Array
    step: Array
    covariances: Array
    kept: IntArray

    @cached_property
    def log_evidence(self) -> float:
        """Of the model, nat."""
        return float(np.logaddexp.reduce(self.log_mass))

    def likely(self, below: float = LIKELY) -> IntArray:
        """Which of the combinations offered are no further below the best, nat."""
        return self.kept[self.log_mass > self.log_mass.max() - below]

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


@dataclass(frozen=True, eq=False)
class Forms:
    """Sums of squares, quadratic in the step of x: of several error models or sets of views.

    Attributes
    ----------
    precision, slope, squares : Array
        As of `Reduced`, ``(n, d, d)``, ``(n, d)`` and ``(n,)``.
    nu : IntArray
        Degrees of freedom, ``(n,)``.
    constant : Array
        What does not depend on the lens, nat, ``(n,)``.
    """

    precision: Array
    slope: Array
    squares: Array
    nu: IntArray
    constant: Array

    @classmethod
    def of(cls, gram: Array, nu: IntArray, constant: Array) -> Forms:
        """Take them from Gram matrices of derivatives and residuals, ``(n, d + 1, d + 1)``."""
        precision = gram[:, :-1, :-1]
        return cls(semidefinite(precision), gram[:, :-1, -1], gram[:, -1, -1], nu, constant)


def laplace(forms: Forms, x: Array, prior: Strengths, level: Level = INFERRED) -> list[Laplace]:
    """Integrate each form over a lens model's coordinates, sigma and strengths.

    Parameters
    ----------
    x : Array
        Where residuals were linearised, ``(d,)``.
    """
    n, d = forms.slope.shape
    peak = np.einsum("nii->ni", forms.precision)
    unit = 1 / np.sqrt(np.where(peak > UNTOLD, peak, 1.0))
    rows = _Rows.of(forms, x, prior, unit)
    variance = level.variance(rows.start, rows.nu)
    for turn in range(STEPS):
        curvature = rows.curvature(variance)
        step, uphill, squares = rows.modes(curvature, variance)
        before, variance = variance, level.variance(squares, rows.nu)
        if turn == 0 and len(variance) > MANY * n:
            rough = rows.height(level, step, squares) - np.linalg.slogdet(curvature)[1] / 2
            best = np.maximum.reduceat(rough, np.searchsorted(rows.form, np.arange(n)))
            some = np.flatnonzero(rough > best[rows.form] - NEGLIGIBLE)
            rows = rows.only(some)
            step, uphill, squares, before, variance = (
                v[some] for v in (step, uphill, squares, before, variance)
            )
        if np.abs(variance / before - 1).max() < SETTLED:
            break
    curvature = rows.curvature(variance)
    covariance, log_det = np.linalg.inv(curvature), np.linalg.slogdet(curvature)[1]
    log_mass = rows.height(level, step, squares) + forms.constant[rows.form]
    if level.sigma is None:
        # -2 ln p = nu ln S bends less than S / sigma^2 does, by a matrix of rank one, where that
        # leaves it positive; the integral over a t has the rest in its gamma functions.
        turned, nu = (covariance @ uphill[..., None])[..., 0], rows.nu
        less = 2 / (nu * variance**2)
        left = 1 - less * (turned * uphill).sum(axis=1)
        less, left = np.where(left > 0, less, 0.0), np.where(left > 0, left, 1.0)
        covariance += (less / left)[:, None, None] * turned[:, :, None] * turned[:, None, :]
        log_det += np.log(left)
        share = np.clip((covariance * rows.precision).sum(axis=(1, 2)) / variance, 0, d)
        log_mass += gammaln((nu - share) / 2) - gammaln(nu / 2) + share / 2 * np.log(nu / 2)
    log_mass += d / 2 * LOG_2PI - log_det / 2 + np.log(unit).sum(axis=1)[rows.form]
    step = step * unit[rows.form]
    covariance *= (unit[:, :, None] * unit[:, None, :])[rows.form]
    ends = np.searchsorted(rows.form, np.arange(n + 1))
    parts = map(slice, ends[:-1], ends[1:])
    return [Laplace(log_mass[i], step[i], covariance[i], rows.kept[i]) for i in parts]


@dataclass(frozen=True, eq=False)
class _Rows:
    """Combinations of strengths under forms, one a row; coordinates scaled to like precision."""

    form: IntArray
    kept: IntArray
    precision: Array
    slope: Array
    start: Array
    nu: IntArray
    towards: Array
    strength: Array
    log_prior: Array

    @classmethod
    def of(cls, forms: Forms, x: Array, prior: Strengths, unit: Array) -> _Rows:
        """Put every combination under every form."""
        form, kept = np.divmod(np.arange(len(unit) * len(prior.log_weight)), len(prior.log_weight))
        return cls(
            form,
            kept,
            (forms.precision * unit[:, :, None] * unit[:, None, :])[form],
            (forms.slope * unit)[form],
            forms.squares[form],
            forms.nu[form],
            ((prior.mean - x) / unit)[form],
            prior.precision[kept] * unit[form] ** 2,
            (prior.log_weight + prior.log_density)[kept],
        )

    def only(self, some: IntArray) -> _Rows:
        """Keep some."""
        return _Rows(*(getattr(self, each.name)[some] for each in fields(self)))

    def curvature(self, variance: Array) -> Array:
        """Of S / (2 sigma^2) and the prior, ``(n_rows, d, d)``."""
        out = self.precision / variance[:, None, None]
        np.einsum("rii->ri", out)[...] += self.strength
        return np.asarray(out)

    def modes(self, curvature: Array, variance: Array) -> tuple[Array, Array, Array]:
        """Step to the mode, half the slope of S there, and S."""
        pull = self.slope / variance[:, None] + self.strength * self.towards
        step = np.linalg.solve(curvature, pull[..., None])[..., 0]
        uphill = (self.precision @ step[..., None])[..., 0] - self.slope
        squares = self.start + ((uphill - self.slope) * step).sum(axis=1)
        return step, uphill, np.maximum(squares, np.finfo(float).tiny)

    def height(self, level: Level, step: Array, squares: Array) -> Array:
        """Log density of data and lens at the modes, times the combination's share."""
        out = self.log_prior - (self.strength * (step - self.towards) ** 2).sum(axis=1) / 2
        for nu in np.unique(self.nu):
            out[self.nu == nu] += level.log_density(squares[self.nu == nu], int(nu))
        return np.asarray(out)


def constant(data: Observations, log_det: Array, log_det_noise: Array) -> Array:
    """Sum what does not depend on the lens: weights, determinants and the poses' prior, nat."""
    return data.log_weight - (log_det + log_det_noise) / 2 + data.n_views * LOG_POSE


def semidefinite(matrices: Array) -> Array:
    """Take from precisions ``(n, d, d)`` what rounding made negative.

    Eliminating poses leaves differences: coefficients that hardly differ in what they do are
    told apart by nothing but rounding.
    """
    try:
        np.linalg.cholesky(matrices)  # far sooner than eigenvalues
    except np.linalg.LinAlgError:
        diagonal = np.einsum("nii->ni", matrices)
        scale = np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(matrices / (scale[:, :, None] * scale[:, None, :]))
        rooted = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :] * scale[:, :, None]
        mended = rooted @ rooted.swapaxes(1, 2)
        return np.where((values[:, 0] < 0)[:, None, None], mended, matrices)
    return matrices
