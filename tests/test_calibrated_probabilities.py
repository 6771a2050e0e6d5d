"""Probabilities of orders are what they say: ./scripts/validate orders on fewer data sets.

Truths: the order each data set was made with, drawn with every parameter from the prior as
docs/method.md states it (scripts/validation/simulated_orders.py does not draw with the program's
prior).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from scipy import stats

from bayescal.arrays import Array
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.quadrature import FINE
from scripts.validation.orders import HEADING, QUICK, SIZES, honest
from scripts.validation.sections import with_section
from scripts.validation.simulated_orders import (
    ORDERS,
    WIDTH,
    Bin,
    Claims,
    Problem,
    draw,
    log_evidences,
    poisson_binomial_quantile,
)
from tests.helpers.problems import make_axis, make_model

SETS = 1000


@dataclass(frozen=True, eq=False)
class Measured:
    """Data sets of known order, and the log evidence of every order on each."""

    problem: Problem
    log_evidence: Array


@pytest.fixture(scope="module", params=SIZES)
def measured(request) -> Measured:
    """Order and every parameter from the prior, n = 30, 57, 200."""
    problem = draw(request.param, SETS, np.random.default_rng(request.param))
    return Measured(problem, log_evidences(problem, accuracy=QUICK))


def test_probabilities_are_calibrated_and_very_strong_claims_hold(measured):
    """Every bin of pairs within 4 standard errors; wrong claims within their 99.9 % quantile."""
    claims = Claims.of(measured.log_evidence, measured.problem.order)
    assert [b.deviations for b in claims.bins() if not b.calibrated] == []
    assert claims.very_strong().honest


def test_a_prior_of_another_strength_is_caught(measured):
    """Negative control: tau fixed at 0.05 in the analysis, from 0.001 to 0.5 in the data."""
    wrong = log_evidences(measured.problem, tau=0.05, accuracy=QUICK)
    claims = Claims.of(wrong, measured.problem.order)
    assert not all(b.calibrated for b in claims.bins())
    assert not honest(claims)


def test_very_strong_claims_that_exaggerate_are_caught(measured):
    """Negative control: odds to the fourth power make wrong claims very strong."""
    claims = Claims.of(4 * measured.log_evidence, measured.problem.order)
    assert not claims.very_strong().honest


def test_evidences_in_bulk_are_those_of_single_models():
    """Truth: the closed form of one model on one data set, from the points themselves."""
    rng = np.random.default_rng(1)
    problem = draw(57, 6, rng)
    bulk = {tau: log_evidences(problem, tau, FINE) for tau in (None, 0.05)}
    quick = log_evidences(problem, accuracy=QUICK)
    x = problem.design[:, 1]  # P_1(s) = s
    for row, t in enumerate(problem.t):
        data = make_axis(x, t, WIDTH)
        for (column, order), tau in product(enumerate(ORDERS), bulk):
            truth = exact_posterior(make_model(data, order, tau=tau)).log_evidence
            assert bulk[tau][row, column] == pytest.approx(truth, abs=1e-6)
            if tau is None:
                assert quick[row, column] == pytest.approx(truth, abs=2e-3)


def test_the_quantile_of_equal_chances_is_the_binomial():
    """Truth: scipy's binomial quantile."""
    for n, p in product((1, 10, 300), (0.001, 0.2, 0.97)):
        assert poisson_binomial_quantile(np.full(n, p), 0.999) == stats.binom.ppf(0.999, n, p)


def test_the_quantile_of_unequal_chances_sums_over_all_outcomes():
    """Truth: all 2^8 outcomes, one by one."""
    p = np.random.default_rng(2).uniform(size=8)
    outcomes = np.array(list(product((0, 1), repeat=len(p))))
    chance = np.where(outcomes == 1, p, 1 - p).prod(axis=1)
    for level in (0.05, 0.5, 0.9, 0.999):
        truth = next(k for k in range(9) if chance[outcomes.sum(axis=1) <= k].sum() >= level)
        assert poisson_binomial_quantile(p, level) == truth


def test_the_section_is_replaced_and_nothing_else():
    before, after = "# Title\n\ntext\n", "## Next\n\nmore\n"
    section = f"{HEADING}\n\nnew \\1 numbers\n"
    added = with_section(before, section, HEADING)
    assert added == f"{before}\n{section}"
    assert with_section(added, section, HEADING) == added
    old = f"{before}\n{HEADING}\n\nold\n\n{after}"
    assert with_section(old, section, HEADING) == f"{before}\n{section}\n{after}"


def test_errors_of_a_bin_count_that_one_order_is_true():
    """Truths: independent pairs; all orders of a set, of which exactly one is true."""
    apart = Bin.of(np.array([0.5, 0.2]), np.array([0, 1]), 2)
    assert apart.binomial_error == apart.exact_error == pytest.approx(np.sqrt(0.25 + 0.16))
    assert apart.deviations == pytest.approx((1.3 / np.sqrt(0.41),) * 2)
    together = np.array([0.1, 0.2, 0.3, 0.25, 0.15])
    whole = Bin.of(together, np.zeros(5, dtype=int), 1)
    assert whole.binomial_error == pytest.approx(np.sqrt((together * (1 - together)).sum()))
    assert (whole.exact_error < 1e-7, whole.calibrated) == (True, True)
    assert not Bin.of(together, np.zeros(5, dtype=int), 2).calibrated
