"""The general path against densities whose integral and moments are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, kstest, norm

from bayescal.comparison.criteria.leave_one_out import leave_one_out
from bayescal.comparison.criteria.psis import sampled_leave_one_out
from bayescal.errors import InputError
from bayescal.inference.optimum import find_modes
from bayescal.inference.sampled_posterior import sample_model, shares_differ
from bayescal.linear.closed_form import exact_posterior
from tests.helpers.known_densities import (
    LOG_Z,
    Banana,
    HalfSpace,
    HeavyTailed,
    Known,
    Normal,
    TwoModes,
    Wrapped,
)
from tests.helpers.problems import make_axis, make_model, thesis_axis

DENSITIES = [
    Normal(2), Normal(6), Normal(12), HeavyTailed(4), Banana(2), Banana(6), HalfSpace(3),
    TwoModes(2), TwoModes(5),
]  # fmt: skip
# The largest of some dozens of normal deviates stays below this but once in 10^4.
ERRORS = 5.0


def deviations(posterior, means, sds):
    """Distances of means and sds from the truth, in Monte Carlo standard errors."""
    flat = posterior.chain.draws.reshape(-1, len(means))
    out = []
    for j, found in enumerate(posterior.chain.diagnostics):
        z = (flat[:, j] - means[j]) / sds[j]
        out.append(z.mean() * np.sqrt(found.ess_mean))
        spread = np.std(z**2) / np.sqrt(found.ess_sd)
        out.append((np.mean(z**2) - 1) / spread)
    return np.abs(out)


@pytest.mark.parametrize("model", DENSITIES, ids=repr)
def test_integral_and_moments_of_known_densities(model):
    posterior = sample_model(model, np.random.default_rng(3), 2000)
    estimate = posterior.estimate
    assert posterior.converged
    assert estimate.warnings == ()
    assert estimate.error < 0.01
    assert abs(posterior.log_evidence - LOG_Z) < ERRORS * estimate.error
    assert abs(estimate.bridge - LOG_Z) < ERRORS * estimate.bridge_error
    assert deviations(posterior, model.mean, model.sd).max() < ERRORS


def test_the_check_of_moments_sees_a_deviation_ten_percent_off():
    model = Normal(2)
    posterior = sample_model(model, np.random.default_rng(3), 2000)
    assert deviations(posterior, model.mean, 1.1 * model.sd).max() > ERRORS


def test_stated_errors_of_the_evidence_are_its_spread_over_seeds():
    found = [sample_model(Banana(3), np.random.default_rng(s), 400).estimate for s in range(10)]
    distance = sum(((e.log_evidence - LOG_Z) / e.error) ** 2 for e in found)
    assert chi2.ppf(1e-4, 10) < distance < chi2.isf(1e-4, 10)


def test_the_masses_of_two_modes():
    posterior = sample_model(TwoModes(3), np.random.default_rng(5), 4000)
    assert len(posterior.modes) == 2
    right = posterior.chain.theta[..., 0] > 0
    ess = min(d.ess_bulk for d in posterior.chain.diagnostics)
    assert abs(right.mean() - 0.8) < ERRORS * np.sqrt(0.8 * 0.2 / ess)


@pytest.mark.parametrize(
    ("by_weights", "by_draws", "differ"),
    [
        (0.2, 0.2, False),
        (0.2, 0.23, False),
        (0.2, 0.3, True),
        (0.0, 0.001, False),
        (0.0, 0.005, True),  # eight deviations away: it widens them by a seventh
    ],
)
def test_a_mode_that_the_chains_hold_otherwise_than_the_weights_is_named(
    by_weights, by_draws, differ
):
    model = TwoModes(1)
    modes = find_modes(model.log_prob, model.starts())  # the right one first
    rng = np.random.default_rng(0)
    fresh, drawn = (
        rng.normal(np.where(np.arange(4000) < share * 4000, -4.0, 4.0)[:, None], 0.9)
        for share in (by_weights, by_draws)
    )
    found = shares_differ(modes, fresh, np.zeros(4000), drawn, 1000)
    assert bool(found) == differ
    if differ:
        side = f"{100 * by_draws:.1f}% by the draws", f"{100 - 100 * by_draws:.1f}% by the draws"
        assert any(words in found[0] for words in side)


def test_draws_follow_the_density_itself():
    model = Normal(3)
    posterior = sample_model(model, np.random.default_rng(11), 4000)
    z = (posterior.chain.draws - model.mean) / model.sd
    apart = z[:, ::12]  # over six autocorrelation times: independent but for 1 in 400
    for j in range(3):
        assert kstest(apart[..., j].ravel(), norm.cdf).pvalue > 1e-4


@pytest.mark.parametrize(("axis", "order", "sigma"), [("r", 4, None), ("c", 1, None), ("r", 3, 4)])
def test_a_linear_model_through_the_general_path_equals_its_closed_form(axis, order, sigma):
    model = make_model(thesis_axis(axis), order, sigma=sigma)
    exact = exact_posterior(model)
    posterior = sample_model(Wrapped(model, thesis_axis(axis)), np.random.default_rng(1), 4000)
    assert posterior.converged
    assert posterior.estimate.certain
    assert posterior.log_evidence_error < 0.01
    distance = posterior.log_evidence - exact.log_evidence
    assert abs(distance) < ERRORS * posterior.log_evidence_error
    means, sds = exact.summary
    assert deviations(posterior, means, sds).max() < ERRORS


def test_leave_one_out_from_draws_equals_its_closed_form():
    x = np.linspace(-0.5, 0.5, 40)  # no point sticks out, so that all weights' tails are good
    data = make_axis(x, 400 + 300 * x + np.random.default_rng(2).normal(0, 2, 40))
    model = make_model(data, 2)
    exact = leave_one_out(data, exact_posterior(model))
    posterior = sample_model(Wrapped(model, data), np.random.default_rng(1), 4000)
    sampled = sampled_leave_one_out(posterior, posterior.model.log_likelihood)
    assert sampled.unreliable == ()
    assert abs(sampled.elpd - exact.elpd) < ERRORS * sampled.mcse
    assert sampled.p_eff - exact.p_eff == pytest.approx(0, abs=ERRORS * sampled.mcse)
    assert sampled.se == pytest.approx(exact.se, rel=0.02)  # its terms' errors are 1 % of it


def test_leave_one_out_needs_units():
    posterior = sample_model(Wrapped(make_model(thesis_axis("c"), 1), thesis_axis("c")),
                             np.random.default_rng(1), 400)  # fmt: skip
    one = Wrapped(posterior.model.model, posterior.model.data)
    object.__setattr__(posterior, "model", OneUnit(one))
    assert sampled_leave_one_out(posterior, posterior.model.log_likelihood) is None


class OneUnit:
    """All data as one unit."""

    def __init__(self, of):
        self.of = of

    def log_likelihood(self, full):
        return self.of.log_likelihood(full).sum(axis=1, keepdims=True)


def test_the_same_seed_gives_the_same_bytes():
    one, two = (sample_model(Banana(2), np.random.default_rng(7), 400) for _ in range(2))
    assert one.chain.draws.tobytes() == two.chain.draws.tobytes()
    assert one.estimate == two.estimate
    other = sample_model(Banana(2), np.random.default_rng(8), 400)
    assert one.chain.draws.tobytes() != other.chain.draws.tobytes()


class Nowhere(Known):
    """Zero density everywhere."""

    def log_prob(self, theta):
        return np.full(len(theta), -np.inf)


def test_a_density_that_is_zero_at_every_start_is_refused():
    with pytest.raises(InputError, match="likelihood is zero"):
        sample_model(Nowhere(2), np.random.default_rng(0), 400)
