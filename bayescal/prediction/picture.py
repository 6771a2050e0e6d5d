"""The noise of a whole new picture: what neighbours on the target share in it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bayescal.arrays import Array
from bayescal.prediction.calibrated.noise import NewNoise

JITTER = 1e-10  # of the variance: two points of the target may be one


@dataclass(frozen=True, eq=False)
class Picture:
    """Noise of all points of one new picture.

    Attributes
    ----------
    noise : NewNoise
        Of the calibration.
    sigma : float or None
        Sd of a single pixel where it is stated, px; neighbours then share as large a part of it.
    """

    noise: NewNoise
    sigma: float | None = None

    @property
    def gaussian(self) -> bool:
        """Whether all draws are of one Gaussian but for its level."""
        alone = self.noise.neighbours is None
        return alone and (self.sigma is not None or self.noise.gaussian)

    @cached_property
    def _levels(self) -> Array | None:
        """Own and shared sd and length of every draw, ``(n_draws, 3)``; None where independent."""
        neighbours = self.noise.neighbours
        if neighbours is None or self.sigma is None:
            return neighbours
        total = np.hypot(neighbours[:, 0], neighbours[:, 1])[:, None]
        return np.column_stack([self.sigma * neighbours[:, :2] / total, neighbours[:, 2]])

    @cached_property
    def scale(self) -> Array:
        """Sd of r and of c, px; of robust noise half its central 68.3 %, ``(2,)``."""
        if self.sigma is not None:
            return np.full(2, self.sigma)
        if self._levels is None:
            return self.noise.scale
        return np.full(2, np.sqrt((self._levels[:, :2] ** 2).sum(axis=1).mean()))

    @cached_property
    def variances(self) -> Array:
        """Draws of independent noise's variance over that of `scale`, ``(n_draws,)``."""
        if self.sigma is not None:
            return np.ones(1)
        return np.asarray((np.exp(2 * self.noise.log_sigma) / self.scale**2).mean(axis=1))

    def root(self, points: Array) -> Array | None:
        """Lower root of the points' covariance over that of `scale`; None where independent."""
        if self._levels is None:
            return None
        own, shared, length = self._levels.T
        covariance = (own**2).mean() * np.eye(len(points))
        for each in np.unique(length[shared > 0]):
            part = (shared[length == each] ** 2).sum() / len(own)
            covariance += part * _kernel(points, each)
        return np.linalg.cholesky(covariance / self.scale[0] ** 2)

    def draw(self, rng: np.random.Generator, points: Array) -> Array:
        """Simulate the noise of a picture at every draw, ``(n_draws, n, 2)``, px."""
        if self._levels is None:
            if self.sigma is None:
                return self.noise.draw(rng, len(points))
            return self.sigma * rng.standard_normal((len(self.noise.log_sigma), len(points), 2))
        own, shared, length = self._levels.T
        drawn = own[:, None, None] * rng.standard_normal((len(own), len(points), 2))
        for each in np.unique(length[shared > 0]):
            rows = np.flatnonzero((length == each) & (shared > 0))
            root = np.linalg.cholesky(_kernel(points, each) + JITTER * np.eye(len(points)))
            smooth = root @ rng.standard_normal((len(rows), len(points), 2))
            drawn[rows] += shared[rows, None, None] * smooth
        return np.asarray(drawn)


def _kernel(points: Array, length: float) -> Array:
    """exp(-d / l) of points ``(n, 3)``, ``(n, n)``."""
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.asarray(np.exp(-apart / length))
