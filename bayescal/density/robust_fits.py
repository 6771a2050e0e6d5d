r"""Where to search for modes under noise that forgives bad points.

A group of points may be bad for one camera and good for another, and then each camera is a
mode: for a pinhole on the thesis data four readings of r at the edge give a second one, which
holds a tenth of the posterior. So fits start from random subsets of the points and go on as
expectation-maximisation does, by the weights that the noise model itself gives (Lange, Little &
Taylor 1989, J. Am. Stat. Assoc. 84, 881), the pixels taken for linear functions of the
coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel

TRIALS, STEPS = 120, 40
SHARE = 3  # one in so many points in every other subset; in the rest just enough
POINTS = 500  # of more points a random sample is searched
SIGMAS = 20  # tried between the bounds of an inferred sigma
SETTLED, SAME = 1e-2, 0.5  # standard deviations


@dataclass(frozen=True, eq=False)
class RobustFit:
    """A fit that weighs its points.

    Attributes
    ----------
    x : Array
        Coordinates, from where the pixels are linearised, ``(dimension,)``.
    log_sigma : Array
        Of r and of c, ``(2,)``.
    eta : Array
        Coordinates of the noise model of r and of c, ``(2, noise.dimension)``.
    """

    x: Array
    log_sigma: Array
    eta: Array


@dataclass(frozen=True, eq=False)
class LinearPixels:
    """Pixels of both axes as linear functions of coordinates x with a normal prior.

    Attributes
    ----------
    residuals : Array
        Measured less predicted at x = 0, ``(2, n_points)``, px.
    slopes : Array
        Of the predicted pixels, ``(2, n_points, dimension)``, px.
    prior_slope : Array
        Of the log prior at x = 0, ``(dimension,)``.
    prior_precision : Array
        ``(dimension, dimension)``.
    deviations : Array
        Each value's known deviation, else 1: ``(2, n_points)``, px.
    levels : tuple of NoiseLevel
        Of r and of c.
    """

    residuals: Array
    slopes: Array
    prior_slope: Array
    prior_precision: Array
    deviations: Array
    levels: tuple[NoiseLevel, NoiseLevel]

    def taken(self, kept: NDArray[np.intp]) -> LinearPixels:
        """Give some of the points, standing for all: the prior counts for less."""
        share = len(kept) / len(self.residuals[0])
        return LinearPixels(
            self.residuals[:, kept],
            self.slopes[:, kept],
            share * self.prior_slope,
            share * self.prior_precision,
            self.deviations[:, kept],
            self.levels,
        )

    def normal(self, precision: Array) -> tuple[Array, Array]:
        """Slope at x = 0 and precision of the log posterior; `precision` ``(2, n)``, px^-2."""
        flat = self.slopes.reshape(-1, self.slopes.shape[2])
        weighted = flat * precision.ravel()[:, None]
        slope = weighted.T @ self.residuals.ravel() + self.prior_slope
        return slope, weighted.T @ flat + self.prior_precision

    def solve(self, precision: Array) -> Array:
        """Most probable x, ``(dimension,)``."""
        slope, gram = self.normal(precision)
        return np.asarray(np.linalg.lstsq(gram, slope, rcond=None)[0])

    @cached_property
    def plain(self) -> Array:
        """Precision of each value at the sigmas of the residuals at x = 0, ``(2, n)``, px^-2."""
        rss = ((self.residuals / self.deviations) ** 2).sum(axis=1).tolist()
        n = len(self.residuals[0])
        sigma = np.array([v.bounded(q, n) for v, q in zip(self.levels, rss, strict=True)])
        return np.asarray((sigma[:, None] * self.deviations) ** -2.0)

    @cached_property
    def _gram(self) -> Array:
        return self.normal(self.plain)[1]

    def apart(self, x: Array, other: Array) -> float:
        """Distance of two fits in standard deviations at the plain precision."""
        gap = x - other
        return math.sqrt(max(float(gap @ self._gram @ gap), 0.0))


def robust_fits(pixels: LinearPixels, noise: NoiseModel) -> list[RobustFit]:
    """Fits from random subsets that end at different places.

    Parameters
    ----------
    pixels : LinearPixels
        Linearised near the fit of least squares.
    noise : NoiseModel
        Of each axis on its own.
    """
    rng = np.random.default_rng(0)
    n = len(pixels.residuals[0])
    if n > POINTS:
        pixels, n = pixels.taken(np.sort(rng.permutation(n)[:POINTS])), POINTS
    least = min((len(pixels.prior_slope) + 1) // 2, n)
    found: list[RobustFit] = []
    for trial in range(TRIALS):
        # The fewer, the sooner all are of one group; the more, the nearer the fit begins.
        size = least if trial % 2 else max(n // SHARE, least)
        chosen = np.isin(np.arange(n), rng.permutation(n)[:size])
        fit = _climbed(pixels, noise, pixels.solve(pixels.plain * chosen * (n / size)))
        if all(pixels.apart(fit.x, other.x) > SAME for other in found):
            found.append(fit)
    return found


def _climbed(pixels: LinearPixels, noise: NoiseModel, x: Array) -> RobustFit:
    """Weigh the points and fit anew until the fit settles."""
    for _ in range(STEPS):
        residuals = pixels.residuals - pixels.slopes @ x
        parts = [_likely_noise(pixels, i, residuals[i], noise) for i in (0, 1)]
        precision = np.empty_like(residuals)
        for i, (log_sigma, eta) in enumerate(parts):
            weight = noise.weight(residuals[i : i + 1], log_sigma, eta, pixels.deviations[i])
            precision[i] = weight[0] * (np.exp(log_sigma) * pixels.deviations[i]) ** -2.0
        before, x = x, pixels.solve(precision)
        if pixels.apart(x, before) < SETTLED:
            break
    return RobustFit(x, *(np.concatenate(values) for values in zip(*parts, strict=True)))


def _likely_noise(
    pixels: LinearPixels, axis: int, residual: Array, noise: NoiseModel
) -> tuple[Array, Array]:
    """Most probable sigma of a grid with one of the noise model's starts, ``(1,)``, ``(1, q)``."""
    level, starts = pixels.levels[axis], noise.starts()
    if level.value is not None:
        grid = np.array([math.log(level.value)])
    else:
        grid = np.linspace(*level.log_bounds, SIGMAS)
    log_sigma, eta = np.repeat(grid, len(starts)), np.tile(starts, (len(grid), 1))
    tried = np.broadcast_to(residual, (len(log_sigma), len(residual)))
    density = noise.log_density(tried, log_sigma, eta, pixels.deviations[axis]).sum(axis=1)
    best = int(np.argmax(density + noise.log_prior(eta)))
    return log_sigma[best : best + 1], eta[best : best + 1]
