"""The density that emcee samples, written apart from the closed form that checks it."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import LOG_2PI, Array
from bayescal.linear.model import LinearModel


def log_prob(model: LinearModel, theta: Array) -> Array:
    r"""Log likelihood times prior of a linear Gaussian model, vectorised.

    With the factorisation, |t - X b|^2 = rss + |Q't - R b|^2: the cost of a draw is
    O(p^2), whatever the number of points.

    Parameters
    ----------
    theta : Array
        Amplitudes b_0 ... b_k (px), then ln sigma and ln tau where they are
        inferred, ``(n_draws, dimension)``.

    Returns
    -------
    Array
        ``(n_draws,)``, normalised likelihood and priors (a flat prior counts as 1);
        -inf outside the bounds of ln sigma and ln tau.
    """
    data = model.reduced
    prior, noise = model.prior, model.noise
    amplitudes = theta[:, : model.size]
    inside = np.ones(len(theta), dtype=bool)
    column = model.size
    if noise.value is None:
        log_sigma = theta[:, column]
        column += 1
        lower, upper = noise.log_bounds
        inside &= (log_sigma >= lower) & (log_sigma <= upper)
    else:
        log_sigma = np.full(len(theta), np.log(noise.value))
    if prior.infers_tau:
        log_tau = theta[:, column]
        lower, upper = prior.log_tau_bounds
        inside &= (log_tau >= lower) & (log_tau <= upper)
    else:
        log_tau = np.full(len(theta), np.log(prior.tau) if prior.tau is not None else 0.0)
    log_sigma = np.where(inside, log_sigma, 0.0)  # keeps exp() finite out of bounds
    log_tau = np.where(inside, log_tau, 0.0)

    misfit = data.qt - amplitudes @ data.r.T
    chi2 = (data.rss + np.einsum("ij,ij->i", misfit, misfit)) * np.exp(-2 * log_sigma)
    n = data.n
    log_likelihood = -0.5 * (chi2 + n * LOG_2PI) - n * log_sigma - data.log_sd
    log_density: Array = log_likelihood + noise.log_prior() + prior.log_tau_density()
    if prior.proper:
        sd = prior.deviations(log_tau)
        z = (amplitudes - prior.mean) / sd
        log_density -= (0.5 * (z**2 + LOG_2PI) + np.log(sd)).sum(axis=1)
    log_density[~inside] = -np.inf
    return log_density
