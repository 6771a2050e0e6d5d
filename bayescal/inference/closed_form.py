r"""Evidence and posterior of a linear Gaussian model in closed form: the oracle.

Given sigma and tau, the amplitudes b integrate out exactly. With the prior
b ~ N(m, S), S = diag(s_j^2), and the singular value decomposition
R S^{1/2} = U D V', the projected data w = U'(Q't - R m) are independent,

    w_j ~ N(0, sigma^2 + D_j^2),        rss / sigma^2 ~ chi^2(n - p),

and b = m + S^{1/2} V a with a_j | w ~ N(D_j w_j / (sigma^2 + D_j^2),
sigma^2 / (sigma^2 + D_j^2)) (Bishop 2006, 3.3 and 3.5, in the basis that makes
every matrix diagonal). ln sigma and ln tau are integrated by quadrature. A flat
prior is the limit without the prior's unit precision (`precision` = 0, S = 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import logsumexp, ndtr

from bayescal.arrays import Array
from bayescal.inference.model import LinearModel
from bayescal.inference.quadrature import POINT, Rule, follow, interval

TAU_NODES = 49
LOG_2PI = float(np.log(2 * np.pi))
# "Piling up at a bound": this much of sigma's posterior within this fraction of it.
NEAR_BOUND = 0.05


@dataclass(frozen=True, eq=False)
class Conditional:
    """Everything that depends on tau alone, at each node of tau.

    Attributes
    ----------
    d : Array
        Singular values, ``(n_tau, p)``.
    w : Array
        Projected data, ``(n_tau, p)``.
    to_b : Array
        S^{1/2} V: b = mean + to_b @ a, ``(n_tau, p, p)``.
    from_b : Array
        Its inverse, ``(n_tau, p, p)``.
    log_det : Array
        ln |det from_b|, ``(n_tau,)``.
    precision : float
        Prior precision of each a_j: 1, or 0 under a flat prior.
    """

    d: Array
    w: Array
    to_b: Array
    from_b: Array
    log_det: Array
    precision: float

    @classmethod
    def of(cls, model: LinearModel, log_tau: Array) -> Conditional:
        """Decompose a model at each tau, ``(n_tau,)``."""
        r, qt, _ = model.block
        if model.prior.proper:
            s = model.prior.deviations(log_tau)
        else:
            s = np.ones((len(log_tau), model.size))
        u, d, vt = np.linalg.svd(r * s[:, None, :])
        w = np.einsum("tji,j->ti", u, qt - r @ model.prior.mean)
        return cls(
            d,
            w,
            s[:, :, None] * vt.transpose(0, 2, 1),
            vt / s[:, None, :],
            -np.log(s).sum(axis=1),
            float(model.prior.proper),
        )

    def moments(self, variance: Array) -> tuple[Array, Array]:
        """Mean and variance of each a_j given sigma^2.

        Parameters
        ----------
        variance : Array
            sigma^2, broadcast against ``(n_tau, ..., p)``.
        """
        d = _between(self.d, variance.ndim)
        w = _between(self.w, variance.ndim)
        total = self.precision * variance + d**2
        return d * w / total, variance / total

    def log_likelihood(self, model: LinearModel, log_sigma: Array) -> Array:
        """Log of the likelihood with b integrated out, ``(n_tau, n_sigma)``."""
        variance = np.exp(2 * log_sigma)[None, :, None]
        total = self.precision * variance + self.d[:, None, :] ** 2
        quadratic = self.precision * self.w[:, None, :] ** 2 / total
        n, p, rss = model.factors.n, model.size, model.block[2]
        constant = -(n - p + self.precision * p) / 2 * LOG_2PI - model.factors.log_sd
        misfit = -(n - p) * log_sigma - rss / 2 * np.exp(-2 * log_sigma)
        projected: Array = (np.log(total) + quadratic).sum(axis=2)
        return constant + misfit - projected / 2


def _between(array: Array, ndim: int) -> Array:
    """Insert axes after the first, so that ``(n_tau, p)`` becomes ``(n_tau, ..., p)``."""
    return array.reshape(array.shape[0], *(1,) * (ndim - 2), array.shape[1])


@dataclass(frozen=True, eq=False)
class ExactPosterior:
    """Posterior of a linear Gaussian model without sampling.

    Attributes
    ----------
    model : LinearModel
    sigma_rule, tau_rule : Rule
        Quadrature in ln sigma and ln tau; a single node where they are no
        parameters.
    conditional : Conditional
        At the nodes of tau.
    log_joint : Array
        Log of likelihood times priors of ln sigma and ln tau, b integrated out,
        ``(n_tau, n_sigma)``.
    """

    model: LinearModel
    sigma_rule: Rule
    tau_rule: Rule
    conditional: Conditional
    log_joint: Array

    @cached_property
    def log_integral(self) -> float:
        """Log of the integral of likelihood times prior (no evidence if flat)."""
        return self._integrate(self.tau_rule.weights, self.sigma_rule.weights)

    @property
    def log_evidence(self) -> float | None:
        """Natural log of p(data | model); None under a flat prior."""
        return self.log_integral if self.model.prior.proper else None

    @cached_property
    def log_evidence_error(self) -> float | None:
        """Bound on the quadrature's error: difference to the nested coarser rule, nat."""
        if not self.model.prior.proper:
            return None
        coarse = self._integrate(self.tau_rule.coarse, self.sigma_rule.coarse)
        return abs(coarse - self.log_integral)

    def _integrate(self, tau_weights: Array, sigma_weights: Array) -> float:
        weights = tau_weights[:, None] * sigma_weights
        return float(logsumexp(self.log_joint, b=weights))

    @cached_property
    def weights(self) -> Array:
        """Posterior probability of each node, ``(n_tau, n_sigma)``, summing to 1."""
        product = self.tau_rule.weights[:, None] * self.sigma_rule.weights
        return product * np.exp(self.log_joint - self.log_integral)

    @cached_property
    def sigma(self) -> Array:
        """Sigma at its nodes, ``(n_sigma,)``, px."""
        if self.model.noise.value is not None:
            return np.array([self.model.noise.value])
        return np.exp(self.sigma_rule.nodes)

    @cached_property
    def _amplitudes(self) -> tuple[Array, Array]:
        mean, variance = self.conditional.moments(self.sigma[None, :, None] ** 2)
        weights, to_b = self.weights, self.conditional.to_b
        node_mean = np.einsum("tpq,tsq->tsp", to_b, mean)  # of b, less the prior mean
        centre = np.einsum("ts,tsp->p", weights, node_mean)
        offset = node_mean - centre
        within = np.einsum("tpq,tq,trq->pr", to_b, np.einsum("ts,tsq->tq", weights, variance), to_b)
        between = np.einsum("ts,tsp,tsr->pr", weights, offset, offset)
        return self.model.prior.mean + centre, within + between

    @property
    def mean(self) -> Array:
        """Posterior mean of the amplitudes, ``(p,)``, px."""
        return self._amplitudes[0]

    @property
    def covariance(self) -> Array:
        """Posterior covariance of the amplitudes, ``(p, p)``, px^2."""
        return self._amplitudes[1]

    @cached_property
    def summary(self) -> tuple[Array, Array]:
        """Mean and sd of every reported parameter, in the order of ``model.names``."""
        monomials = self.model.factors.monomials
        root = np.linalg.cholesky(self.covariance)
        means = [*monomials.apply(self.mean)]
        sds = [*np.linalg.norm(monomials.apply(root), axis=1)]
        for values, mass in self.hyperparameters:
            mean = float(mass @ values)
            means.append(mean)
            sds.append(float(np.sqrt(mass @ (values - mean) ** 2)))
        return np.array(means), np.array(sds)

    @cached_property
    def kurtosis(self) -> Array:
        """Fourth central moment over variance^2 of every reported parameter."""
        weights, means, variances = self._components(
            self.model.factors.monomials.lead(self.model.order)
        )
        means = means - weights @ means
        fourth = means**4 + 6 * means**2 * variances + 3 * variances**2
        out = [*(weights @ fourth / (weights @ (means**2 + variances)) ** 2)]
        mean, sd = self.summary
        for j, (values, mass) in enumerate(self.hyperparameters, self.model.size):
            out.append(float(mass @ ((values - mean[j]) / sd[j]) ** 4))
        return np.array(out)

    @property
    def hyperparameters(self) -> list[tuple[Array, Array]]:
        """Values and probabilities of sigma (px) and tau at their nodes, if inferred."""
        out = []
        if self.model.infers_sigma:
            out.append((self.sigma, self.weights.sum(axis=0)))
        if self.model.infers_tau:
            out.append((np.exp(self.tau_rule.nodes), self.weights.sum(axis=1)))
        return out

    def _components(self, transform: Array) -> tuple[Array, Array, Array]:
        """``transform @ b`` as a mixture of normals: weights, means, variances.

        Nodes that together hold less than 1e-12 of the probability are left out.
        """
        heavy = self.weights > 1e-12 / self.weights.size
        tau, sigma = np.nonzero(heavy)
        weights = self.weights[heavy] / self.weights[heavy].sum()
        d, w = self.conditional.d[tau], self.conditional.w[tau]
        variance = self.sigma[sigma, None] ** 2
        total = self.conditional.precision * variance + d**2
        rows = (transform @ self.conditional.to_b)[tau]
        means = transform @ self.model.prior.mean + np.einsum("kqr,kr->kq", rows, d * w / total)
        return weights, means, np.einsum("kqr,kr->kq", rows**2, variance / total)

    def quantiles(self, transform: Array, probabilities: Array) -> Array:
        """Quantiles of linear functions of the amplitudes, ``(q, n_probabilities)``.

        Parameters
        ----------
        transform : Array
            The functions' coefficients, ``(q, p)``; for the monomial coefficients
            the map of ``model.factors.monomials``.
        probabilities : Array
            ``(n_probabilities,)``, in (0, 1).
        """
        weights, means, variances = self._components(transform)
        sds = np.sqrt(variances)
        lower = (means - 9 * sds).min(axis=0)[:, None] + np.zeros(len(probabilities))
        upper = (means + 9 * sds).max(axis=0)[:, None] + np.zeros(len(probabilities))
        for _ in range(60):  # bisection, down to rounding
            middle = (lower + upper) / 2
            z = (middle[None] - means[:, :, None]) / sds[:, :, None]
            below = np.einsum("k,kqj->qj", weights, ndtr(z)) < probabilities
            lower, upper = np.where(below, middle, lower), np.where(below, upper, middle)
        return np.asarray((lower + upper) / 2)

    def sigma_at_bounds(self) -> tuple[float, float]:
        """Posterior probability that sigma lies within 5 % of its lower, upper bound."""
        if not self.model.infers_sigma:
            return 0.0, 0.0
        lower, upper = self.model.noise.log_bounds
        nodes, mass = self.sigma_rule.nodes, self.weights.sum(axis=0)
        edge = float(np.log1p(NEAR_BOUND))
        return float(mass[nodes < lower + edge].sum()), float(mass[nodes > upper - edge].sum())


def exact_posterior(model: LinearModel) -> ExactPosterior:
    """Closed-form posterior and evidence of a linear Gaussian model.

    Parameters
    ----------
    model : LinearModel

    Returns
    -------
    ExactPosterior
        log_evidence to 1e-6 nat.
    """
    prior, noise = model.prior, model.noise
    if prior.infers_tau:
        tau_rule = interval(*prior.log_tau_bounds, TAU_NODES)
        conditional = Conditional.of(model, tau_rule.nodes)
    else:
        tau_rule = POINT
        conditional = Conditional.of(model, np.log([prior.tau if prior.tau is not None else 1.0]))
    log_prior = noise.log_prior() + prior.log_tau_density()

    def log_joint(log_sigma: Array) -> Array:
        return log_prior + conditional.log_likelihood(model, log_sigma)

    if noise.value is not None:
        values = log_joint(np.log([noise.value]))
        return ExactPosterior(model, POINT, tau_rule, conditional, values)
    lower, upper = noise.log_bounds
    edge = np.log1p(NEAR_BOUND)
    breaks = np.concatenate([[lower], np.linspace(lower + edge, upper - edge, 25), [upper]])
    sigma_rule, values = follow(log_joint, breaks)
    return ExactPosterior(model, sigma_rule, tau_rule, conditional, values)
