"""What scripts/benchmark peers has others sample is the posterior that the program samples."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.inference.target import log_prob
from scripts.peers.posterior import Posterior


@pytest.mark.parametrize("order", [1, 3, 5])
def test_the_density_is_ours(order):
    """Truth: the density that emcee samples, at least squares and far from it."""
    posterior, rng = Posterior(order), np.random.default_rng(order)
    steps = rng.standard_normal((50, len(posterior.names))) * np.geomspace(0.01, 3, 50)[:, None]
    theta = posterior.start + steps
    ours = log_prob(posterior.linear, theta)
    assert np.isfinite(ours).any()
    np.testing.assert_allclose(posterior.log_prob(theta), ours, rtol=1e-12, atol=1e-8)


@pytest.mark.parametrize("order", [1, 3])
def test_the_prior_transform_has_the_priors_density(order):
    """Truth: the density of what a uniform cube is mapped to, 1 / |d theta / d u|.

    The transform is triangular (amplitudes depend on ln tau, not the other way round), so the
    determinant is the product of central differences, each good to about 1e-7.
    """
    posterior = Posterior(order)
    u = np.random.default_rng(1).uniform(0.1, 0.9, (20, len(posterior.names)))
    log_slope, step = 0.0, 1e-5
    for j in range(u.shape[1]):
        ahead, behind = u.copy(), u.copy()
        ahead[:, j] += step
        behind[:, j] -= step
        slope = (posterior.from_unit(ahead) - posterior.from_unit(behind))[:, j] / (2 * step)
        log_slope = log_slope + np.log(slope)
    np.testing.assert_allclose(posterior.log_prior(posterior.from_unit(u)), -log_slope, atol=1e-6)
