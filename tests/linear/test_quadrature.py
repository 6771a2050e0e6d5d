"""Clenshaw-Curtis rules: exact on polynomials, and faithful where they follow peaks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy import stats
from scipy.special import gammaln, logsumexp

from bayescal.linear.quadrature import clenshaw_curtis, follow, interval
from tests.helpers.strategies import settings_for

sizes = st.sampled_from([5, 9, 13, 17, 33, 49])


@settings_for(60)
@given(sizes, st.integers(0, 2**32 - 1))
def test_n_nodes_integrate_polynomials_below_degree_n_exactly(nodes, seed):
    """Closed form: numpy's antiderivative. Odd powers vanish, so degree `nodes` is exact too."""
    x, weights = clenshaw_curtis(nodes)
    polynomial = Polynomial(np.random.default_rng(seed).normal(size=nodes + 1))
    antiderivative = polynomial.integ()
    truth = antiderivative(1) - antiderivative(-1)
    size = np.abs(polynomial.coef).sum()
    assert weights @ polynomial(x) == pytest.approx(truth, abs=1e-14 * size)


@pytest.mark.parametrize("nodes", [5, 9, 13])
def test_the_next_even_degree_is_not_exact(nodes):
    """Negative control: x^(n + 1) is beyond a rule of n nodes."""
    x, weights = clenshaw_curtis(nodes)
    assert abs(weights @ x ** (nodes + 1) - 2 / (nodes + 2)) > 1e-7


@given(sizes)
def test_weights_are_positive_and_nodes_ascend_between_the_ends(nodes):
    x, weights = clenshaw_curtis(nodes)
    assert (weights > 0).all()
    assert (np.diff(x) > 0).all()
    assert (x[0], x[-1]) == (-1, 1)


@given(sizes, st.floats(-5, 5), st.floats(0.1, 10))
def test_the_coarser_rule_is_nested_and_exact_to_half_the_degree(nodes, lower, width):
    rule = interval(lower, lower + width, nodes)
    power = nodes // 2
    truth = width / (power + 1)
    scaled = ((rule.nodes - lower) / width) ** power
    assert (rule.coarse[1::2] == 0).all()
    assert rule.coarse @ scaled == pytest.approx(truth, rel=1e-12)
    assert rule.weights @ scaled == pytest.approx(truth, rel=1e-12)


breaks_of_ln_sigma = np.linspace(np.log(0.01), np.log(1000), 26)


@pytest.mark.parametrize("n", [1e2, 1e4, 1e5, 3e5, 1e6, 1e8])
def test_the_likelihood_of_ln_sigma_is_followed_wherever_its_peak_lies(n):
    """Closed form: the integral of exp(-n u - n/2 (exp(-2u) - 1)) over all u is a Gamma."""
    truth = n / 2 + gammaln(n / 2) + n / 2 * np.log(2 / n) - np.log(2)
    # The sum itself carries some eps of n / 2 (1e-8 at n = 1e8).
    tolerance = 1e-7 + 1e-15 * n
    for peak in np.random.default_rng(1).uniform(-2, 5, 100):

        def density(x, peak=peak):
            return (-n * (x - peak) - n / 2 * np.expm1(-2 * (x - peak)))[None]

        rule, values = follow(density, breaks_of_ln_sigma)
        assert abs(logsumexp(values[0], b=rule.weights) - truth) < tolerance


@pytest.mark.parametrize("width", [1e-3, 0.1, 3.0])
@pytest.mark.parametrize("centre", [-4.0, 0.123, 6.9])
def test_a_normal_peak_integrates_to_its_mass(width, centre):
    """Closed form; at 6.9 part of it lies beyond the end."""
    peak = stats.norm(centre, width)
    rule, values = follow(lambda x: peak.logpdf(x)[None], np.linspace(-5, 7, 26))
    truth = np.log(peak.cdf(7) - peak.cdf(-5))
    assert abs(logsumexp(values[0], b=rule.weights) - truth) < 1e-7


def test_two_peaks_far_apart_are_both_followed():
    """Closed form: masses 1 and 1e-6, of equal widths."""
    left, right = stats.norm(-3, 0.2), stats.norm(5, 0.2)

    def density(x):
        return np.logaddexp(left.logpdf(x), np.log(1e-6) + right.logpdf(x))[None]

    rule, values = follow(density, np.linspace(-5, 7, 26))
    mass = rule.weights * np.exp(values[0])
    assert mass[rule.nodes < 1].sum() == pytest.approx(1, rel=1e-7)
    assert mass[rule.nodes > 1].sum() == pytest.approx(1e-6, rel=1e-3)


def test_a_density_that_piles_up_at_an_end_is_followed():
    """Closed form: an exponential of scale 1e-6 against the lower end."""
    rate = 1e6
    rule, values = follow(lambda x: -rate * x[None], np.linspace(0, 1, 11))
    assert logsumexp(values[0], b=rule.weights) == pytest.approx(-np.log(rate), abs=1e-7)
