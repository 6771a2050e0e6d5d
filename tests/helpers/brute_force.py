"""Evidence and posterior by brute force: another algebra, another quadrature.

Nothing here uses the package's factorisation, its singular values or its rules.
`dense_grid` takes the marginal of all n points at once, t ~ N(X m, sigma^2 I + X S X');
`normal_grid` the least-squares coefficients from the normal equations of Legendre
columns, b_hat ~ N(m, S + sigma^2 (X'X)^-1), which serves any n (columns of a condition
above a thousand cost it more than 1e-6 nat). Both sum over a fixed fine grid of composite
Gauss-Legendre panels in ln sigma and ln tau.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, ndtr

from bayescal.linear.model import LinearModel
from bayescal.polynomials.axis_data import AxisData
from tests.helpers.problems import legendre_columns, prior_deviations

LOG_2PI = np.log(2 * np.pi)


def panels(lower: float, upper: float, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Composite 8-point Gauss-Legendre rule with panels no wider than `width`.

    Its error is of order width^16 f^(16) / 1e21: for a Gaussian peak of deviation s,
    below 1e-11 of the integral at width = s and 1e-7 at width = 2 s.
    """
    count = int(np.ceil((upper - lower) / width))
    x, w = np.polynomial.legendre.leggauss(8)
    ends = np.linspace(lower, upper, count + 1)
    half = (ends[1:] - ends[:-1]) / 2
    nodes = (ends[:-1] + half)[:, None] + half[:, None] * x
    return nodes.ravel(), np.outer(half, w).ravel()


@dataclass
class Grid:
    """Log of likelihood times hyperpriors times weights, (n_tau, n_sigma)."""

    model: LinearModel
    data: AxisData
    log_tau: np.ndarray
    log_sigma: np.ndarray
    log_joint: np.ndarray

    @property
    def log_evidence(self) -> float:
        return float(logsumexp(self.log_joint))

    @property
    def weights(self) -> np.ndarray:
        return np.exp(self.log_joint - self.log_evidence)

    def mixture(self, transform: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`transform @ b` as a mixture of normals: weights, means, deviations.

        Normal equations in Legendre columns at each node; nodes that hold less than
        1e-24 of the probability are left out (few points leave heavy tails, and sigma^4
        ranges over 1e20, so that they bear on the fourth moment).
        """
        x, t = _weighted(self.model, self.data)
        weights = self.weights
        kept = weights > 1e-24
        taus, sigmas = np.nonzero(kept)
        precision = _precision(self.model, self.log_tau)[taus]
        variance = np.exp(2 * self.log_sigma[sigmas])
        a = (x.T @ x) / variance[:, None, None] + precision
        covariance = np.linalg.inv(a)
        m = self.model.prior.mean
        pull = (x.T @ (t - x @ m)) / variance[:, None]
        means = m + np.einsum("kij,kj->ki", covariance, pull)
        var = np.einsum("qi,kij,qj->kq", transform, covariance, transform)
        return weights[kept] / weights[kept].sum(), means @ transform.T, np.sqrt(var)


def _weighted(model: LinearModel, data: AxisData) -> tuple[np.ndarray, np.ndarray]:
    x, t = legendre_columns(data, model.order), data.t
    if data.sd is None:
        return x, t
    return x / data.sd[:, None], t / data.sd


def _precision(model: LinearModel, log_tau: np.ndarray) -> np.ndarray:
    if not model.prior.proper:
        return np.zeros((len(log_tau), model.size, model.size))
    deviations = [prior_deviations(model.prior, tau) for tau in np.exp(log_tau)]
    return np.array([np.diag(1 / s**2) for s in deviations])


def _axes(model: LinearModel, sigma_width: float, sigma_range, tau_width: float):
    """Nodes of ln tau and ln sigma, and the log of weights times hyperpriors."""
    prior = model.prior
    if prior.infers_tau:
        lower, upper = np.log([0.01 / prior.size, 0.5])
        log_tau, tau_weight = panels(lower, upper, tau_width)
        tau_weight = tau_weight / (upper - lower)
    else:
        log_tau, tau_weight = np.log([prior.tau if prior.tau is not None else 1.0]), np.ones(1)
    if model.noise.bounds is not None:
        lower, upper = np.log(model.noise.bounds)
        log_sigma, weight = panels(*(sigma_range or (lower, upper)), sigma_width)
        weight = weight / (upper - lower)
    else:
        log_sigma, weight = np.log([model.noise.value]), np.ones(1)
    return log_tau, log_sigma, np.log(tau_weight[:, None] * weight)


def dense_grid(model: LinearModel, data: AxisData, sigma_width=0.1, tau_width=0.2) -> Grid:
    """Grid from the dense n by n covariance of the points, by its spectrum at each tau.

    Rounding: eigenvalues are good to about 1e-8 px^2 here, so sigma must stay above
    0.1 px wherever there is mass.
    """
    log_tau, log_sigma, log_weight = _axes(model, sigma_width, None, tau_width)
    x, t = _weighted(model, data)
    noise = np.exp(2 * log_sigma)[:, None]
    rows = []
    for tau in np.exp(log_tau):
        s = prior_deviations(model.prior, tau)
        spectrum, vectors = np.linalg.eigh((x * s**2) @ x.T)
        y = vectors.T @ (t - x @ model.prior.mean)
        total = noise + np.maximum(spectrum, 0)
        rows.append(-0.5 * (LOG_2PI + np.log(total) + y**2 / total).sum(axis=1))
    log_sd = 0.0 if data.sd is None else np.log(data.sd).sum()
    return Grid(model, data, log_tau, log_sigma, np.array(rows) - log_sd + log_weight)


def normal_grid(
    model: LinearModel, data: AxisData, sigma_width=0.1, sigma_range=None, tau_width=0.2
) -> Grid:
    """Grid from b_hat ~ N(m, S + sigma^2 (X'X)^-1) and rss, at every node.

    `sigma_range` narrows ln sigma to where the mass is; what it drops must be
    negligible. A flat prior gives the integral of the likelihood over b.
    """
    log_tau, log_sigma, log_weight = _axes(model, sigma_width, sigma_range, tau_width)
    x, t = _weighted(model, data)
    n, p = x.shape
    gram = x.T @ x
    b_hat = np.linalg.solve(gram, x.T @ t)
    b_hat = b_hat + np.linalg.solve(gram, x.T @ (t - x @ b_hat))  # one step of refinement
    rss = float(((t - x @ b_hat) ** 2).sum()) if n > p else 0.0
    inverse = np.linalg.inv(gram)
    variance = np.exp(2 * log_sigma)
    log_sd = 0.0 if data.sd is None else np.log(data.sd).sum()
    rest = -(n - p) / 2 * (LOG_2PI + 2 * log_sigma) - rss / 2 / variance
    rest = rest - np.linalg.slogdet(gram)[1] / 2 - log_sd
    rows = np.zeros((len(log_tau), len(log_sigma)))
    if model.prior.proper:
        offset = b_hat - model.prior.mean
        for i, tau in enumerate(np.exp(log_tau)):
            s = prior_deviations(model.prior, tau)
            total = np.diag(s**2) + variance[:, None, None] * inverse
            # Divided by the prior's deviations, so that entries are of one size.
            root = np.linalg.cholesky(total / np.outer(s, s))
            z = np.linalg.solve(root, np.broadcast_to((offset / s)[:, None], (*root.shape[:2], 1)))
            log_det = 2 * np.log(np.einsum("kii->ki", root)).sum(axis=1) + 2 * np.log(s).sum()
            rows[i] = -0.5 * (p * LOG_2PI + log_det + (z[:, :, 0] ** 2).sum(axis=1))
    return Grid(model, data, log_tau, log_sigma, rows + rest + log_weight)


def moments(weights, means, sds):
    """Mean, sd and kurtosis of mixtures of normals, column by column."""
    mean = weights @ means
    d = means - mean
    variance = weights @ (d**2 + sds**2)
    fourth = weights @ (d**4 + 6 * d**2 * sds**2 + 3 * sds**4)
    return mean, np.sqrt(variance), fourth / variance**2


def mixture_cdf(value: float, weights, means, sds) -> float:
    """Distribution function of one mixture of normals."""
    return float(weights @ ndtr((value - means) / sds))
