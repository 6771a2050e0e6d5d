"""Pixels of r and c jointly, with what is known of their noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import LOG_2PI, Array
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.whole import Whole


@dataclass(frozen=True, eq=False)
class JointData:
    """Pixels of both axes with what is known of their noise.

    Attributes
    ----------
    pixels : Array
        r and c, ``(2, n_points)``, px.
    sd : tuple
        Known deviations of each axis, ``(n_points,)``, px, or None.
    levels : tuple of NoiseLevel
        Of r and of c.
    whole : tuple of Whole, or None
        All points of each axis, reduced, where these are a sample of them.
    """

    pixels: Array
    sd: tuple[Array | None, Array | None]
    levels: tuple[NoiseLevel, NoiseLevel]
    whole: tuple[Whole, Whole] | None = None

    @property
    def n(self) -> int:
        """Number of points that the likelihood has: all, where these are a sample."""
        return len(self.pixels[0]) if self.whole is None else self.whole[0].n

    @property
    def deviations(self) -> Array:
        """Known deviations, ``(2, n_points)``; 1 where sigma is one for all points."""
        ones = np.ones(len(self.pixels[0]))
        return np.stack([ones if sd is None else sd for sd in self.sd])

    @property
    def log_sd(self) -> float:
        """Sum of ln of the known deviations, of both axes."""
        if self.whole is None:
            return float(np.log(self.deviations).sum())
        pairs = zip(self.whole, self.sd, strict=True)
        return sum(whole.log_sd for whole, sd in pairs if sd is not None)

    @property
    def largest(self) -> list[float]:
        """Largest weighted pixel of each axis in size: the scale of rounding."""
        if self.whole is None:
            found: list[float] = np.abs(self.pixels / self.deviations).max(axis=1).tolist()
            return found
        pairs = zip(self.whole, self.sd, strict=True)
        return [(w.plain if sd is None else w.used).largest for w, sd in pairs]

    @property
    def inferred(self) -> tuple[bool, bool]:
        """Whether each axis's sigma is inferred."""
        return self.levels[0].value is None, self.levels[1].value is None

    def log_likelihood(self, rss: Array) -> float:
        """Maximised over sigma where it is inferred; `rss` of each axis, weighted, ``(2,)``."""
        total = -self.log_sd - self.n * LOG_2PI
        for level, q in zip(self.levels, rss.tolist(), strict=True):
            if level.value is None:
                total -= self.n / 2 * (math.log(max(q, 1e-300) / self.n) + 1)
            else:
                total -= q / level.value**2 / 2 + self.n * math.log(level.value)
        return total

    def bounded_sigma(self, rss: Array) -> Array:
        """Sigma of each axis: known, or most probable within its bounds; `rss` ``(2,)``."""
        pairs = zip(self.levels, rss.tolist(), strict=True)
        return np.array([level.bounded(q, self.n) for level, q in pairs])

    def likely_sigma(self, rss: Array) -> Array:
        """Sigma of each axis: known, or the most likely one; `rss` ``(2,)``."""
        pairs = zip(self.levels, rss.tolist(), strict=True)
        return np.array([level.likely(q, self.n) for level, q in pairs])

    def bounded_log_likelihood(self, rss: Array) -> float:
        """Maximised over sigma within its bounds, which residuals of no noise would leave."""
        sigma = self.bounded_sigma(rss)
        constant = -self.log_sd - self.n * LOG_2PI
        return constant - float((rss / sigma**2 / 2 + self.n * np.log(sigma)).sum())
