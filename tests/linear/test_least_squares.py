"""Least squares against 80-digit arithmetic and the identities of nested models."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mpf, workdps

import bayescal as bc
from bayescal.errors import InputError
from bayescal.linear.least_squares import factorise, solve
from tests.helpers.exact_least_squares import DIGITS, ExactFit, exact_fit, relative_error
from tests.helpers.problems import ORDERS, THESIS_MODELS, legendre_columns, make_axis, thesis_axis
from tests.helpers.strategies import axes, settings_for

EPS = np.finfo(float).eps


@cache
def exact_thesis_fit(axis: str, order: int) -> ExactFit:
    """The thesis fit from the printed integers: regressors are exact quotients."""
    points = bc.thesis()
    column, offset = (0, 330) if axis == "r" else (1, 57)
    with workdps(DIGITS):
        x = [mpf(int(w[column]) - offset) / int(w[2]) for w in points.world]
        r_or_row = [int(p[column]) for p in points.pixels]
        y = [mpf(v if axis == "r" else 1080 - v) for v in r_or_row]
        return exact_fit(x, y, order)


def thesis_fit(axis: str, order: int):
    """The program's fit, from the factorisation of the highest order compared."""
    return solve(factorise(thesis_axis(axis), ORDERS[-1]), order)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_thesis_rss_agrees_with_80_digits(axis, order):
    """To 1e-12: 57 squares, each good to a few eps max|t| / |residual|, about 1e-14."""
    assert relative_error(thesis_fit(axis, order).rss, exact_thesis_fit(axis, order).rss) < 1e-12


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_thesis_coefficients_agree_with_80_digits(axis, order):
    """To 1e-11: eps times |b| / |alpha_j|, up to 1e3 here, times the map's entries."""
    truth = exact_thesis_fit(axis, order).coefficients
    found = thesis_fit(axis, order).coefficients
    assert max(map(relative_error, found, truth)) < 1e-11


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_thesis_standard_errors_agree_with_80_digits(axis, order):
    """To 1e-12: sums of squares without cancellation."""
    truth = exact_thesis_fit(axis, order).standard_errors
    found = thesis_fit(axis, order).standard_errors
    assert max(map(relative_error, found, truth)) < 1e-12


@settings_for(20)
@given(axes(max_order=8))
def test_a_lower_orders_blocks_are_its_own_factorisation(problem):
    """Identity: the leading blocks solve the lower order, to cond(X) of a few tens times eps."""
    data, order = problem
    nested = factorise(data, order)
    for k in range(1, order + 1):
        direct, from_blocks = solve(factorise(data, k), k), solve(nested, k)
        scale = np.abs(data.t).max()
        np.testing.assert_allclose(
            from_blocks.amplitudes, direct.amplitudes, rtol=0, atol=1e-11 * scale
        )
        np.testing.assert_allclose(
            from_blocks.rss, direct.rss, rtol=1e-9, atol=len(data) * (64 * EPS * scale) ** 2
        )


@settings_for(60)
@given(axes(max_order=8))
def test_maximised_likelihood_never_falls_with_the_order(problem):
    """Identity: a nested model's residual sum of squares can't rise."""
    data, order = problem
    factors = factorise(data, order)
    rss = [factors.rss(k) for k in range(1, order + 1)]
    assert all(after <= before for before, after in pairwise(rss))


@settings_for(40)
@given(axes(max_order=6))
def test_residuals_are_orthogonal_to_every_column(problem):
    """The normal equations, on a design built by Bonnet's recursion."""
    data, order = problem
    fit = solve(factorise(data, order), order)
    columns = legendre_columns(data, order)
    residuals = data.t - columns @ fit.amplitudes
    scale = np.abs(data.t).max()
    assert np.abs(columns.T @ residuals).max() < 1e-12 * scale * len(data)
    np.testing.assert_allclose(
        fit.rss, residuals @ residuals, rtol=1e-9, atol=len(data) * (64 * EPS * scale) ** 2
    )


def test_known_deviations_weigh_rows_like_scaled_rows():
    """Independent tool: numpy's lstsq on rows divided by their deviations."""
    rng = np.random.default_rng(3)
    x, t, sd = rng.uniform(-1, 1, 30), rng.normal(500, 20, 30), rng.uniform(0.5, 4, 30)
    fit = bc.least_squares(x, t, 3, sd=sd)
    design = np.vander(x, 4, increasing=True) / sd[:, None]
    truth, rss, _, _ = np.linalg.lstsq(design, t / sd)
    np.testing.assert_allclose(fit.coefficients, truth, rtol=1e-11)
    np.testing.assert_allclose(fit.rss, rss[0], rtol=1e-11)
    covariance = np.linalg.inv(design.T @ design)  # at the known deviations, nothing estimated
    np.testing.assert_allclose(fit.standard_errors, np.sqrt(np.diag(covariance)), rtol=1e-10)


def test_as_many_points_as_coefficients_leave_no_error_to_state():
    """Closed form: an interpolating polynomial has no residual and no degree of freedom."""
    fit = bc.least_squares([0.0, 1.0, 3.0], [1.0, 2.0, 10.0], 2)
    np.testing.assert_allclose(fit.coefficients, [1.0, 0.0, 1.0], atol=1e-13)
    assert (fit.dof, fit.sigma_hat, fit.standard_errors) == (0, None, None)
    assert fit.exact


@pytest.mark.parametrize(("noise", "exact"), [(1.2e-14, True), (1.7e-14, False)])
def test_exact_fit_means_residuals_of_64_eps_of_the_largest_pixel(noise, exact):
    """Closed form: deviations of +-`noise` max|t| have an RSS of n times their square.

    64 eps is 1.42e-14; pixels and the factorisation round like a few eps.
    """
    x = np.linspace(-1, 1, 40)
    t = 1000 * (x + 1) / 2 + 1000 * noise * np.where(np.arange(40) % 2, 1.0, -1.0)
    factors = factorise(make_axis(x, t), 1)
    assert factors.exact_fit(1) is exact
    assert solve(factors, 1).exact is exact


@given(st.integers(1, 6))
def test_too_few_distinct_regressors_are_refused(order):
    """Negative control: `order` values cannot determine `order + 1` coefficients."""
    x = np.repeat(np.arange(order, dtype=float), 4)
    with pytest.raises(bc.InputError, match=r"distinct values|points"):
        bc.least_squares(x, np.sin(x), order)


@pytest.mark.parametrize(("factor", "order"), [(1e4, 5), (100.0, 8)])
def test_one_regressor_too_far_from_all_others_is_refused(factor, order):
    """The message names an order that is then accepted, and the next is not."""
    x = np.random.default_rng(0).uniform(0, 1, 30)
    x[-1] *= factor
    data = make_axis(x, 500 + 300 * x)
    with pytest.raises(InputError, match="undetermined to rounding") as refused:
        factorise(data, order)
    works = int(str(refused.value).rsplit(" ", 1)[1])
    assert 1 <= works < order
    factorise(data, works)
    with pytest.raises(InputError, match=f"the highest order that works is {works}"):
        factorise(data, works + 1)


def test_many_points_are_factorised_part_by_part(monkeypatch):
    """Truth: all at once. R is the same but for signs of rows; both round by some eps."""
    data = thesis_axis("r")
    whole = factorise(data, 3)
    monkeypatch.setattr("bayescal.linear.least_squares.PART", 10)
    parts = factorise(data, 3)
    scale = np.abs(whole.r).max()
    np.testing.assert_allclose(
        parts.r.T @ parts.r, whole.r.T @ whole.r, rtol=0, atol=100 * EPS * scale**2
    )
    for order in range(1, 4):
        assert parts.rss(order) == pytest.approx(whole.rss(order), rel=1e-12)
        ours, theirs = solve(parts, order), solve(whole, order)
        np.testing.assert_allclose(ours.coefficients, theirs.coefficients, rtol=1e-11)
    assert (parts.n, parts.largest) == (whole.n, whole.largest)
