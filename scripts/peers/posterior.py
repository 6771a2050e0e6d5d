"""The posterior that every peer samples, written down as any user of a sampler would."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import ndtri

import bayescal as bc
from bayescal.arrays import Array
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.settings import Settings
from bayescal.linear.model import LinearModel
from bayescal.polynomials import separable

HALF_LOG_2PI = math.log(2 * math.pi) / 2


@dataclass(frozen=True)
class Posterior:
    """r of the thesis's 57 points as a polynomial of x/z, under the default prior.

    Parameters are the Legendre amplitudes b_0 ... b_k (px), ln sigma and, from order 2 on, ln tau.
    """

    order: int

    @cached_property
    def axis(self) -> Axis:
        """The axis as the program has it, for its own run and for the truth."""
        data = separable.axis_data(bc.thesis(), "r")
        return Axis.of(data, Settings(), family=separable.NAME, highest=self.order)

    @cached_property
    def linear(self) -> LinearModel:
        """The program's model."""
        return self.axis.linear(self.order)

    @cached_property
    def t(self) -> Array:
        """Pixels, ``(57,)``."""
        return self.axis.data.t

    @cached_property
    def design(self) -> Array:
        """Legendre polynomials at the points, ``(57, p)``."""
        x = self.axis.data.x
        s = (2 * x - x.min() - x.max()) / (x.max() - x.min())
        return legvander(s, self.order)

    @property
    def size(self) -> float:
        """Image width, px."""
        return 1920.0

    @property
    def p(self) -> int:
        """Number of amplitudes."""
        return self.order + 1

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Of ln sigma and, where there is one, ln tau."""
        sigma, tau = (0.01, 1000.0), (0.01 / self.size, 0.5)
        return [tuple(map(math.log, pair)) for pair in (sigma, tau)][: 1 + (self.order > 1)]

    @property
    def names(self) -> list[str]:
        """Names of the parameters."""
        return [f"b{j}" for j in range(self.p)] + ["log_sigma", "log_tau"][: len(self.bounds)]

    @cached_property
    def mean(self) -> Array:
        """Prior means of the amplitudes, ``(p,)``, px."""
        return np.array([self.size / 2] + [0.0] * self.order)

    def sd(self, log_tau: Array) -> Array:
        """Prior standard deviations of the amplitudes, ``(..., p)``, px."""
        sd = np.full((*np.shape(log_tau), self.p), self.size / 2)
        sd[..., 2:] = self.size * np.exp(np.asarray(log_tau))[..., None]
        return sd

    def log_likelihood(self, theta: Array) -> Array:
        """Of parameters ``(..., dimension)``."""
        log_sigma = theta[..., self.p]
        z = (self.t - theta[..., : self.p] @ self.design.T) * np.exp(-log_sigma)[..., None]
        return -0.5 * (z**2).sum(axis=-1) - len(self.t) * (log_sigma + HALF_LOG_2PI)

    def log_prior(self, theta: Array) -> Array:
        """Of parameters ``(..., dimension)``; -inf beyond the bounds."""
        total = np.zeros(theta.shape[:-1])
        for i, (low, high) in enumerate(self.bounds, self.p):
            inside = (theta[..., i] >= low) & (theta[..., i] <= high)
            total = np.where(inside, total - math.log(high - low), -np.inf)
        sd = self.sd(theta[..., -1] if self.order > 1 else np.zeros(theta.shape[:-1]))
        z = (theta[..., : self.p] - self.mean) / sd
        return total - (z**2 / 2 + np.log(sd) + HALF_LOG_2PI).sum(axis=-1)

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior."""
        prior = self.log_prior(theta)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.where(np.isfinite(prior), prior + self.log_likelihood(theta), -np.inf)

    def from_unit(self, u: Array) -> Array:
        """Prior transform of nested sampling: the unit cube to parameters."""
        theta = np.array(u, dtype=float)
        for i, (low, high) in enumerate(self.bounds, self.p):
            theta[..., i] = low + (high - low) * u[..., i]
        sd = self.sd(theta[..., -1] if self.order > 1 else np.zeros(theta.shape[:-1]))
        theta[..., : self.p] = self.mean + sd * ndtri(u[..., : self.p])
        return theta

    @cached_property
    def start(self) -> Array:
        """Least squares: where chains begin, ``(dimension,)``."""
        b, rss, *_ = np.linalg.lstsq(self.design, self.t, rcond=None)
        sigma = math.sqrt(float(rss[0]) / len(self.t))
        return np.array([*b, math.log(sigma), *([math.log(0.02)] if self.order > 1 else [])])
