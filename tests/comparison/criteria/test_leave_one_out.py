"""Exact leave-one-out against refitting without each point, and against the draws.

The truth of elpd_i is ln Z(all) - ln Z(all but i): each set factorised from scratch in
Bonnet's basis on the domain, and with the prior, of all points.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from bayescal.comparison.criteria import psis
from bayescal.comparison.criteria.leave_one_out import leave_one_out, paired_difference
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from tests.helpers.cases import all_but, curve, refitted_evidence
from tests.helpers.problems import STATED_R, THESIS_MODELS, make_axis, make_model, thesis_axis

# Two quadratures good to 3e-9 nat each, and rounding of log evidences of some 100 nat.
CLOSE = 1e-8


def rule_of(model: LinearModel, data: AxisData, stated=None) -> PriorRule:
    prior = model.prior
    return PriorRule(prior.name, data.size, data.size / 2, prior.tau, stated)


def truth(data: AxisData, model: LinearModel, points=None, stated=None) -> np.ndarray:
    """Pointwise elpd by refitting."""
    n, rule = len(data), rule_of(model, data, stated)
    whole = refitted_evidence(data, model.order, np.arange(n), model.noise, rule)
    rest = [
        refitted_evidence(data, model.order, all_but(n, i), model.noise, rule)
        for i in (range(n) if points is None else points)
    ]
    return whole - np.array(rest)


def check(data: AxisData, model: LinearModel, stated=None, close=CLOSE):
    found = leave_one_out(data, exact_posterior(model))
    np.testing.assert_allclose(found.pointwise, truth(data, model, None, stated), atol=close)
    return found


def with_noise(model: LinearModel, noise: NoiseLevel) -> LinearModel:
    return dataclasses.replace(model, noise=noise)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_refitting_without_each_point_equals_leave_one_out(axis, order):
    data = thesis_axis(axis)
    check(data, make_model(data, order))


@pytest.mark.parametrize("sigma", [0.8, 4.0])
@pytest.mark.parametrize("order", [1, 4])
def test_refitting_equals_leave_one_out_at_known_sigma(order, sigma):
    """At 0.8 px the misfit of order 1 is 80 sigma: terms of hundreds of nat."""
    data = thesis_axis("r")
    check(data, make_model(data, order, sigma=sigma))


@pytest.mark.parametrize("sigma", [None, 4.0])
@pytest.mark.parametrize("order", [1, 5])
def test_refitting_equals_leave_one_out_under_a_flat_prior(order, sigma):
    data = thesis_axis("c")
    check(data, make_model(data, order, sigma=sigma, prior="flat"))


@pytest.mark.parametrize("noise", [NoiseLevel.known(1.0), NoiseLevel.scale()])
@pytest.mark.parametrize("order", [1, 4])
def test_refitting_equals_leave_one_out_with_deviations_per_point(order, noise):
    data = thesis_axis("r")
    sd = np.random.default_rng(2).uniform(1, 8, len(data))
    data = dataclasses.replace(data, sd=sd)
    check(data, with_noise(make_model(data, order), noise))


def test_refitting_equals_leave_one_out_under_a_stated_prior_and_a_fixed_tau():
    data = thesis_axis("r")
    check(data, make_model(data, 4, prior="stated", stated=STATED_R), STATED_R)
    check(data, make_model(data, 4, tau=0.003))


@pytest.mark.parametrize("size", [15.0, 100.0, 800.0])
@pytest.mark.parametrize("order", [1, 4])
def test_refitting_equals_leave_one_out_with_a_gross_outlier(order, size):
    """Without it sigma falls to where the full posterior has no node."""
    data = thesis_axis("r")
    t = data.t.copy()
    t[20] += size
    data = dataclasses.replace(data, t=t)
    found = check(data, make_model(data, order))
    if size >= 100:
        assert 20 in found.refitted
        assert found.pointwise.argmin() == 20


@pytest.mark.parametrize("size", [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 20.0])
def test_refitting_equals_leave_one_out_wherever_refits_begin(size):
    """Outliers of 2 to 20 sd among 15 points: just short of a refit, and just beyond."""
    data = curve(15, [480, 300, 5], 1.0, seed=3)
    t = data.t.copy()
    t[4] += size
    data = dataclasses.replace(data, t=t)
    check(data, make_model(data, 2))


@pytest.mark.parametrize("size", [3.0, 10.0, 100.0])
def test_refitting_equals_leave_one_out_of_an_outlying_end(size):
    """An end of the domain has leverage: 0.5 at order 3 of 12 points."""
    data = curve(12, [480, 300, 5], 1.0, seed=4)
    t = data.t.copy()
    t[-1] += size
    data = dataclasses.replace(data, t=t)
    check(data, make_model(data, 3))


@pytest.mark.parametrize("spare", [0, 1, 2])
@pytest.mark.parametrize("order", [1, 3])
def test_refitting_equals_leave_one_out_with_hardly_more_points_than_coefficients(order, spare):
    """1 - leverage is down to (0.01 / 500)^2 = 4e-10 there: 2e-7 of each term is rounding."""
    data = curve(order + 1 + spare, [480, 300, 5, 1], 1.0)
    check(data, make_model(data, order), close=1e-5)


@pytest.mark.parametrize("sigma", [None, 1.0])
def test_no_leave_one_out_of_as_many_points_as_coefficients_under_a_flat_prior(sigma):
    """Closed form: p - 1 points leave a flat posterior improper, so nothing is predicted."""
    data = curve(4, [480, 300, 5, 1], 1.0)
    assert leave_one_out(data, exact_posterior(make_model(data, 3, sigma=sigma, prior="flat"))) is (
        None
    )


@pytest.mark.parametrize("sigma", [None, 1.0])
def test_refitting_equals_leave_one_out_of_one_point_more_under_a_flat_prior(sigma):
    data = curve(5, [480, 300, 5, 1], 1.0)
    check(data, make_model(data, 3, sigma=sigma, prior="flat"), close=1e-7)


@pytest.mark.parametrize("sigma", [None, 1.0])
def test_no_leave_one_out_where_a_point_alone_determines_a_coefficient_under_a_flat_prior(sigma):
    """Without the one point at x = 0.6 two distinct regressors are left to three coefficients.

    Its leverage is 1: the posterior without it is improper, whatever n is.
    """
    x = np.r_[np.zeros(6), np.full(5, 0.3), 0.6]
    t = 500 + 300 * x + np.random.default_rng(1).standard_normal(12)
    model = make_model(make_axis(x, t), 2, sigma=sigma, prior="flat")
    assert leave_one_out(make_axis(x, t), exact_posterior(model)) is None


@pytest.mark.parametrize("sigma", [1e-3, 1e-4, 1e-6])
def test_refitting_equals_leave_one_out_where_sigma_is_far_too_small(sigma):
    """n = p at known sigma: 1 - leverage is down to 4e-18, below rounding.

    elpd_i grows to (residual / prior deviation)^2, still of order 1 to 10.
    """
    data = curve(4, [480, 300, 5, 1], 1.0)
    check(data, make_model(data, 3, sigma=sigma), close=1e-5)


def test_sum_standard_error_and_paired_difference_equal_their_definitions():
    """elpd = sum, SE = sqrt(n) sd with n - 1 in it, of the terms and of their differences."""
    data = thesis_axis("r")
    one, other = (leave_one_out(data, exact_posterior(make_model(data, k))) for k in (4, 2))
    n = len(data)
    for found in (one, other):
        assert found.elpd == pytest.approx(found.pointwise.sum(), rel=1e-14)
        assert found.se == pytest.approx(np.sqrt(n * np.var(found.pointwise, ddof=1)), rel=1e-12)
    d = one.pointwise - other.pointwise
    value, se = paired_difference(one, other)
    assert value == pytest.approx(one.elpd - other.elpd, abs=1e-9)
    assert se == pytest.approx(np.sqrt(n / (n - 1) * ((d - d.mean()) ** 2).sum()), rel=1e-12)
    assert paired_difference(other, one) == pytest.approx((-value, se))
    assert paired_difference(one, one) == (0.0, 0.0)
    # Paired: errors of the same points cancel, those of independent ones would not.
    assert se < np.hypot(one.se, other.se)


@pytest.mark.parametrize("order", [1, 3, 5])
@pytest.mark.parametrize("sigma", [None, 2.0])
def test_number_of_parameters_equals_p_eff_for_many_points(order, sigma):
    """p coefficients, and sigma (Gelman, Hwang & Vehtari 2014): one each where data dominate.

    Averaged over 10 sets of 2000 points. One coefficient's share is sum h_i z_i^2, of
    relative sd sqrt(2 / n); that of sigma (mean z^4 - 1) / 2, of sd sqrt(96 / n) / 2.
    """
    found = []
    for seed in range(10):
        data = curve(2000, [480, 300, 20, 20, 20, 20][: order + 1], 2.0, seed=seed)
        model = make_model(data, order, sigma=sigma, tau=0.05)
        found.append(leave_one_out(data, exact_posterior(model)).p_eff)
    error = np.hypot(np.sqrt(96 / 2000) / 2, (order + 1) * np.sqrt(2 / 2000)) / np.sqrt(10)
    assert np.mean(found) == pytest.approx(order + 1 + (sigma is None), abs=4 * error + 0.02)


def test_students_t_equals_leave_one_out_of_a_straight_line():
    """Textbook: flat b and ln sigma give t_i a Student t with n - 1 - p dof.

    The bounds of ln sigma cut exp(-n ln 100) of it.
    """
    data = curve(20, [480, 300], 1.0)
    found = leave_one_out(data, exact_posterior(make_model(data, 1, prior="flat")))
    for i in (0, 7, 19):
        keep = all_but(20, i)
        fit = stats.linregress(data.x[keep], data.t[keep])
        rest = data.t[keep] - fit.intercept - fit.slope * data.x[keep]
        dof = 19 - 2
        centre = data.x[i] - data.x[keep].mean()
        spread = ((data.x[keep] - data.x[keep].mean()) ** 2).sum()
        scale = np.sqrt((rest @ rest) / dof * (1 + 1 / 19 + centre**2 / spread))
        t = stats.t(dof, fit.intercept + fit.slope * data.x[i], scale)
        assert found.pointwise[i] == pytest.approx(t.logpdf(data.t[i]), abs=CLOSE)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_leave_one_out_equals_importance_sampling_of_the_draws(thesis_comparison, axis, order):
    """Within 5 Monte Carlo standard errors where the weights have a variance (Pareto k below 0.5).

    Up to 0.7 the estimate converges, but slower than its standard error says: within 10. The log
    likelihood is scipy's, from the reported draws of alpha and sigma.
    """
    result = thesis_comparison.axes[axis]
    data, posterior = result.data, result[order].posterior
    draws = posterior.chain.draws
    draws = draws.reshape(-1, draws.shape[2])
    prediction = np.polynomial.polynomial.polyval(data.x, draws[:, : order + 1].T)
    log_likelihood = stats.norm(prediction, draws[:, order + 1, None]).logpdf(data.t).T
    found = psis_loo(log_likelihood)
    elpd, mcse, k = found.pointwise, found.mcse, found.pareto_k
    exact = leave_one_out(data, posterior.exact)
    good = k < 0.7
    assert good.mean() > 0.9
    off = np.abs(elpd - exact.pointwise) / mcse
    assert off[k < 0.5].max() < 5
    assert off[good].max() < 10


def test_a_point_that_every_draw_predicts_alike_has_a_good_tail():
    """Of a known deviation of 1e9 px, say: its weights are all the same."""
    rng = np.random.default_rng(0)
    log_likelihood = np.vstack([np.full(1000, -20.0), rng.normal(-1, 0.3, 1000)])
    found = psis_loo(log_likelihood)
    alone = psis_loo(log_likelihood[1:])
    assert found.pointwise[0] == pytest.approx(-20.0)
    assert found.pareto_k[0] == 0
    np.testing.assert_allclose(found.pointwise[1:], alone.pointwise, rtol=1e-12)
    np.testing.assert_allclose(found.pareto_k[1:], alone.pareto_k, rtol=1e-9)


def test_the_error_of_a_sum_takes_in_that_its_terms_share_draws():
    """Twice the same point: twice the error, not its root."""
    row = np.random.default_rng(0).normal(-1, 0.3, (1, 1000))
    one, two = psis_loo(row), psis_loo(np.vstack([row, row]))
    alone, both = (np.linalg.norm(found.influence.sum(axis=0)) for found in (one, two))
    assert alone == pytest.approx(one.mcse[0])
    assert both == pytest.approx(2 * alone)


def test_points_in_blocks_are_left_out_as_all_at_once(monkeypatch):
    rng = np.random.default_rng(0)
    theta, pixels = rng.normal(0, 0.1, (1000, 1)), rng.normal(0, 1, 30)
    found = []
    for size in (psis.BLOCK, 7000):
        monkeypatch.setattr(psis, "BLOCK", size)
        drawn = psis.Draws(theta, 1000.0)
        loo = psis.sampled_leave_one_out(drawn, lambda draws: stats.norm.logpdf(pixels - draws))
        found.append(loo)
    whole, blocks = found
    np.testing.assert_allclose(blocks.pointwise, whole.pointwise, rtol=1e-13)
    np.testing.assert_allclose(blocks.pareto_k, whole.pareto_k, rtol=1e-9)
    assert blocks.mcse == pytest.approx(whole.mcse, rel=1e-12)
    assert blocks.p_eff == pytest.approx(whole.p_eff, rel=1e-9)
