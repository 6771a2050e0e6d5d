"""Importance and bridge sampling: truths, and what must not be trusted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, norm

from bayescal.inference.estimate import bridge_sampling, estimate_evidence, from_weights

LOG_Z = -7.25
N = 4000


def log_weights(rng, target, proposal, n=N):
    """Log weights at draws of the proposal and of the target, with Z in the target."""
    apart = proposal.rvs(n, random_state=rng), target.rvs(n, random_state=rng)
    return [LOG_Z + target.logpdf(x) - proposal.logpdf(x) for x in apart]


def test_bridge_sampling_finds_the_integral_with_the_error_it_states():
    z = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        found, error = bridge_sampling(*log_weights(rng, norm(0.5, 1.2), norm(0, 1.5), 500), 500)
        z.append((found - LOG_Z) / error)
    assert chi2.ppf(1e-4, 200) < np.sum(np.square(z)) < chi2.isf(1e-4, 200)


def test_importance_sampling_finds_the_integral_with_the_error_it_states():
    z = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        w, p = log_weights(rng, norm(0.5, 1.0), norm(0, 1.5))
        estimate = estimate_evidence(w, p, N)
        z.append((estimate.log_evidence - LOG_Z) / estimate.error)
        assert estimate.certain
    assert chi2.ppf(1e-4, 100) < np.sum(np.square(z)) < chi2.isf(1e-4, 100)


def test_the_effective_fraction_is_that_of_two_normals():
    """1 / E[w^2] in closed form: sqrt(2 a - 1) / a with a = (proposal / target sd)^2."""
    w, p = log_weights(np.random.default_rng(0), norm(0, 1), norm(0, 1.5), 40000)
    a = 1.5**2
    fraction = estimate_evidence(w, p, 40000).effective_fraction
    assert fraction == pytest.approx(np.sqrt(2 * a - 1) / a, abs=0.01)


@pytest.mark.parametrize("width", [0.2, 0.4])
def test_a_proposal_far_too_narrow_warns(width):
    for seed in range(20):
        rng = np.random.default_rng(seed)
        estimate = estimate_evidence(*log_weights(rng, norm(0, 1), norm(0, width)), N)
        assert not estimate.certain


def test_a_mode_that_the_proposal_misses_is_seen_by_the_bridge():
    """Weights alone look perfect: every draw is near the one mode the proposal knows."""
    rng = np.random.default_rng(0)
    near, far = norm(0, 1), norm(30, 1)
    drawn = near.rvs(N, random_state=rng)
    posterior = np.append(near.rvs(N // 2, random_state=rng), far.rvs(N // 2, random_state=rng))

    def weights(x):
        target = np.logaddexp(near.logpdf(x), far.logpdf(x)) - np.log(2)
        return LOG_Z + target - near.logpdf(x)

    estimate = estimate_evidence(weights(drawn), weights(posterior), N)
    assert estimate.error < 0.01
    assert estimate.log_evidence == pytest.approx(LOG_Z - np.log(2), abs=0.01)
    assert any("bridge" in w for w in estimate.warnings)


def test_draws_of_another_density_are_seen_by_the_bridge():
    rng = np.random.default_rng(0)
    target, other, proposal = norm(0, 1), norm(1, 1), norm(0, 1.3)
    w, _ = log_weights(rng, target, proposal)
    x = other.rvs(N, random_state=rng)
    wrong = LOG_Z + target.logpdf(x) - proposal.logpdf(x)
    assert any("bridge" in text for text in estimate_evidence(w, wrong, N).warnings)


def test_an_error_over_a_tenth_of_a_nat_warns():
    rng = np.random.default_rng(2)
    estimate = estimate_evidence(*log_weights(rng, norm(0, 1), norm(0, 20), 400), 400)
    assert estimate.error > 0.1
    assert any("Monte Carlo error" in w for w in estimate.warnings)


def test_no_draw_inside_the_support():
    estimate = estimate_evidence(np.full(10, -np.inf), np.zeros(10), 10)
    assert estimate.log_evidence == -np.inf
    assert not estimate.certain


def test_weights_without_a_bridge_are_judged_all_the_same():
    """A proposal beside the posterior warns; one that fits does not, and has the same evidence."""
    rng = np.random.default_rng(0)
    beside = from_weights(log_weights(rng, norm(4, 1), norm(0, 1.2), 600)[0])
    assert not beside.certain
    both = log_weights(rng, norm(0.5, 1), norm(0, 1.5), 600)
    found = from_weights(both[0])
    assert found.certain
    assert found.log_evidence == estimate_evidence(*both, 600).log_evidence
    assert from_weights(np.full(600, -np.inf)).warnings
