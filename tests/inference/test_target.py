"""The density emcee samples against a plain sum of scipy's log densities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.polynomials.axis_data import AxisData
from tests.helpers.problems import (
    STATED_R,
    THESIS_MODELS,
    legendre_columns,
    make_axis,
    make_model,
    prior_deviations,
    thesis_axis,
)

# Absolute, on log densities of order 1e2 to 1e3: sums of 57 terms of order 1 to 10,
# each good to some eps, and rss / sigma^2 to 1e-13 of some tens.
TOLERANCE = 1e-9


def plain_log_prob(model: LinearModel, data: AxisData, theta: np.ndarray) -> float:
    """Sum over the raw points and over the priors, one scipy density per term."""
    b, rest = theta[: model.size], list(theta[model.size :])
    total = 0.0
    if model.noise.bounds is not None:
        log_sigma = rest.pop(0)
        lower, upper = np.log(model.noise.bounds)
        total += stats.uniform(lower, upper - lower).logpdf(log_sigma)
        sigma = np.exp(log_sigma)
    else:
        sigma = model.noise.value
    deviations = sigma * (np.ones(len(data)) if data.sd is None else data.sd)
    prediction = legendre_columns(data, model.order) @ b
    total += stats.norm(prediction, deviations).logpdf(data.t).sum()
    tau = model.prior.tau if model.prior.tau is not None else 1.0
    if model.infers_tau:
        log_tau = rest.pop(0)
        total += stats.uniform(np.log(0.01 / data.size), np.log(50 * data.size)).logpdf(log_tau)
        tau = np.exp(log_tau)
    if model.prior.proper:
        scale = prior_deviations(model.prior, tau)
        total += stats.norm(model.prior.mean, scale).logpdf(b).sum()
    assert not rest
    return float(total)


def near_posterior(model: LinearModel, draws: int = 20) -> np.ndarray:
    """Thetas spread over three posterior deviations, inside the bounds."""
    rng = np.random.default_rng(11)
    exact = exact_posterior(model)
    root = np.linalg.cholesky(exact.covariance)
    theta = [exact.mean + rng.uniform(-1, 1, (draws, model.size)) @ (3 * root).T]
    for values, mass in exact.hyperparameters:
        log_values = np.log(values)
        mean = mass @ log_values
        sd = np.sqrt(mass @ (log_values - mean) ** 2)
        lower, upper = log_values.min(), log_values.max()
        drawn = mean + 3 * sd * rng.uniform(-1, 1, draws)
        theta.append(np.clip(drawn, lower, upper)[:, None])
    return np.hstack(theta)


def check(model: LinearModel, data: AxisData) -> None:
    theta = near_posterior(model)
    truth = [plain_log_prob(model, data, row) for row in theta]
    np.testing.assert_allclose(log_prob(model, theta), truth, rtol=0, atol=TOLERANCE)


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_field_prior_and_inferred_sigma_equal_scipys_sum(axis, order, tau):
    data = thesis_axis(axis)
    check(make_model(data, order, tau=tau), data)


@pytest.mark.parametrize("sigma", [None, 2.5])
@pytest.mark.parametrize("order", [1, 3, 5])
def test_flat_and_stated_priors_equal_scipys_sum(order, sigma):
    data = thesis_axis("r")
    check(make_model(data, order, sigma=sigma, prior="flat"), data)
    check(make_model(data, order, sigma=sigma, prior="stated", stated=STATED_R), data)


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize("order", [1, 4])
def test_known_sigma_equals_scipys_sum(order, tau):
    data = thesis_axis("c")
    check(make_model(data, order, sigma=3.4, tau=tau), data)


@pytest.mark.parametrize("scale", [False, True])
@pytest.mark.parametrize("prior", ["field", "flat"])
def test_deviations_per_point_equal_scipys_sum(prior, scale):
    """Known deviations, and deviations known up to an inferred factor."""
    rng = np.random.default_rng(2)
    data = thesis_axis("c")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    check(make_model(data, 3, prior=prior, scale=scale), data)


def test_a_forgotten_ln_sd_would_show():
    """Negative control: the same sum without the deviations' logarithm is far off."""
    rng = np.random.default_rng(2)
    data = thesis_axis("c")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    model = make_model(data, 3)
    theta = near_posterior(model, 1)
    wrong = plain_log_prob(model, data, theta[0]) + np.log(data.sd).sum()
    assert abs(log_prob(model, theta)[0] - wrong) > 1


@pytest.mark.parametrize("column", [-2, -1])
@pytest.mark.parametrize("side", [-1, 1])
def test_log_prob_is_minus_infinity_beyond_the_bounds(column, side):
    """Closed form: the uniform priors of ln sigma and ln tau end at their bounds."""
    model = make_model(thesis_axis("c"), 3)
    bounds = {-2: np.log(model.noise.bounds), -1: np.log([0.01 / 1080, 0.5])}[column]
    edge = bounds[0] if side < 0 else bounds[1]
    theta = np.repeat(near_posterior(model, 1), 2, axis=0)
    theta[:, column] = edge + side * np.array([1e-9, -1e-9])  # just outside, just inside
    outside, inside = log_prob(model, theta)
    assert outside == -np.inf
    assert np.isfinite(inside)
