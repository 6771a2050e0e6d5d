"""Densities of known integral, mean and deviation, as models without a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import digamma, gammaln, polygamma
from scipy.stats import multivariate_normal

from bayescal.arrays import LOG_2PI
from bayescal.inference.target import log_prob
from bayescal.linear.model import LinearModel
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design

LOG_Z = -123.4


@dataclass(frozen=True)
class Known:
    """No data, no parameter integrated out; the integral is exp(LOG_Z)."""

    dimension: int

    @property
    def names(self):
        return tuple(f"x{j}" for j in range(self.dimension))

    def starts(self):
        return np.full((1, self.dimension), 0.5)

    def complete(self, theta, rng):  # noqa: ARG002 (nothing was integrated out)
        return theta

    def report(self, full):
        return full

    def log_likelihood(self, full):
        return np.zeros((len(full), 0))

    def log_normal(self, z):
        return LOG_Z - (z**2).sum(axis=1) / 2 - self.dimension / 2 * LOG_2PI


class Normal(Known):
    """Correlated, with scales four decades apart, its starts far away."""

    @cached_property
    def root(self):
        rng = np.random.default_rng(self.dimension)
        a = rng.standard_normal((self.dimension, self.dimension))
        scale = np.logspace(-2, 2, self.dimension)
        return scale[:, None] * np.linalg.cholesky(a @ a.T + 0.1 * np.eye(self.dimension))

    @cached_property
    def mean(self):
        return np.linspace(-3, 900, self.dimension)

    @property
    def sd(self):
        return np.linalg.norm(self.root, axis=1)

    def log_prob(self, theta):
        z = np.linalg.solve(self.root, (theta - self.mean).T).T
        return self.log_normal(z) - np.log(np.diag(self.root)).sum()


class HeavyTailed(Known):
    """Multivariate t with 5 degrees of freedom."""

    dof = 5.0

    @property
    def mean(self):
        return np.zeros(self.dimension)

    @property
    def sd(self):
        return np.full(self.dimension, math.sqrt(self.dof / (self.dof - 2)))

    def log_prob(self, theta):
        d, nu = self.dimension, self.dof
        constant = gammaln((nu + d) / 2) - gammaln(nu / 2) - d / 2 * math.log(nu * math.pi)
        return LOG_Z + constant - (nu + d) / 2 * np.log1p((theta**2).sum(axis=1) / nu)


class Banana(Known):
    """A normal bent by a shear, whose Jacobian is 1; means 0, the second deviation sqrt(1.5)."""

    @property
    def mean(self):
        return np.zeros(self.dimension)

    @property
    def sd(self):
        sd = np.ones(self.dimension)
        sd[1] = math.sqrt(1.5)
        return sd

    def log_prob(self, theta):
        z = theta.copy()
        z[:, 1] -= (theta[:, 0] ** 2 - 1) / 2
        return self.log_normal(z)


class Skewed(Known):
    """Logarithms of independent Gamma(2) variables: every coordinate leans to one side."""

    shape = 2.0

    @property
    def mean(self):
        return np.full(self.dimension, digamma(self.shape))

    @property
    def sd(self):
        return np.full(self.dimension, math.sqrt(polygamma(1, self.shape)))

    def log_prob(self, theta):
        with np.errstate(over="ignore"):
            logs = self.shape * theta - np.exp(theta) - gammaln(self.shape)
        return LOG_Z + logs.sum(axis=1)


class HalfSpace(Known):
    """A normal cut off at its mode."""

    @property
    def mean(self):
        mean = np.zeros(self.dimension)
        mean[0] = math.sqrt(2 / math.pi)
        return mean

    @property
    def sd(self):
        sd = np.ones(self.dimension)
        sd[0] = math.sqrt(1 - 2 / math.pi)
        return sd

    def log_prob(self, theta):
        return np.where(theta[:, 0] > 0, math.log(2) + self.log_normal(theta), -np.inf)


class TwoModes(Known):
    """Four fifths of the mass about (4, ..., 4), one fifth about (-4, ..., -4)."""

    @property
    def mean(self):
        return np.full(self.dimension, 4 * 0.6)

    @property
    def sd(self):
        return np.full(self.dimension, math.sqrt(1 + 16 * (1 - 0.36)))

    def starts(self):
        return np.array([np.ones(self.dimension), -np.ones(self.dimension)])

    def log_prob(self, theta):
        right, left = self.log_normal(theta - 4), self.log_normal(theta + 4)
        return np.logaddexp(math.log(0.8) + right, math.log(0.2) + left)


@dataclass(frozen=True, eq=False)
class Wrapped:
    """A linear model that has a closed form, offered as if it had none."""

    model: LinearModel
    data: AxisData

    @property
    def dimension(self):
        return self.model.dimension

    @property
    def names(self):
        return self.model.names

    def log_prob(self, theta):
        return log_prob(self.model, theta)

    def starts(self):
        r, qt = self.model.reduced.r, self.model.reduced.qt
        rest = [0.5] * self.model.infers_sigma + [math.log(0.05)] * self.model.infers_tau
        return np.array([[*np.linalg.solve(r, qt), *rest]])

    def complete(self, theta, rng):  # noqa: ARG002 (nothing was integrated out)
        return theta

    def report(self, full):
        size = self.model.size
        coefficients = full[:, :size] @ self.model.factors.monomials.lead(self.model.order).T
        return np.concatenate([coefficients, np.exp(full[:, size:])], axis=1)

    def log_likelihood(self, full):
        size, order = self.model.size, self.model.order
        design = legendre_design(self.data.domain.scale(self.data.x), order)
        log_sigma = full[:, [size]]
        z = (self.data.t - full[:, :size] @ design.T) * np.exp(-log_sigma)
        return -(z**2 + LOG_2PI) / 2 - log_sigma


def normal_log_density(mean, sd):
    """A normal's log density, by scipy."""
    return multivariate_normal(np.atleast_1d(mean), np.diag(np.atleast_1d(sd) ** 2)).logpdf
