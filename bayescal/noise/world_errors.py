r"""Gaussian pixel noise of unknown sigma beside known errors of the world coordinates.

A residual is N(0, sigma^2 s_i^2 + (f'(x_i) sd(x_i))^2): the second part is what the world's
error is worth in pixels, by the slope of the curve fitted with *that* sigma (Orear 1982, Am. J.
Phys. 50, 912). The slope is found on a grid of ln sigma and interpolated in between.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.noise.gaussian import Gaussian, log_normal
from bayescal.noise.model import NoiseModel, scales


@dataclass(frozen=True, eq=False)
class WorldErrors(Gaussian):
    """Residuals are N(0, sigma^2 + v_i(sigma)); nothing else to infer.

    Attributes
    ----------
    log_sigma : Array
        Grid of ln sigma, ascending and evenly spaced, ``(n_grid,)``.
    variance : Array
        v_i on it, ``(n_grid, n_points)``, px^2.
    """

    log_sigma: Array
    variance: Array
    name: ClassVar[str] = "gaussian-world"
    words: ClassVar[str] = "Gaussian, with errors of the world,"
    conjugate: ClassVar[bool] = False

    def carried(self, log_sigma: Array) -> Array:
        """Variance that the world's errors make at each draw, ``(n_draws, n_points)``, px^2."""
        step = self.log_sigma[1] - self.log_sigma[0]
        place = np.clip((log_sigma - self.log_sigma[0]) / step, 0, len(self.log_sigma) - 1)
        below = np.minimum(place.astype(int), len(self.log_sigma) - 2)
        share = (place - below)[:, None]
        return np.asarray((1 - share) * self.variance[below] + share * self.variance[below + 1])

    def _log_scale(self, log_sigma: Array, sd: Array | None) -> Array:
        own = np.exp(2 * scales(log_sigma, sd))
        return np.asarray(np.log(own + self.carried(log_sigma)) / 2)

    def taken(self, part: slice | IntArray) -> NoiseModel:
        """Give the errors of some of the points."""
        return replace(self, variance=self.variance[:, part])

    def log_density(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Log density of residuals, ``(n_draws, n_points)``; see NoiseModel."""
        return log_normal(residual, self._log_scale(log_sigma, sd))

    def draw(self, rng: np.random.Generator, log_sigma: Array, eta: Array, sd: Array) -> Array:
        """Simulate residuals of all points, ``(n_draws, n_points)``, px."""
        normal = rng.standard_normal((len(eta), len(sd)))
        return np.asarray(np.exp(self._log_scale(log_sigma, sd)) * normal)

    def weight(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """sigma^2 over all variance, ``(n_draws, n_points)``."""
        share = 2 * (scales(log_sigma, sd) - self._log_scale(log_sigma, sd))
        return np.asarray(np.exp(share))
