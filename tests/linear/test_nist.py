"""NIST's certified regressions through the public door."""

from __future__ import annotations

import pytest
from mpmath import mpf, workdps

import bayescal as bc
from tests.helpers.exact_least_squares import DIGITS, correct_digits, exact_fit
from tests.helpers.nist import SETS, Reference

# Correct digits to reach. Rounding y to doubles alone moves a coefficient by up to
# eps max|y| over its size: on the Wampler sets, whose first coefficients are 3e6 (1 and 4)
# and 60 (2) times smaller than y, that leaves 9 and 14 digits, and the fit loses another
# one or two to cond(X) of the Legendre columns. Norris's intercept is 4e3 times smaller
# than y. Filip's large coefficients cancel in y, but come from amplitudes that don't.
REACH = {"Norris": 11, "Wampler1": 8, "Wampler2": 11, "Wampler4": 8, "Filip": 12}


def fitted(reference: Reference):
    x, y = ([float(v) for v in column] for column in (reference.x, reference.y))
    return bc.least_squares(x, y, reference.order)


@pytest.mark.parametrize("name", SETS)
def test_coefficients_have_the_digits_of_nist(name):
    found = fitted(SETS[name]).coefficients
    pairs = zip(found, SETS[name].coefficients, strict=True)
    assert min(correct_digits(value, truth) for value, truth in pairs) >= REACH[name]


@pytest.mark.parametrize("name", SETS)
def test_standard_errors_have_the_digits_of_nist(name):
    found = fitted(SETS[name]).standard_errors
    pairs = zip(found, SETS[name].standard_errors, strict=True)
    assert min(correct_digits(value, truth) for value, truth in pairs) >= REACH[name]


@pytest.mark.parametrize("name", ["Wampler1", "Wampler2"])
def test_nists_polynomials_without_noise_count_as_exact_fits(name):
    assert fitted(SETS[name]).exact


@pytest.mark.parametrize("name", ["Norris", "Wampler4", "Filip"])
def test_nists_noisy_sets_do_not_count_as_exact_fits(name):
    assert not fitted(SETS[name]).exact


@pytest.mark.parametrize("name", ["Norris", "Wampler4", "Filip"])
def test_restated_rows_give_the_certified_values_in_80_digits(name):
    """A slip in a restated row would move these; certified to 15 digits, so 13.5 or more."""
    reference = SETS[name]
    with workdps(DIGITS):
        x, y = ([mpf(v) for v in column] for column in (reference.x, reference.y))
        truth = exact_fit(x, y, reference.order)
    found = [*truth.coefficients, *truth.standard_errors]
    certified = [*reference.coefficients, *reference.standard_errors]
    pairs = zip(found, certified, strict=True)
    assert min(correct_digits(value, text) for value, text in pairs) > 13.5
