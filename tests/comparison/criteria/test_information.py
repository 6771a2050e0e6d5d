"""Information criteria against hand formulas and scipy's densities."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from scipy import stats

from bayescal.comparison.criteria.information import criteria
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import THESIS_MODELS, legendre_columns, make_axis, thesis_axis
from tests.helpers.strategies import axes, settings_for


def residuals(data, order):
    """Least-squares residuals by numpy's lstsq on Legendre columns."""
    x = legendre_columns(data, order)
    sd = np.ones(len(data)) if data.sd is None else data.sd
    beta = np.linalg.lstsq(x / sd[:, None], data.t / sd)[0]
    return data.t - x @ beta


def found(data, order, noise):
    factors = factorise(data, order)
    fit = solve(factors, order, noise.value)
    return criteria(fit, noise, factors.n, factors.log_sd)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_inferred_sigma_is_maximised_too_and_counted(axis, order):
    """scipy's normal log densities at sigma^2 = RSS / n; K = p + 1."""
    data = thesis_axis(axis)
    e = residuals(data, order)
    n, k = len(data), order + 2
    log_likelihood = stats.norm(0, np.sqrt(np.mean(e**2))).logpdf(e).sum()
    result = found(data, order, NoiseLevel.inferred())
    assert result.n_parameters == k
    assert result.log_likelihood == pytest.approx(log_likelihood, abs=1e-9)
    assert result.aic == pytest.approx(2 * k - 2 * log_likelihood, abs=1e-9)
    assert result.bic == pytest.approx(k * math.log(n) - 2 * log_likelihood, abs=1e-9)
    correction = 2 * k * (k + 1) / (n - k - 1)
    assert result.aicc == pytest.approx(result.aic + correction, abs=1e-9)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_constants_are_those_of_statsmodels(axis, order):
    """Its OLS formula restated: llf = -n/2 (ln RSS + 1 + ln(2 pi / n)); it counts only p."""
    data = thesis_axis(axis)
    rss = float((residuals(data, order) ** 2).sum())
    n, p = len(data), order + 1
    llf = -n / 2 * math.log(rss) - n / 2 * (1 + math.log(math.pi / (n / 2)))
    result = found(data, order, NoiseLevel.inferred())
    assert result.log_likelihood == pytest.approx(llf, abs=1e-9)
    assert result.aic == pytest.approx(-2 * llf + 2 * p + 2, abs=1e-9)
    assert result.bic == pytest.approx(-2 * llf + (p + 1) * math.log(n), abs=1e-9)


@pytest.mark.parametrize("order", [1, 4])
def test_known_sigma_is_not_counted_and_has_no_aicc(order):
    data, sigma = thesis_axis("c"), 2.3
    log_likelihood = stats.norm(0, sigma).logpdf(residuals(data, order)).sum()
    result = found(data, order, NoiseLevel.known(sigma))
    assert result.n_parameters == order + 1
    assert result.log_likelihood == pytest.approx(log_likelihood, abs=1e-9)
    assert result.aic == pytest.approx(2 * (order + 1) - 2 * log_likelihood, abs=1e-9)
    bic = (order + 1) * math.log(57) - 2 * log_likelihood
    assert result.bic == pytest.approx(bic, abs=1e-9)
    assert result.aicc is None


@pytest.mark.parametrize("order", [1, 3])
def test_deviations_per_point_enter_the_likelihood(order):
    rng = np.random.default_rng(3)
    data = thesis_axis("r")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    log_likelihood = stats.norm(0, data.sd).logpdf(residuals(data, order)).sum()
    result = found(data, order, NoiseLevel.known(1.0))
    assert result.n_parameters == order + 1
    assert result.log_likelihood == pytest.approx(log_likelihood, abs=1e-9)


def test_a_factor_on_the_deviations_is_maximised_and_counted():
    rng = np.random.default_rng(3)
    data = thesis_axis("r")
    data = make_axis(data.x, data.t, data.size, sd=rng.uniform(1, 6, len(data)))
    e = residuals(data, 3)
    factor = np.sqrt(np.mean((e / data.sd) ** 2))
    log_likelihood = stats.norm(0, factor * data.sd).logpdf(e).sum()
    result = found(data, 3, NoiseLevel.scale())
    assert result.n_parameters == 5
    assert result.log_likelihood == pytest.approx(log_likelihood, abs=1e-9)


def test_replicates_sigma_is_not_counted():
    data = thesis_axis("c")
    result = found(data, 2, NoiseLevel.replicates(2.3, 12))
    assert result.n_parameters == 3
    assert result.aicc is None
    assert result.aic == found(data, 2, NoiseLevel.known(2.3)).aic


@pytest.mark.parametrize(("n", "defined"), [(5, False), (6, False), (7, True)])
def test_aicc_is_undefined_up_to_n_of_k_plus_one(n, defined):
    """Order 3 and sigma: K = 5, so that n - K - 1 must exceed 0."""
    x = np.linspace(-1, 1, n)
    data = make_axis(x, 500 + 100 * np.exp(2 * x))
    result = found(data, 3, NoiseLevel.inferred())
    assert result.aic is not None
    assert (result.aicc is not None) is defined


@pytest.mark.parametrize("noise", [NoiseLevel.inferred(), NoiseLevel.known(2.0)])
def test_an_exact_fit_has_parameters_but_no_criteria(noise):
    x = np.linspace(-1, 1, 10)
    result = found(make_axis(x, 500 + 300 * x), 1, noise)
    assert result.n_parameters == 2 + (noise.value is None)
    assert (result.log_likelihood, result.aic, result.aicc, result.bic) == (None,) * 4


@settings_for(40)
@given(axes(max_order=6))
def test_maximised_log_likelihood_never_falls_with_the_order(problem):
    """Inequality of nested models."""
    data, order = problem
    factors = factorise(data, order)
    noise = NoiseLevel.inferred()
    values = [
        criteria(solve(factors, k), noise, factors.n).log_likelihood for k in range(1, order + 1)
    ]
    assert all(after >= before for before, after in pairwise(values))
