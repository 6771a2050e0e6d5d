r"""Posterior of a linear Gaussian model in closed form: the oracle.

With the notation of the evidence module, b = m + S^{1/2} V a with
a_j | w ~ N(D_j w_j / (sigma^2 + D_j^2), sigma^2 / (sigma^2 + D_j^2)) (Bishop 2006,
3.3); sigma and tau are averaged over the nodes of the evidence's quadrature.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import logsumexp, ndtr

from bayescal.arrays import Array
from bayescal.linear.evidence import NEAR_BOUND, Projection, log_joint, tau_rule
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import FINE, Rule

# Nodes that together hold less than this of the probability can be left out.
NEGLIGIBLE = 1e-12


@dataclass(frozen=True, eq=False)
class Conditional:
    """The amplitudes' normal given sigma, at each node of tau.

    Attributes
    ----------
    d, w : Array
        Singular values and projected data, ``(n_tau, p)``.
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
    def of(cls, projection: Projection) -> Conditional:
        """Collect what a projection says of the amplitudes."""
        s, vt = projection.s, projection.vt
        return cls(
            projection.d,
            projection.w,
            s[:, :, None] * vt.transpose(0, 2, 1),
            vt / s[:, None, :],
            -np.log(s).sum(axis=1),
            projection.precision,
        )

    def moments(self, variance: Array) -> tuple[Array, Array]:
        """Mean and variance of each a_j given sigma^2, ``(n_tau, n_sigma, p)``.

        Parameters
        ----------
        variance : Array
            sigma^2, ``(n_sigma,)``.
        """
        d, w, v = self.d[:, None, :], self.w[:, None, :], variance[:, None]
        total = self.precision * v + d**2
        return d * w / total, v / total


@dataclass(frozen=True, eq=False)
class ExactPosterior:
    """Posterior of a linear Gaussian model without sampling.

    Attributes
    ----------
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
    def log_weights(self) -> Array:
        """Log posterior probability of each node, ``(n_tau, n_sigma)``."""
        product = self.tau_rule.weights[:, None] * self.sigma_rule.weights
        return np.log(product) + self.log_joint - self.log_integral

    @cached_property
    def weights(self) -> Array:
        """Posterior probability of each node, ``(n_tau, n_sigma)``, summing to 1."""
        shares = np.exp(self.log_weights)
        return np.asarray(shares / shares.sum())  # logs of many points round to more than 1

    @cached_property
    def sigma(self) -> Array:
        """Sigma at its nodes, ``(n_sigma,)``, px."""
        if self.model.noise.value is not None:
            return np.array([self.model.noise.value])
        return np.exp(self.sigma_rule.nodes)

    @cached_property
    def _amplitudes(self) -> tuple[Array, Array]:
        mean, variance = self.conditional.moments(self.sigma**2)
        weights, to_b = self.weights, self.conditional.to_b
        node_mean = np.einsum("tpq,tsq->tsp", to_b, mean)  # of b, less the prior mean
        centre = np.einsum("ts,tsp->p", weights, node_mean)
        # Within the nodes and between them, as rows whose squares sum to the covariance:
        # forming it would halve the digits of points far from all others.
        spread = np.sqrt(np.einsum("ts,tsq->tq", weights, variance))
        within = (to_b * spread[:, None, :]).transpose(0, 2, 1).reshape(-1, len(centre))
        heavy = weights > NEGLIGIBLE / weights.size
        between = np.sqrt(weights[heavy])[:, None] * (node_mean - centre)[heavy]
        triangle = np.linalg.qr(np.concatenate([within, between]), mode="r")
        root = triangle.T * np.where(np.diag(triangle) < 0, -1.0, 1.0)
        return self.model.prior.mean + centre, root

    @property
    def mean(self) -> Array:
        """Posterior mean of the amplitudes, ``(p,)``, px."""
        return self._amplitudes[0]

    @property
    def root(self) -> Array:
        """Cholesky root of the amplitudes' posterior covariance, ``(p, p)``, px."""
        return self._amplitudes[1]

    @property
    def covariance(self) -> Array:
        """Posterior covariance of the amplitudes, ``(p, p)``, px^2."""
        return self.root @ self.root.T

    @cached_property
    def summary(self) -> tuple[Array, Array]:
        """Mean and sd of every reported parameter, in the order of ``model.names``."""
        monomials = self.model.factors.monomials
        means = [*monomials.apply(self.mean)]
        sds = [*np.linalg.norm(monomials.apply(self.root), axis=1)]
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

        Negligible nodes are left out.
        """
        heavy = self.weights > NEGLIGIBLE / self.weights.size
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

    def intervals(self, probability: float) -> Array:
        """Central interval of every reported parameter, in the order of ``model.names``.

        Those of sigma and tau interpolate the cumulative probability between their nodes.

        Returns
        -------
        Array
            ``(n_names, 2)``.
        """
        ends = np.array([1 - probability, 1 + probability]) / 2
        transform = self.model.factors.monomials.lead(self.model.order)
        rows = [*self.quantiles(transform, ends)]
        rows += [np.interp(ends, mass.cumsum() - mass / 2, v) for v, mass in self.hyperparameters]
        return np.array(rows)

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

    Returns
    -------
    ExactPosterior
        log_evidence to 1e-6 nat.
    """
    rule, log_tau = tau_rule(model.prior, FINE)
    projection = Projection.of(model.reduced, model.prior, log_tau)
    sigma_rule, values = log_joint(model.reduced, projection, model.noise, model.prior, FINE)
    return ExactPosterior(model, sigma_rule, rule, Conditional.of(projection), values)
