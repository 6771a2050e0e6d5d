"""The Legendre basis and its map to monomials, in exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import legendre, polynomial
from scipy.special import eval_legendre

from bayescal.polynomials.basis import Domain, MonomialMap, distinct_values, legendre_design
from tests.helpers.strategies import settings_for

domains = st.builds(
    lambda lower, width: Domain(lower, lower + width), st.floats(-1e3, 1e3), st.floats(1e-3, 1e3)
)


def numpy_map(domain: Domain, order: int) -> list[list[Fraction]]:
    """numpy's own conversion, run on fractions: leg2poly, then Horner in s(x)."""
    half = Fraction(domain.half_range)
    s = np.array([-Fraction(domain.middle) / half, 1 / half], dtype=object)
    columns = []
    for k in range(order + 1):
        unit = np.array([Fraction(0)] * k + [Fraction(1)], dtype=object)
        in_s = legendre.leg2poly(unit)
        column = np.array([Fraction(0)], dtype=object)
        for coefficient in in_s[::-1]:
            column = polynomial.polyadd(polynomial.polymul(column, s), [coefficient])
        columns.append([*column] + [Fraction(0)] * (order + 1 - len(column)))
    return [[columns[k][j] for k in range(order + 1)] for j in range(order + 1)]


@settings_for(40)
@given(domains, st.integers(1, 10))
def test_map_is_numpys_legendre_conversion_in_exact_arithmetic(domain, order):
    assert MonomialMap(domain, order).exact == numpy_map(domain, order)


@settings_for(40)
@given(domains, st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_applied_map_rounds_once(domain, order, seed):
    """Every coefficient is the double next to the exact image of the amplitudes."""
    amplitudes = np.random.default_rng(seed).normal(0, 300, order + 1)
    exact = numpy_map(domain, order)
    image = [
        sum(m * Fraction(b) for m, b in zip(row, amplitudes.tolist(), strict=True)) for row in exact
    ]
    assert MonomialMap(domain, order).apply(amplitudes).tolist() == [float(v) for v in image]


def test_the_map_in_doubles_would_cost_digits():
    """Negative control: where large amplitudes cancel, a rounded matrix loses digits."""
    monomials = MonomialMap(Domain(1.0, 20.0), 5)
    amplitudes = np.array([0.0, 1.5e6, 1.1e6, 4e5, 8e4, 6e3])
    amplitudes[0] = 1.0 - monomials.apply(amplitudes)[0]  # so that alpha_0 is about 1
    exact = sum(
        m * Fraction(b) for m, b in zip(monomials.exact[0], amplitudes.tolist(), strict=True)
    )
    assert monomials.apply(amplitudes)[0] == float(exact)
    assert abs((monomials.matrix @ amplitudes)[0] / float(exact) - 1) > 1e-12


def test_columns_of_amplitudes_are_mapped_one_by_one():
    monomials = MonomialMap(Domain(-0.6, 1.4), 4)
    columns = np.random.default_rng(1).normal(size=(5, 3))
    together = monomials.apply(columns)
    for j in range(3):
        assert np.array_equal(together[:, j], monomials.apply(columns[:, j]))


@given(st.integers(1, 6))
def test_a_lower_orders_map_is_the_leading_block(order):
    domain = Domain(-0.6, 1.4)
    lead = MonomialMap(domain, 7).lead(order)
    assert np.array_equal(lead, MonomialMap(domain, order).matrix)


def test_mapped_coefficients_predict_what_the_amplitudes_predict():
    """Identity: one polynomial in two bases; powers up to 1.4^5 cost some eps."""
    x = np.linspace(-0.6, 1.4, 41)
    domain = Domain.of(x)
    amplitudes = np.array([480.0, 300.0, 20.0, -7.0, 3.0, 1.0])
    pixels = legendre_design(domain.scale(x), 5) @ amplitudes
    alpha = MonomialMap(domain, 5).apply(amplitudes)
    np.testing.assert_allclose(polynomial.polyval(x, alpha), pixels, rtol=1e-13, atol=1e-11)


@pytest.mark.parametrize("order", [1, 5, 12])
def test_design_matrix_is_scipys_legendre_polynomials(order):
    s = np.linspace(-1, 1, 101)
    truth = eval_legendre(np.arange(order + 1), s[:, None])
    np.testing.assert_allclose(legendre_design(s, order), truth, rtol=0, atol=1e-14)


@given(domains)
def test_domain_maps_its_ends_to_one(domain):
    """Rounding the middle of ends up to 1e6 times the width apart costs 1e6 eps."""
    ends = domain.scale(np.array([domain.lower, domain.upper]))
    np.testing.assert_allclose(ends, [-1, 1], rtol=0, atol=1e-9)


def test_regressors_within_1e9_of_the_domain_are_one_value():
    x = np.array([0.0, 0.5e-9, 1.0, 1.0 + 0.5e-9, 0.5, 0.5 + 3e-9])
    assert distinct_values(x) == 4
