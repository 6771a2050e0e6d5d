"""Polynomials of two regressors: the basis, its map, and a fit of known coefficients."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.special import eval_legendre

import bayescal as bc
from bayescal.errors import InputError
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials import bivariate, separable
from bayescal.polynomials.basis import Domain
from bayescal.polynomials.plane import PlaneMap, plane_columns, plane_design, powers
from tests.helpers.problems import field_rule


def thesis_axis(axis):
    return bivariate.axis_data(bc.thesis(), axis)


def model(data, order, tau=None):
    prior = field_rule(data, tau).of_degrees(data.degrees(order))
    return LinearModel(factorise(data, order), order, NoiseLevel.inferred(), prior, data.symbol)


@pytest.mark.parametrize("order", [1, 2, 5])
def test_columns_are_products_of_legendre_polynomials_nested_by_total_degree(order):
    rng = np.random.default_rng(order)
    s, t = rng.uniform(-1, 1, (2, 9))
    design = plane_design(s, t, order)
    assert design.shape[1] == plane_columns(order) == len(powers(order))
    for column, (i, j) in zip(design.T, powers(order), strict=True):
        assert i + j <= order
        np.testing.assert_allclose(column, eval_legendre(i, s) * eval_legendre(j, t), atol=1e-14)
    np.testing.assert_array_equal(
        design[:, : plane_columns(order - 1)], plane_design(s, t, order - 1)
    )


def test_the_map_to_monomials_is_exact():
    """Both sides of sum b P P = sum alpha w^i u^j, in rational arithmetic."""
    domains = Domain(-0.5, 0.75), Domain(0.25, 1.5)
    found = PlaneMap(*domains, 3)
    w, u = Fraction(1, 3), Fraction(2, 5)
    s, t = (
        (x - Fraction(d.middle)) / Fraction(d.half_range)
        for x, d in zip((w, u), domains, strict=True)
    )

    def legendre(k, x):
        return [Fraction(1), x, (3 * x * x - 1) / 2, (5 * x**3 - 3 * x) / 2][k]

    for column, (i, j) in enumerate(powers(3)):
        image = sum(found.exact[row][column] * w**a * u**b for row, (a, b) in enumerate(powers(3)))
        assert image == legendre(i, s) * legendre(j, t)
    assert found.suffixes[:6] == ("00", "10", "01", "20", "11", "02")
    np.testing.assert_array_equal(found.lead(2), PlaneMap(*domains, 2).matrix)


@pytest.mark.parametrize("axis", ["r", "c"])
def test_the_separable_model_is_the_bivariate_one_without_mixed_terms(axis):
    """Order 1 plus the other slope; the sum of squares can only fall."""
    plain = factorise(separable.axis_data(bc.thesis(), axis), 3)
    both = factorise(thesis_axis(axis), 3)
    for order in (1, 2, 3):
        assert both.rss(order) < plain.rss(order)


def test_known_coefficients_come_back():
    data = thesis_axis("r")
    w, u = data.x, data.other
    truth = np.array([900.0, 1200.0, -30.0, 12.0, -45.0, 7.0])
    exact = sum(a * w**i * u**j for a, (i, j) in zip(truth, powers(2), strict=True))
    fit = solve(factorise(replace(data, t=exact), 2), 2)
    np.testing.assert_allclose(fit.coefficients, truth, rtol=0, atol=1e-10)
    assert fit.exact
    assert fit.dof == 57 - 6


@pytest.mark.parametrize("order", [1, 2, 3])
def test_evidence_is_the_dense_gaussian_one(order):
    """ln N(t; X m, sigma^2 I + X S X') at fixed tau, integrated over sigma by the trapezium."""
    data = thesis_axis("c")
    found = exact_posterior(model(data, order, tau=0.05)).log_evidence
    prior = field_rule(data, 0.05).of_degrees(data.degrees(order))
    x, sd = data.design(order), prior.deviations(np.log([0.05]))[0]
    kernel = (x * sd**2) @ x.T
    values, vectors = np.linalg.eigh(kernel)
    z = vectors.T @ (data.t - x @ prior.mean)
    grid = np.linspace(np.log(0.01), np.log(1000), 20001)
    total = np.maximum(values, 0)[:, None] + np.exp(2 * grid)
    logs = -0.5 * (np.log(2 * np.pi * total) + z[:, None] ** 2 / total).sum(axis=0)
    top = logs.max()
    integral = np.trapezoid(np.exp(logs - top), grid) / (grid[-1] - grid[0])
    assert found == pytest.approx(top + np.log(integral), abs=1e-6)


def test_a_point_left_out_leaves_the_evidence_of_the_rest():
    """Rows of both regressors: without a point, against a factorisation of the others."""
    data = thesis_axis("r")
    fitted = model(data, 2)
    members = np.zeros((1, len(data)))
    members[0, 7] = 1
    left = Rows.of(data, 2).without(members).reduced(2)
    keep = np.arange(len(data)) != 7
    frame = (data.domain, Domain.of(data.other))
    rest = replace(
        data, x=data.x[keep], other=data.other[keep], t=data.t[keep], labels=(), frame=frame
    )
    alone = exact_posterior(model(rest, 2)).log_evidence
    assert log_evidences(left, fitted.noise, fitted.prior, FINE)[0] == pytest.approx(
        alone, abs=1e-7
    )


def test_names_and_bad_orders():
    data = thesis_axis("c")
    assert model(data, 2).names[:6] == (
        "beta_00",
        "beta_10",
        "beta_01",
        "beta_20",
        "beta_11",
        "beta_02",
    )
    with pytest.raises(
        InputError, match=r"order 10 in y/z and x/z has 66 .* order that works is 9"
    ):
        data.check(10)
