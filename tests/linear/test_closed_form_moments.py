"""Exact posterior means, deviations, quantiles and kurtosis against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial
from scipy import stats

from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.polynomials.axis_data import AxisData
from tests.helpers.brute_force import Grid, mixture_cdf, moments, normal_grid
from tests.helpers.problems import STATED_R, THESIS_MODELS, make_axis, make_model, thesis_axis

# Both quadratures are good to 1e-8; the normal equations round like cond(X)^2, a hundred
# or so, times eps, relative to the posterior deviation.
CLOSE = 1e-7


def monomials(data: AxisData, order: int) -> np.ndarray:
    """numpy's conversion of each Legendre polynomial on the domain, (order + 1)^2."""
    domain = [data.x.min(), data.x.max()]
    columns = [
        Legendre.basis(k, domain=domain).convert(kind=Polynomial).coef for k in range(order + 1)
    ]
    return np.array([np.pad(c, (0, order + 1 - len(c))) for c in columns]).T


def hyperparameters(grid: Grid) -> list[tuple[np.ndarray, np.ndarray]]:
    """Values and probabilities of sigma and tau on the grid, where they are inferred."""
    out = []
    if grid.model.infers_sigma:
        out.append((np.exp(grid.log_sigma), grid.weights.sum(axis=0)))
    if grid.model.infers_tau:
        out.append((np.exp(grid.log_tau), grid.weights.sum(axis=1)))
    return out


def check(model: LinearModel, data: AxisData) -> None:
    """Compare moments of every reported parameter, and quantiles of the coefficients."""
    exact, grid = exact_posterior(model), normal_grid(model, data)
    transform = monomials(data, model.order)
    mixture = grid.mixture(transform)
    mean, sd, kurtosis = moments(*mixture)
    for values, mass in hyperparameters(grid):
        point = moments(mass, values[:, None], np.zeros((len(values), 1)))
        mean, sd = np.append(mean, point[0]), np.append(sd, point[1])
        kurtosis = np.append(kurtosis, point[2])
    found_mean, found_sd = exact.summary
    assert np.abs((found_mean - mean) / sd).max() < CLOSE
    np.testing.assert_allclose(found_sd, sd, rtol=CLOSE)
    np.testing.assert_allclose(exact.kurtosis, kurtosis, rtol=10 * CLOSE)  # a fourth power

    probabilities = np.array([0.025, 0.16, 0.5, 0.84, 0.975])
    quantiles = exact.quantiles(transform, probabilities)
    weights, means, sds = mixture
    for j, row in enumerate(quantiles):
        below = [mixture_cdf(q, weights, means[:, j], sds[:, j]) for q in row]
        np.testing.assert_allclose(below, probabilities, rtol=0, atol=CLOSE)


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_thesis_posteriors_are_the_brute_force_ones(axis, order, tau):
    data = thesis_axis(axis)
    check(make_model(data, order, tau=tau), data)


@pytest.mark.parametrize("sigma", [None, 2.5])
def test_a_posterior_under_a_stated_prior_is_the_brute_force_one(sigma):
    data = thesis_axis("r")
    check(make_model(data, 4, sigma=sigma, prior="stated", stated=STATED_R), data)


def test_a_posterior_with_known_deviations_is_the_brute_force_one():
    data = thesis_axis("c")
    sd = np.random.default_rng(6).uniform(1, 6, len(data))
    data = make_axis(data.x, data.t, data.size, sd=sd)
    check(make_model(data, 3), data)


@pytest.mark.parametrize("order", [1, 3])
def test_few_points_leave_heavy_tails_that_are_the_brute_force_ones(order):
    """With two spare points sigma is nearly free: kurtosis far above 3."""
    rng = np.random.default_rng(2)
    x = np.linspace(-1, 1, order + 3)
    data = make_axis(x, 500 + 300 * x + rng.normal(0, 2, order + 3))
    model = make_model(data, order)
    assert exact_posterior(model).kurtosis[0] > 10
    check(model, data)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_flat_prior_with_known_sigma_is_the_normal_of_least_squares(order):
    """Closed form: N(alpha_hat, sigma^2 (X'X)^-1)."""
    data = thesis_axis("r")
    exact = exact_posterior(make_model(data, order, sigma=3.0, prior="flat"))
    x = np.vander(data.x, order + 1, increasing=True)
    truth = np.linalg.lstsq(x, data.t)[0]
    sd = 3.0 * np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    found_mean, found_sd = exact.summary
    assert np.abs((found_mean - truth) / sd).max() < CLOSE
    np.testing.assert_allclose(found_sd, sd, rtol=CLOSE)
    np.testing.assert_allclose(exact.kurtosis, 3, rtol=1e-9)
    transform = monomials(data, order)
    quantiles = exact.quantiles(transform, np.array([0.025, 0.5, 0.975]))
    for q, m, s in zip(quantiles, truth, sd, strict=True):
        np.testing.assert_allclose(q, stats.norm(m, s).ppf([0.025, 0.5, 0.975]), atol=CLOSE * s)


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-6])
def test_a_sigma_far_below_the_residuals_keeps_its_closed_form(sigma):
    """Log densities of -1e6 to -1e15, whose rounding must not reach the moments.

    The field prior at tau = 0.05 is then as good as flat: it moves the mean by 1e-6 deviations. The
    mean itself rounds like eps max|t| times cond(X), 1e-4 of the smallest deviation.
    """
    data = thesis_axis("c")
    exact = exact_posterior(make_model(data, 2, sigma=sigma, tau=0.05))
    x = np.vander(data.x, 3, increasing=True)
    truth = np.linalg.lstsq(x, data.t)[0]
    sd = sigma * np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    found_mean, found_sd = (values[:3] for values in exact.summary)
    assert np.abs((found_mean - truth) / sd).max() < 1e-3
    np.testing.assert_allclose(found_sd, sd, rtol=1e-3)


@pytest.mark.parametrize("order", [1, 3])
def test_flat_prior_with_inferred_sigma_is_students_t(order):
    """Closed form under 1/sigma: t with n - p dof; the bounds of sigma cut off nothing."""
    data = thesis_axis("c")
    exact = exact_posterior(make_model(data, order, prior="flat"))
    x = np.vander(data.x, order + 1, increasing=True)
    truth, rss, _, _ = np.linalg.lstsq(x, data.t)
    dof = len(data) - order - 1
    scale = np.sqrt(rss[0] / dof * np.diag(np.linalg.inv(x.T @ x)))
    student = stats.t(dof)
    found_mean, found_sd = exact.summary
    assert np.abs((found_mean[:-1] - truth) / scale).max() < CLOSE
    np.testing.assert_allclose(found_sd[:-1], scale * student.std(), rtol=CLOSE)
    np.testing.assert_allclose(exact.kurtosis[:-1] - 3, student.stats("k"), rtol=1e-5)
    quantiles = exact.quantiles(monomials(data, order), np.array([0.025, 0.5, 0.975]))
    expected = truth[:, None] + scale[:, None] * student.ppf([0.025, 0.5, 0.975])
    assert np.abs((quantiles - expected) / scale[:, None]).max() < CLOSE
