"""Gaussian noise: the default, and the limit of the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.noise.model import NoiseModel, scales


@dataclass(frozen=True)
class Gaussian:
    """Residuals are N(0, sigma^2); nothing else to infer."""

    name: ClassVar[str] = "gaussian"
    words: ClassVar[str] = "Gaussian"
    level: ClassVar[str] = "sigma"
    options: ClassVar[tuple[str, ...]] = ()
    columns: ClassVar[Mapping[str, tuple[str, str]]] = {}
    tells_bad: ClassVar[bool] = False
    conjugate: ClassVar[bool] = True
    parameters = ()
    dimension = 0

    @classmethod
    def of(cls, pixel: float, **options: Any) -> Self:  # noqa: ARG003 - nothing to choose
        """Make it."""
        return cls()

    @property
    def chosen(self) -> dict[str, Any]:
        """Nothing is."""
        return {}

    def described(self, unit: str) -> str:
        """Name it."""
        return "Gaussian"

    @property
    def priors(self) -> dict[str, Any]:
        """There are none beside sigma's."""
        return {}

    def taken(self, part: slice | IntArray) -> NoiseModel:
        """Give itself: it knows no points."""
        return self

    def log_density(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Log density of residuals, ``(n_draws, n_points)``; see NoiseModel."""
        return log_normal(residual, scales(log_sigma, sd))

    def total(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Sum of `log_density` over the points, ``(n_draws,)``."""
        return np.asarray(self.log_density(residual, log_sigma, eta, sd).sum(axis=1))

    def log_prior(self, eta: Array) -> Array:
        """Give 0: there is nothing to have a prior, ``(n_draws,)``."""
        return np.zeros(len(eta))

    def report(self, eta: Array) -> Array:
        """Give nothing, ``(n_draws, 0)``."""
        return np.empty((len(eta), 0))

    def starts(self) -> Array:
        """One start, ``(1, 0)``."""
        return np.empty((1, 0))

    def draw(self, rng: np.random.Generator, log_sigma: Array, eta: Array, sd: Array) -> Array:
        """Simulate residuals, ``(n_draws, n_points)``, px."""
        drawn: Array = np.exp(scales(log_sigma, sd)) * rng.standard_normal((len(eta), len(sd)))
        return drawn

    def bad_probability(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array | None:
        """Give None: a Gaussian knows no bad points."""
        return None

    def weight(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Give 1 for every point, ``(n_draws, n_points)``."""
        return np.ones(residual.shape)


NOISE = Gaussian
GAUSSIAN = Gaussian()


def log_normal(residual: Array, log_scale: Array) -> Array:
    """Log density of N(0, scale^2), of the arguments' common shape."""
    z = residual * np.exp(-log_scale)
    return np.asarray(-(z * z + LOG_2PI) / 2 - log_scale)
