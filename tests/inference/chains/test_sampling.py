"""emcee on the ten thesis models: it reaches its rule and agrees with the closed form."""

from __future__ import annotations

from itertools import pairwise

import emcee
import numpy as np
import pytest
from scipy import stats

from bayescal.inference.chains.sampling import autocorrelation_time, quiet_sampler
from bayescal.inference.checked_posterior import sample_posterior
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from tests.helpers.brute_force import mixture_cdf, normal_grid
from tests.helpers.problems import STATED_R, THESIS_MODELS, make_axis, make_model, thesis_axis

ESS = 4000


def sampled(comparison, axis, order):
    return comparison.axes[axis][order].posterior


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_acceptance_is_above_95_percent(thesis_comparison, axis, order):
    assert sampled(thesis_comparison, axis, order).chain.acceptance > 0.95


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_autocorrelation_time_is_about_one(thesis_comparison, axis, order):
    """Independent draws would have 1; acceptance of 0.97 adds 0.06, estimation 0.1."""
    assert sampled(thesis_comparison, axis, order).chain.autocorrelation_time < 1.3


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_every_parameter_has_4000_effective_samples(thesis_comparison, axis, order):
    posterior = sampled(thesis_comparison, axis, order)
    assert posterior.converged
    assert min(p.ess_bulk for p in posterior.parameters) >= ESS
    assert min(p.ess_tail for p in posterior.parameters) >= ESS
    assert max(p.rhat for p in posterior.parameters) < 1.01


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_draws_agree_with_the_closed_form(thesis_comparison, axis, order):
    assert sampled(thesis_comparison, axis, order).agrees_with_exact


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_draws_have_the_brute_force_distribution(thesis_comparison, axis, order):
    """Kolmogorov-Smirnov of every parameter, thinned to every third draw.

    52 tests in all: at a level of 1e-5 each the family's is below 1e-3.
    """
    posterior = sampled(thesis_comparison, axis, order)
    model = posterior.exact.model
    grid = normal_grid(model, thesis_axis(axis))
    draws = posterior.chain.draws[:, ::3].reshape(-1, len(posterior.names))
    weights, means, sds = grid.mixture(model.factors.monomials.lead(order))
    columns = list(draws.T)
    for j in range(model.size):
        places = np.quantile(columns[j], np.linspace(0, 1, 60))
        below = [mixture_cdf(v, weights, means[:, j], sds[:, j]) for v in places]
        cdf = np.interp(columns[j], places, below)
        assert stats.kstest(cdf, "uniform").pvalue > 1e-5
    mass = grid.weights
    hyper = [(np.exp(grid.log_sigma), mass.sum(axis=0))]
    if model.infers_tau:
        hyper.append((np.exp(grid.log_tau), mass.sum(axis=1)))
    for column, (values, probability) in zip(columns[model.size :], hyper, strict=True):
        below = np.cumsum(probability) - probability / 2  # mid-node: half of its mass is below
        cdf = np.interp(column, values, below)
        assert stats.kstest(cdf, "uniform").pvalue > 1e-5


def test_reported_draws_are_the_sampled_ones_in_monomials(thesis_comparison):
    """Identity: numpy's conversion of each draw's Legendre series, exp of ln sigma, ln tau."""
    posterior = sampled(thesis_comparison, "c", 3)
    data = thesis_axis("c")
    domain = [data.x.min(), data.x.max()]
    for chain, draw in [(0, 0), (5, 17), (-1, -1)]:
        theta, reported = posterior.chain.theta[chain, draw], posterior.chain.draws[chain, draw]
        series = np.polynomial.Legendre(theta[:4], domain=domain)
        coefficients = series.convert(kind=np.polynomial.Polynomial).coef
        np.testing.assert_allclose(reported[:4], coefficients, rtol=1e-9)
        np.testing.assert_allclose(reported[4:], np.exp(theta[4:]), rtol=1e-12)


def test_log_prob_of_the_draws_is_that_of_the_target(thesis_comparison):
    posterior = sampled(thesis_comparison, "r", 4)
    chain = posterior.chain
    theta = chain.theta.reshape(-1, chain.theta.shape[2])
    truth = log_prob(posterior.exact.model, theta)
    np.testing.assert_allclose(chain.log_prob.ravel(), truth, rtol=0, atol=1e-8)


def test_intervals_and_errors_are_those_of_the_draws(thesis_comparison):
    """Independent tool: numpy's quantiles; the error of the mean from its own ESS."""
    posterior = sampled(thesis_comparison, "r", 4)
    for j, parameter in enumerate(posterior.parameters):
        draws = posterior.chain.draws[:, :, j].ravel()
        np.testing.assert_allclose(parameter.interval, np.quantile(draws, [0.025, 0.975]))
        assert parameter.mcse_mean == pytest.approx(draws.std() / np.sqrt(len(draws)), rel=0.25)


def test_intervals_hold_their_probability(thesis_comparison):
    """Mass between the ends by brute force: 0.95 within 5 errors of 0.0034 (4000 draws)."""
    posterior = sampled(thesis_comparison, "c", 2)
    model = posterior.exact.model
    weights, means, sds = normal_grid(model, thesis_axis("c")).mixture(
        model.factors.monomials.lead(2)
    )
    for j in range(3):
        ends = [
            mixture_cdf(v, weights, means[:, j], sds[:, j])
            for v in posterior.parameters[j].interval
        ]
        assert np.diff(ends)[0] == pytest.approx(0.95, abs=5 * 0.0034)


@pytest.mark.parametrize(
    "options",
    [
        {"sigma": 3.0},
        {"tau": 0.05},
        {"sigma": 3.0, "tau": 0.05},
        {"prior": "flat"},
        {"prior": "flat", "sigma": 3.0},
        {"prior": "stated", "stated": STATED_R},
    ],
    ids=["sigma", "tau", "both", "flat", "flat-sigma", "stated"],
)
def test_every_kind_of_model_is_sampled_soundly(options):
    model = make_model(thesis_axis("r"), 4, **options)
    posterior = sample_posterior(model, np.random.default_rng(12), 2000)
    assert posterior.converged
    assert posterior.agrees_with_exact
    assert posterior.chain.acceptance > 0.95


def test_a_factor_on_known_deviations_is_sampled_soundly():
    data = thesis_axis("c")
    sd = np.random.default_rng(4).uniform(1, 6, len(data))
    model = make_model(make_axis(data.x, data.t, data.size, sd=sd), 3, scale=True)
    posterior = sample_posterior(model, np.random.default_rng(12), 2000)
    assert posterior.converged
    assert posterior.agrees_with_exact


@pytest.mark.parametrize("n", [3, 5])
def test_heavy_tails_of_few_points_are_sampled_soundly(n):
    """As many points as coefficients, and two more: sigma ranges over decades."""
    x = np.linspace(-1, 1, n)
    data = make_axis(x, 500 + 300 * x + np.random.default_rng(1).normal(0, 3, n))
    posterior = sample_posterior(make_model(data, 2), np.random.default_rng(12), 2000)
    assert posterior.converged
    assert posterior.agrees_with_exact
    assert posterior.chain.acceptance > 0.9


@pytest.mark.parametrize("factor", [10.0, 1000.0])
@pytest.mark.parametrize("prior", ["field", "flat"])
def test_one_regressor_far_from_all_others_is_sampled_soundly(prior, factor):
    """A slip of the decimal point leaves columns that almost depend on one another."""
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 1, 30)
    t = 500 + 300 * x + rng.normal(0, 1, 30)
    x[-1] *= factor
    posterior = sample_posterior(make_model(make_axis(x, t), 5, prior=prior), rng, 1000)
    assert posterior.converged
    assert posterior.agrees_with_exact


def test_two_modes_in_sigma_are_visited_in_proportion():
    """Share of draws below 1 px against the exact one, to 4 binomial errors."""
    x = np.linspace(-1, 1, 20)
    curve = 500 + 300 * x + 12.1 * (1.5 * x**2 - 0.5)
    data = make_axis(x, curve + np.random.default_rng(5).normal(0, 0.1, 20))
    model = make_model(data, 2, tau=0.001)
    exact = exact_posterior(model)
    ((sigma, mass),) = exact.hyperparameters
    low = mass[sigma < 1].sum()
    assert 0.05 < low < 0.95  # both modes matter
    draws = sample_posterior(model, np.random.default_rng(12), ESS, exact).chain.draws
    share = (draws[:, :, -1] < 1).mean()
    assert abs(share - low) < 4 * np.sqrt(low * (1 - low) / draws[:, :, 0].size)


def test_autocorrelation_time_is_emcees():
    """Independent tool: emcee's integrated_time on an AR(1) process of time 3."""
    rng = np.random.default_rng(8)
    noise = rng.standard_normal((20, 3000))
    chains = np.zeros_like(noise)
    for i, j in pairwise(range(3000)):
        chains[:, j] = 0.5 * chains[:, i] + noise[:, j]
    truth = emcee.autocorr.integrated_time(chains.T[:, :, None], quiet=True)[0]
    assert autocorrelation_time(chains) == pytest.approx(truth, rel=1e-9)
    assert truth == pytest.approx(3.0, rel=0.1)


def test_an_interrupt_is_passed_on_in_silence(capfd):
    """emcee would print it with its trace: the negative control."""

    def interrupted(_):
        raise KeyboardInterrupt

    start = np.zeros((4, 1))
    ours = quiet_sampler(4, 1, interrupted, emcee.moves.StretchMove())
    with pytest.raises(KeyboardInterrupt):
        ours.compute_log_prob(start)
    assert capfd.readouterr() == ("", "")
    with pytest.raises(KeyboardInterrupt):
        emcee.EnsembleSampler(4, 1, interrupted, vectorize=True).compute_log_prob(start)
    assert "Traceback" in capfd.readouterr().err
