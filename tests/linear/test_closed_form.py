"""Evidence of the thesis models against brute force and importance sampling."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from bayescal.inference.proposals.proposal import LinearProposal
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from tests.helpers.brute_force import dense_grid, normal_grid
from tests.helpers.problems import (
    STATED_R,
    THESIS_MODELS,
    legendre_columns,
    make_axis,
    make_model,
    prior_deviations,
    thesis_axis,
)

# The dense grid's own error: eigenvalues good to 1e-8 of sigma^2, over 57 points.
BRUTE = 5e-9


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_log_evidence_is_the_brute_force_integral(axis, order, tau):
    """To 1e-6 nat, and within the error it claims."""
    data = thesis_axis(axis)
    model = make_model(data, order, tau=tau)
    exact, truth = exact_posterior(model), dense_grid(model, data).log_evidence
    assert abs(exact.log_evidence - truth) < 1e-6
    assert abs(exact.log_evidence - truth) < exact.log_evidence_error + BRUTE


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_claimed_error_of_the_thesis_evidence_is_small(axis, order):
    """The bound is that of a rule of half the nodes, and still far below 1e-4 nat."""
    assert exact_posterior(make_model(thesis_axis(axis), order)).log_evidence_error < 1e-4


@pytest.mark.parametrize("order", [1, 3, 5])
def test_log_evidence_of_a_stated_prior_is_the_brute_force_integral(order):
    data = thesis_axis("r")
    model = make_model(data, order, prior="stated", stated=STATED_R)
    exact, truth = exact_posterior(model), dense_grid(model, data).log_evidence
    assert abs(exact.log_evidence - truth) < min(1e-6, exact.log_evidence_error + BRUTE)


@pytest.mark.parametrize("order", [1, 3])
def test_log_evidence_with_known_deviations_is_scipys_multivariate_normal(order):
    """Closed form: with sigma and tau fixed the data are N(X m, D + X S X')."""
    rng = np.random.default_rng(4)
    data = thesis_axis("c")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    model = make_model(data, order, tau=0.02)
    x = legendre_columns(data, order)
    scale = prior_deviations(model.prior, 0.02)
    covariance = np.diag(data.sd**2) + (x * scale**2) @ x.T
    truth = stats.multivariate_normal(x @ model.prior.mean, covariance).logpdf(data.t)
    assert abs(exact_posterior(model).log_evidence - truth) < BRUTE


@pytest.mark.parametrize("tau", [None, 0.02])
def test_log_evidence_averages_over_a_factor_on_the_deviations(tau):
    rng = np.random.default_rng(4)
    data = thesis_axis("c")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    model = make_model(data, 3, tau=tau, scale=True)
    exact, truth = exact_posterior(model), normal_grid(model, data).log_evidence
    assert abs(exact.log_evidence - truth) < min(1e-6, exact.log_evidence_error + BRUTE)


@pytest.mark.parametrize("sigma", [1.0, 3.4])
def test_log_evidence_with_known_sigma_averages_over_tau(sigma):
    data = thesis_axis("c")
    model = make_model(data, 4, sigma=sigma)
    exact, truth = exact_posterior(model), normal_grid(model, data).log_evidence
    assert abs(exact.log_evidence - truth) < min(1e-6, exact.log_evidence_error + BRUTE)


def test_the_two_brute_forces_agree():
    """The test's own check: all points at once, and coefficients with their rss."""
    data = thesis_axis("c")
    model = make_model(data, 3)
    dense, normal = dense_grid(model, data), normal_grid(model, data)
    assert abs(dense.log_evidence - normal.log_evidence) < BRUTE
    finer = normal_grid(model, data, sigma_width=0.05, tau_width=0.1)
    assert abs(finer.log_evidence - normal.log_evidence) < 1e-9


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_log_evidence_is_the_importance_sampled_one(axis, order, tau):
    """Within four standard errors, each below a hundredth of a nat."""
    model = make_model(thesis_axis(axis), order, tau=tau)
    exact = exact_posterior(model)
    proposal = LinearProposal(exact)
    theta = proposal.draw(np.random.default_rng(order), 20_000)
    log_ratio = log_prob(model, theta) - proposal.log_density(theta)
    ratio = np.exp(log_ratio - log_ratio.max())
    error = ratio.std() / ratio.mean() / np.sqrt(len(ratio))
    sampled = logsumexp(log_ratio) - np.log(len(ratio))
    assert error < 0.01
    assert abs(sampled - exact.log_evidence) < 4 * error


def test_a_flat_prior_has_no_evidence():
    exact = exact_posterior(make_model(thesis_axis("c"), 2, prior="flat"))
    assert exact.log_evidence is None
    assert exact.log_evidence_error is None
