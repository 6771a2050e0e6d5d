"""Chi-squared and F tests against scipy.stats and generated data."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from bayescal.comparison.criteria.goodness import goodness_of_fit, reference_sigma
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import make_axis, thesis_axis

AGREE = 1e-10  # relative: scipy's tails are good to some 1e-14, chi2 to 1e-13


def fits(data, highest):
    factors = factorise(data, highest)
    return {k: solve(factors, k) for k in range(1, highest + 1)}


@pytest.mark.parametrize("sigma", [1.0, 3.3, 6.0])
@pytest.mark.parametrize("order", [1, 3, 5])
def test_both_tails_of_chi_squared_are_scipys(order, sigma):
    """Known sigma: upper and lower tail at n - p degrees of freedom."""
    found = fits(thesis_axis("c"), 5)
    reference = reference_sigma(NoiseLevel.known(sigma), found[5])
    result = goodness_of_fit(found[order], found[5], reference)
    chi2 = found[order].rss / sigma**2
    law = stats.chi2(57 - order - 1)
    assert (reference.source, reference.value, reference.dof) == ("known", sigma, None)
    assert result.chi2 == pytest.approx(chi2, rel=AGREE)
    assert result.dof == 56 - order
    assert result.chi2_reduced == pytest.approx(chi2 / (56 - order), rel=AGREE)
    assert result.chi2_reduced_sd == pytest.approx(law.std() / law.mean(), rel=AGREE)
    assert result.p_value == pytest.approx(law.sf(chi2), rel=AGREE)
    assert result.p_value_lower == pytest.approx(law.cdf(chi2), rel=AGREE)
    assert result.p_value + result.p_value_lower == pytest.approx(1, abs=1e-12)
    assert result.f_p_value is None


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("axis", ["r", "c"])
def test_f_test_of_the_dropped_orders_is_scipys(axis, order):
    """F = (RSS_k - RSS_5) / (5 - k) over RSS_5 / (n - 6)."""
    found = fits(thesis_axis(axis), 5)
    reference = reference_sigma(NoiseLevel.inferred(), found[5])
    result = goodness_of_fit(found[order], found[5], reference)
    f = ((found[order].rss - found[5].rss) / (5 - order)) / (found[5].rss / 51)
    assert (reference.source, reference.dof) == ("highest-order", 51)
    assert reference.value == pytest.approx(math.sqrt(found[5].rss / 51), rel=AGREE)
    assert result.f_p_value == pytest.approx(stats.f(5 - order, 51).sf(f), rel=AGREE)
    assert (result.p_value, result.p_value_lower) == (None, None)


def test_an_f_test_of_one_dropped_order_is_the_squared_t_of_its_coefficient():
    """Identity: F(1, nu) = t(nu)^2, from the highest amplitude and its standard error."""
    data = thesis_axis("r")
    found = fits(data, 4)
    top = found[4]
    t = top.coefficients[-1] / top.standard_errors[-1]
    reference = reference_sigma(NoiseLevel.inferred(), top)
    result = goodness_of_fit(found[3], top, reference)
    assert result.f_p_value == pytest.approx(2 * stats.t(top.dof).sf(abs(t)), rel=1e-9)


def test_the_highest_order_has_a_reduced_chi_squared_of_one_by_construction():
    found = fits(thesis_axis("r"), 5)
    reference = reference_sigma(NoiseLevel.inferred(), found[5])
    result = goodness_of_fit(found[5], found[5], reference)
    assert result.chi2_reduced == pytest.approx(1, rel=AGREE)
    assert result.f_p_value is None


def test_lack_of_fit_against_replicates_is_the_textbooks_f_test():
    """Draper & Smith 2.1: (RSS - SS_pure) / (m - p) over SS_pure / (n - m), m values of x."""
    rng = np.random.default_rng(1)
    x = np.repeat(np.linspace(-1, 1, 8), 3)
    t = 500 + 100 * x + 8 * x**3 + rng.normal(0, 2, 24)
    found = fits(make_axis(x, t), 3)
    pure = float(sum(((v - v.mean()) ** 2).sum() for v in t.reshape(8, 3)))
    reference = reference_sigma(NoiseLevel.inferred(), found[3], (math.sqrt(pure / 16), 16))
    assert (reference.source, reference.dof) == ("replicates", 16)
    for order in (1, 2, 3):
        result = goodness_of_fit(found[order], found[3], reference)
        lacking = 8 - order - 1
        f = ((found[order].rss - pure) / lacking) / (pure / 16)
        assert result.f_p_value == pytest.approx(stats.f(lacking, 16).sf(f), rel=AGREE)
        assert result.p_value is None


def test_no_degree_of_freedom_leaves_nothing_to_test():
    x = np.linspace(-1, 1, 4)
    found = fits(make_axis(x, 500 + 100 * np.sin(5 * x)), 3)
    known = goodness_of_fit(found[3], found[3], reference_sigma(NoiseLevel.known(1.0), found[3]))
    assert (known.dof, known.chi2_reduced, known.chi2_reduced_sd, known.p_value) == (0, *[None] * 3)
    reference = reference_sigma(NoiseLevel.inferred(), found[3])
    assert reference.value is None
    assert goodness_of_fit(found[1], found[3], reference).f_p_value is None


def test_p_values_of_right_models_are_uniform():
    """Monte Carlo: K-S of 400 p-values each, chi-squared at known sigma and F without."""
    rng = np.random.default_rng(6)
    x = np.linspace(-1, 1, 25)
    of_chi2, of_f = [], []
    for _ in range(400):
        found = fits(make_axis(x, 500 + 100 * x + rng.normal(0, 2, 25)), 3)
        known = reference_sigma(NoiseLevel.known(2.0), found[3])
        inferred = reference_sigma(NoiseLevel.inferred(), found[3])
        of_chi2.append(goodness_of_fit(found[1], found[3], known).p_value)
        of_f.append(goodness_of_fit(found[1], found[3], inferred).f_p_value)
    assert stats.kstest(of_chi2, "uniform").pvalue > 1e-3
    assert stats.kstest(of_f, "uniform").pvalue > 1e-3


def test_p_values_at_a_wrong_sigma_are_not_uniform():
    """Negative control: noise of 2 px judged as 2.3 px."""
    rng = np.random.default_rng(6)
    x = np.linspace(-1, 1, 25)
    of_chi2 = []
    for _ in range(400):
        found = fits(make_axis(x, 500 + 100 * x + rng.normal(0, 2, 25)), 1)
        reference = reference_sigma(NoiseLevel.known(2.3), found[1])
        of_chi2.append(goodness_of_fit(found[1], found[1], reference).p_value)
    assert stats.kstest(of_chi2, "uniform").pvalue < 1e-6
