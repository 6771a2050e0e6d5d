r"""A mixture of good and bad points (Hogg, Bovy & Lang 2010, arXiv:1008.4686, section 3).

A residual is N(0, sigma^2) with probability 1 - f and N(offset, sigma^2 + width^2) with
probability f: bad points are spread about the model's prediction, not about a place of
their own. Priors: f uniform on [0, 1/2]; ln width uniform between bounds, px; offset zero
or, on request, N(0, width^2). With f up to 1 the labels can swap ("97 % of the points are
bad"), hence the bound.

eta: the probit of f / (1/2); the probit of where ln width lies between its bounds; and
offset / width, where it is inferred. Each is standard normal a priori.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from scipy.special import expit, log_ndtr, ndtr, ndtri

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.noise.gaussian import log_normal
from bayescal.noise.model import WORTH, NoiseModel, scales, sum_log1p
from bayescal.prior.probit import log_value

LARGEST_FRACTION = 0.5
# Bounds of the bad component's width on an image, px: a gross error is of several pixels, and
# within the image. With 1 px below, 1.5 % of the points of clean data (sigma 1 px) were called
# bad: such points can't be told from good ones.
WIDTH_BOUNDS = (5.0, 1000.0)


@dataclass(frozen=True)
class OutlierMixture:
    """Good points are N(0, sigma^2), bad ones N(offset, sigma^2 + width^2).

    Attributes
    ----------
    width_bounds : tuple of float
        Bounds of the width, px; its logarithm is uniform between them.
    infers_offset : bool
        Whether the bad points' offset is inferred; else it is zero.
    largest_fraction : float
        The fraction of bad points is uniform from 0 to this.
    """

    name: ClassVar[str] = "outlier-mixture"
    words: ClassVar[str] = "mixture"
    level: ClassVar[str] = "sigma"
    options: ClassVar[tuple[str, ...]] = ("bad_offset",)
    columns: ClassVar[Mapping[str, tuple[str, str]]] = {
        "bad_fraction": ("bad", "fraction of bad points"),
        "bad_width": ("width px", "width of the bad points"),
        "bad_offset": ("offset px", "offset of the bad points"),
    }
    tells_bad: ClassVar[bool] = True
    conjugate: ClassVar[bool] = False

    width_bounds: tuple[float, float] = WIDTH_BOUNDS
    infers_offset: bool = False
    largest_fraction: float = LARGEST_FRACTION

    @classmethod
    def of(cls, pixel: float, **options: Any) -> Self:
        """Make it, the bounds of the width in what stands for a pixel."""
        low, high = WIDTH_BOUNDS
        return cls((low * pixel, high * pixel), bool(options.get("bad_offset")))

    @property
    def chosen(self) -> dict[str, Any]:
        """Whether the bad points have an offset."""
        return {"bad_offset": self.infers_offset}

    def described(self, unit: str) -> str:
        """Say what is uniform between which bounds."""
        lower, upper = self.width_bounds
        offset = "of an offset ~ N(0, width²)" if self.infers_offset else "without offset"
        return (
            f"mixture of good points and bad ones, whose fraction is uniform from 0 to "
            f"{self.largest_fraction:g} and which are wider by a width, log-uniform from "
            f"{lower:.4g} to {upper:.4g} {unit}, {offset}"
        )

    @property
    def priors(self) -> dict[str, Any]:
        """Bounds of fraction and width, and what the offset is."""
        return {
            "bad_fraction_bounds": [0.0, self.largest_fraction],
            "bad_width_bounds_px": list(self.width_bounds),
            "bad_offset": "inferred" if self.infers_offset else "zero",
        }

    @property
    def parameters(self) -> tuple[str, ...]:
        """Fraction and width of the bad points, and their offset where it is inferred."""
        return ("bad_fraction", "bad_width") + ("bad_offset",) * self.infers_offset

    @property
    def dimension(self) -> int:
        """2, or 3 where the offset is inferred."""
        return 2 + self.infers_offset

    def _log_width(self, eta: Array) -> Array:
        lower, upper = self.width_bounds
        return log_value(eta[:, 1:2], (math.log(lower), math.log(upper)))

    def _log_densities(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None
    ) -> tuple[Array, Array]:
        """Log of share times density of the good and of the bad, ``(n_draws, n_points)``."""
        log_scale, log_width = scales(log_sigma, sd), self._log_width(eta)
        log_spread = np.logaddexp(2 * log_scale, 2 * log_width) / 2
        largest = self.largest_fraction
        with np.errstate(divide="ignore"):
            log_rest = np.log(1 - largest)
        log_bad = math.log(largest) + log_ndtr(eta[:, :1])
        log_good = np.logaddexp(log_rest, math.log(largest) + log_ndtr(-eta[:, :1]))
        good = log_good + log_normal(residual, log_scale)
        off = residual - eta[:, 2:3] * np.exp(log_width) if self.infers_offset else residual
        return good, log_bad + log_normal(off, log_spread)

    def taken(self, part: slice | IntArray) -> NoiseModel:
        """Give itself: it knows no points."""
        return self

    def log_density(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Log density of residuals, ``(n_draws, n_points)``; see NoiseModel."""
        return np.asarray(np.logaddexp(*self._log_densities(residual, log_sigma, eta, sd)))

    def total(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Sum of `log_density` over the points, ``(n_draws,)``."""
        good, bad = self._log_densities(residual, log_sigma, eta, sd)
        if residual.shape[1] < WORTH:
            return np.asarray(np.logaddexp(good, bad).sum(axis=1))
        with np.errstate(over="ignore"):
            return np.asarray(bad.sum(axis=1) + sum_log1p(np.exp(good - bad)))

    def log_prior(self, eta: Array) -> Array:
        """Log density, standard normal in every coordinate, ``(n_draws,)``."""
        return np.asarray(-(eta * eta + LOG_2PI).sum(axis=1) / 2)

    def report(self, eta: Array) -> Array:
        """Bad fraction, width (px) and, where inferred, offset (px), ``(n_draws, 2 or 3)``."""
        width = np.exp(self._log_width(eta))
        columns = [self.largest_fraction * ndtr(eta[:, :1]), width]
        if self.infers_offset:
            columns.append(eta[:, 2:3] * width)
        return np.concatenate(columns, axis=1)

    def starts(self) -> Array:
        """Few and many bad points, narrow and wide, ``(3, dimension)``.

        Without the bound on the fraction a fourth, at which most points are bad.
        """
        pairs = [(0.05, 1 / 3), (0.05, 2 / 3), (0.42, 0.1)]
        if self.largest_fraction > LARGEST_FRACTION:
            pairs.insert(0, (0.95, 0.2))
        fraction, width = np.array(pairs).T  # width: of the way between the bounds' logarithms
        nothing = [np.zeros(len(pairs))] * self.infers_offset
        return np.column_stack([ndtri(fraction / self.largest_fraction), ndtri(width), *nothing])

    def draw(self, rng: np.random.Generator, log_sigma: Array, eta: Array, sd: Array) -> Array:
        """Simulate residuals, ``(n_draws, n_points)``, px."""
        size = (len(eta), len(sd))
        known = self.report(eta)
        bad = rng.random(size) < known[:, :1]
        offset = known[:, 2:3] if self.infers_offset else 0.0
        good = np.exp(scales(log_sigma, sd)) * rng.standard_normal(size)
        added = offset + known[:, 1:2] * rng.standard_normal(size)
        return np.asarray(good + np.where(bad, added, 0.0))

    def bad_probability(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Probability of each point to be bad, by Bayes' rule, ``(n_draws, n_points)``."""
        good, bad = self._log_densities(residual, log_sigma, eta, sd)
        return np.asarray(expit(bad - good))

    def weight(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """1 for the good and sigma^2 / (sigma^2 + width^2) for the bad, averaged."""
        bad = self.bad_probability(residual, log_sigma, eta, sd)
        kept = expit(2 * (scales(log_sigma, sd) - self._log_width(eta)))
        return np.asarray(1 - bad * (1 - kept))


NOISE = OutlierMixture
