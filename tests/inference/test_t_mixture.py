"""The proposal against scipy, and what it is fitted to."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import kstest, multivariate_t, t

from bayescal.inference.t_mixture import TMixture, cholesky

ROOTS = np.array([[[1.0, 0.0], [0.5, 2.0]], [[0.1, 0.0], [-0.3, 0.2]]])
MIXTURE = TMixture(
    np.array([0.7, 0.3]), np.array([[0.0, 1.0], [5.0, -4.0]]), ROOTS, np.array([3.0, 8.0])
)


def test_density_is_that_of_scipy():
    theta = np.random.default_rng(0).normal(0, 5, (200, 2))
    parts = [
        multivariate_t(m, r @ r.T, df=nu).logpdf(theta)
        for m, r, nu in zip(MIXTURE.means, ROOTS, MIXTURE.dof, strict=True)
    ]
    expected = logsumexp(np.array(parts) + np.log(MIXTURE.weights)[:, None], axis=0)
    np.testing.assert_allclose(MIXTURE.log_density(theta), expected, rtol=1e-12)


def test_draws_have_its_marginals():
    drawn = MIXTURE.draw(np.random.default_rng(1), 20000)
    for j in range(2):

        def cdf(x, j=j):
            scale = np.linalg.norm(ROOTS[:, j], axis=1)
            parts = zip(MIXTURE.weights, MIXTURE.means[:, j], scale, MIXTURE.dof, strict=True)
            return sum(w * t(nu, m, s).cdf(x) for w, m, s, nu in parts)

        assert kstest(drawn[:, j], cdf).pvalue > 1e-4


def test_fitting_weighted_draws_recovers_the_mixture_they_came_from():
    """Draws of a broad density, weighted, are as good as draws of the mixture."""
    rng = np.random.default_rng(2)
    broad = TMixture(np.ones(1), np.array([[2.0, -1.0]]), 5 * np.eye(2)[None], np.array([3.0]))
    theta = broad.draw(rng, 20000)
    weights = np.exp(MIXTURE.log_density(theta) - broad.log_density(theta))
    first = TMixture(
        np.full(2, 0.5), MIXTURE.means + 0.7, np.repeat(np.eye(2)[None], 2, axis=0), MIXTURE.dof
    )
    fitted = first.refitted(theta, weights / weights.sum(), 40, 0.0)
    effective = weights.sum() ** 2 / (weights**2).sum()
    error = 5 / np.sqrt(0.3 * effective)  # five relative errors of the rarer component
    np.testing.assert_allclose(fitted.weights, MIXTURE.weights, atol=error)
    np.testing.assert_allclose(fitted.means[0], MIXTURE.means[0], atol=2.1 * error)
    np.testing.assert_allclose(fitted.means[1], MIXTURE.means[1], atol=0.4 * error)
    np.testing.assert_allclose(fitted.roots[0], ROOTS[0], atol=2.1 * error)


@pytest.mark.parametrize("scale", [1.0, 1e-12, 1e12])
def test_root_of_a_covariance(scale):
    root = np.array([[2.0, 0, 0], [1, 3, 0], [-1, 0.5, 0.25]])
    np.testing.assert_allclose(cholesky(scale**2 * root @ root.T), scale * root, rtol=1e-9)


def test_root_of_a_singular_covariance_is_finite_and_close():
    column = np.array([1.0, 2.0, 3.0])
    singular = np.outer(column, column)
    root = cholesky(singular)
    assert (np.diag(root) > 0).all()
    np.testing.assert_allclose(root @ root.T, singular, atol=1e-9)
