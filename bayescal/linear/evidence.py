r"""Evidence of linear Gaussian models, one or thousands at a time.

Given sigma and tau, the amplitudes b integrate out exactly. With the prior
b ~ N(m, S), S = diag(s_j^2), and the singular value decomposition
R S^{1/2} = U D V', the projected data w = U'(Q't - R m) are independent,

    w_j ~ N(0, sigma^2 + D_j^2),        rss / sigma^2 ~ chi^2(n - p)

(Bishop 2006, 3.5, in the basis that makes every matrix diagonal). ln sigma and ln tau
are integrated by quadrature. A flat prior is the limit without the prior's unit
precision (`precision` = 0, S = 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from bayescal.arrays import LOG_2PI, Array
from bayescal.linear.quadrature import COARSE, FINE, POINT, Accuracy, Rule, evenly, follow, interval
from bayescal.noise.level import NoiseLevel
from bayescal.prior.amplitudes import CoefficientPrior

# "Piling up at a bound": this much of sigma's posterior within this fraction of it.
NEAR_BOUND = 0.05
# Range of ln tau that a rule's own number of nodes is for.
TAU_SPAN = 6.3
# Numbers held at once while many models are integrated: few enough for a core's cache.
CHUNK = 300_000


@dataclass(frozen=True, eq=False)
class Reduced:
    """Weighted data of one order, or of many data sets alike, reduced to O(p^2) numbers.

    Attributes
    ----------
    r : Array
        Upper triangles R, ``(..., p, p)``.
    qt : Array
        Q't, ``(..., p)``.
    rss, n, log_sd : Array
        Residual sum of squares, number of points, sum of ln sd over points with known
        deviations, ``(...,)``.
    """

    r: Array
    qt: Array
    rss: Array
    n: Array
    log_sd: Array

    def __getitem__(self, part: slice | NDArray[np.intp]) -> Reduced:
        return Reduced(self.r[part], self.qt[part], self.rss[part], self.n[part], self.log_sd[part])


@dataclass(frozen=True, eq=False)
class Projection:
    """Everything that depends on tau alone, at each node of tau.

    Attributes
    ----------
    d : Array
        Singular values, ``(..., n_tau, p)``.
    w : Array
        Projected data, ``(..., n_tau, p)``.
    vt : Array
        V', ``(..., n_tau, p, p)``.
    s : Array
        Prior standard deviations, ``(n_tau, p)``, px.
    precision : float
        Prior precision of each a_j: 1, or 0 under a flat prior.
    """

    d: Array
    w: Array
    vt: Array
    s: Array
    precision: float

    @classmethod
    def of(cls, data: Reduced, prior: CoefficientPrior, log_tau: Array) -> Projection:
        """Decompose data at each tau, ``(n_tau,)``."""
        size = data.qt.shape[-1]
        s = prior.deviations(log_tau) if prior.proper else np.ones((len(log_tau), size))
        u, d, vt = np.linalg.svd(data.r[..., None, :, :] * s[:, None, :])
        misfit = data.qt - data.r @ prior.mean
        w = np.einsum("...tji,...j->...ti", u, misfit)
        return cls(d, w, vt, s, float(prior.proper))

    def log_likelihood(self, data: Reduced, log_sigma: Array) -> Array:
        """Log of the likelihood with b integrated out, ``(..., n_tau, n_sigma)``."""
        variance = np.exp(2 * log_sigma)
        logs: Array | float = 2 * self.d.shape[-1] * log_sigma
        quadratic: Array | float = 0.0
        ratios: Array | float = 1.0
        # One amplitude at a time: no array of all of them is made, and one logarithm
        # serves four (ratios are at least 1, or rank-limited under a flat prior).
        for j in range(self.d.shape[-1]):
            ratio = self.precision + self.d[..., j, None] ** 2 / variance
            quadratic = quadratic + self.w[..., j, None] ** 2 / ratio
            ratios = ratios * ratio
            if j % 4 == 3:
                logs, ratios = logs + np.log(ratios), 1.0
        projected = logs + np.log(ratios) + self.precision * quadratic / variance
        p = data.qt.shape[-1]
        spare, rss, log_sd = ((a[..., None, None]) for a in (data.n - p, data.rss, data.log_sd))
        constant = -(spare + self.precision * p) / 2 * LOG_2PI - log_sd
        misfit = -spare * log_sigma - rss / 2 * np.exp(-2 * log_sigma)
        return np.asarray(constant + misfit - projected / 2)


def tau_rule(prior: CoefficientPrior, accuracy: Accuracy) -> tuple[Rule, Array]:
    """Quadrature in ln tau and the ln tau of its nodes; one node where tau is fixed."""
    if prior.infers_tau:
        # The wider its bounds and the more amplitudes tau has, the narrower its posterior
        # is among them.
        lower, upper = prior.log_tau_bounds
        finer = math.ceil((upper - lower) / TAU_SPAN) + int(prior.scaled.sum()) // 8
        rule = interval(lower, upper, finer * (accuracy.tau_nodes - 1) + 1)
        return rule, rule.nodes
    return POINT, np.log([prior.tau if prior.tau is not None else 1.0])


def log_joint(
    data: Reduced,
    projection: Projection,
    noise: NoiseLevel,
    prior: CoefficientPrior,
    accuracy: Accuracy,
) -> tuple[Rule, Array]:
    """Quadrature in ln sigma, and likelihood times priors at its nodes, b integrated out.

    Returns
    -------
    rule : Rule
        In ln sigma; one node where it is known.
    values : Array
        Logs, ``(..., n_tau, n_sigma)``.
    """
    log_prior = noise.log_prior() + prior.log_tau_density()

    def density(log_sigma: Array) -> Array:
        return log_prior + projection.log_likelihood(data, log_sigma)

    if noise.value is not None:
        return POINT, density(np.log([noise.value]))
    lower, upper = noise.log_bounds
    if accuracy.even:
        # The curvature in ln sigma is at most twice the number of points.
        width = 1 / math.sqrt(2 * max(1.0, float(np.max(data.n))))
        found = evenly(density, lower, upper, width, accuracy.drop)
        if found is not None:
            return found
    edge = np.log1p(NEAR_BOUND)
    inner = np.linspace(lower + edge, upper - edge, accuracy.panels + 1)
    breaks = np.concatenate([[lower], inner, [upper]])
    return follow(density, breaks, accuracy)


def log_evidences(
    data: Reduced, noise: NoiseLevel, prior: CoefficientPrior, accuracy: Accuracy = COARSE
) -> Array:
    """Log evidence of one order on many data sets.

    Parameters
    ----------
    data : Reduced
        With one leading axis, ``(n_sets, ...)``.
    prior : CoefficientPrior
        Of that order.

    Returns
    -------
    Array
        ``(n_sets,)``; under a flat prior the integral of the likelihood.
    """
    rule, log_tau = tau_rule(prior, accuracy)
    per_set = len(log_tau) * 100 * data.qt.shape[-1]
    step = max(1, CHUNK // per_set)
    out = []
    for start in range(0, len(data.qt), step):
        part = data[start : start + step]
        projection = Projection.of(part, prior, log_tau)
        sigma_rule, values = log_joint(part, projection, noise, prior, accuracy)
        weights = rule.weights[:, None] * sigma_rule.weights
        out.append(logsumexp(values, axis=(-2, -1), b=weights))
    return np.concatenate(out)


def log_evidence_over_tau(
    data: Reduced, noise: NoiseLevel, prior: CoefficientPrior, log_tau: Array
) -> Array:
    """Log evidence of one order at each fixed tau, ``(n_tau,)``.

    Parameters
    ----------
    data : Reduced
        Of one data set.
    prior : CoefficientPrior
        Its own tau is not used.
    log_tau : Array
        ``(n_tau,)``.
    """
    projection = Projection.of(data, prior, log_tau)
    rule, values = log_joint(data, projection, noise, prior, FINE)
    at_tau = logsumexp(values, axis=-1, b=rule.weights) - prior.log_tau_density()
    return np.asarray(at_tau)
