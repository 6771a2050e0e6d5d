"""Rounding: JCGM 100:2008, 7.2.6, its worked examples, ties and extremes."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from bayescal.rounding import counted, decimals_for, percent, rounded, significant

UNCERTAINTIES = st.floats(min_value=1e-7, max_value=9e6)
VALUES = st.floats(min_value=-1e9, max_value=1e9)


def test_worked_examples_of_the_guide() -> None:
    # "if y = 10.057 62 ohm with u_c(y) = 27 mohm, y should be rounded to 10.058 ohm"
    assert rounded(10.05762, 0.027) == "10.058"
    # "u(x_i) = 28.05 kHz should be rounded down to 28 kHz"
    assert significant(28.05) == "28"
    # "u_c(y) = 10.47 mohm": to the nearest; rounding up to 11 is allowed, not asked for
    assert significant(10.47) == "10"
    # 7.2.2: m = 100.021 47 g with u_c = 0.35 mg
    assert rounded(100.02147, 0.35e-3) == "100.02147"
    assert significant(0.35e-3) == "0.00035"
    # 7.2.4: U = 0.79 mg
    assert rounded(100.02147, 0.79e-3) == "100.02147"


@pytest.mark.parametrize(
    ("uncertainty", "shown", "value", "beside_it"),
    [
        (0.0994, "0.099", 1.23456, "1.235"),
        (0.0996, "0.10", 1.23456, "1.23"),  # rounding carries into a new digit
        (0.9949, "0.99", 123.456, "123.46"),
        (0.996, "1.0", 123.456, "123.5"),
        (9.96, "10", 123.456, "123"),
        (99.6, "100", 123.456, "120"),
        (100.0, "100", 123.456, "120"),
        (1234.5, "1200", 123456.0, "123500"),
        (1.0, "1.0", -0.5, "-0.5"),
        (10.0, "10", -99.5, "-100"),
        (45.0, "45", 203.4, "203"),
        (0.004, "0.0040", 0.0, "0.0000"),
        (4.1e-13, "4.1e-13", 4.72e-13, "4.7e-13"),
        (9.9e-10, "9.9e-10", -1.234e-8, "-1.234e-08"),
        (1e-10, "1.0e-10", 0.5, "0.50000000"),
    ],
)
def test_two_digits_and_a_value_to_the_same_place(
    uncertainty: float, shown: str, value: float, beside_it: str
) -> None:
    assert significant(uncertainty) == shown
    assert rounded(value, uncertainty) == beside_it


def test_exact_ties_go_to_the_even_digit() -> None:
    """As ISO 80000-1, B.3, rule A: a long series of them keeps its mean."""
    assert [rounded(v, 10) for v in (0.5, 1.5, 2.5, 3.5, -2.5)] == ["0", "2", "2", "4", "-2"]
    assert [rounded(v, 1) for v in (0.25, 0.75, -0.25)] == ["0.2", "0.8", "-0.2"]
    assert [rounded(v, 100) for v in (5.0, 15.0, 25.0)] == ["0", "20", "20"]
    assert significant(2.5, 1) == "2"
    assert significant(3.5, 1) == "4"


def test_what_looks_like_a_tie_is_rounded_as_the_number_it_is() -> None:
    assert Fraction(2.675) < Fraction("2.675")  # the double is below
    assert rounded(2.675, 0.1) == "2.67"
    assert Fraction(1.005) < Fraction("1.005")
    assert rounded(1.005, 0.1) == "1.00"


@given(value=VALUES, uncertainty=UNCERTAINTIES)
@example(value=999.9996, uncertainty=0.01)
@example(value=0.05, uncertainty=0.095)
def test_rounding_costs_at_most_half_a_unit_of_the_last_place(
    value: float, uncertainty: float
) -> None:
    unit = Decimal(10) ** -decimals_for(uncertainty)
    error = abs(Decimal(rounded(value, uncertainty)) - Decimal(value))
    assert error <= unit / 2 * (1 + Decimal("1e-6"))
    # Two digits: the unit is from 1 % to 10 % of the uncertainty.
    assert Decimal("0.0099") <= unit / Decimal(uncertainty) <= Decimal("0.101")


@given(value=VALUES, uncertainty=UNCERTAINTIES)
def test_value_and_uncertainty_show_the_same_decimals(value: float, uncertainty: float) -> None:
    def decimals(shown: str) -> int:
        return len(shown.partition(".")[2])

    assert decimals(rounded(value, uncertainty)) == decimals(significant(uncertainty))


@given(value=st.floats(min_value=1e-5, max_value=1e6), digits=st.integers(1, 3))
def test_significant_digits(value: float, digits: int) -> None:
    shown = significant(value, digits)
    assert "e" not in shown
    assert abs(Decimal(shown) - Decimal(value)) <= Decimal(value) * Decimal(10) ** (1 - digits)
    assert len(shown.replace(".", "").lstrip("0").rstrip("0")) <= digits


@given(
    value=st.floats(min_value=-1e300, max_value=1e300),
    uncertainty=st.floats(min_value=0, max_value=1e300),
)
@example(value=1e300, uncertainty=1e290)
@example(value=5e-324, uncertainty=5e-324)
@example(value=1.0, uncertainty=0.0)
@example(value=-0.0, uncertainty=1e-320)
def test_extremes_stay_short_numbers(value: float, uncertainty: float) -> None:
    for shown in (rounded(value, uncertainty), significant(uncertainty)):
        assert math.isfinite(float(shown))
    assert float(significant(uncertainty)) == pytest.approx(uncertainty, rel=0.051, abs=1e-322)


@pytest.mark.parametrize("value", [986.5532, -986.5532, 0.0123])
@pytest.mark.parametrize("uncertainty", [1e-9, 1e-12, 1e-20])
def test_a_tiny_uncertainty_never_hides_digits(value: float, uncertainty: float) -> None:
    """What is known to 1e-12 may not be printed as if it were known to 0.1."""
    assert float(rounded(value, uncertainty)) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize("uncertainty", [1.0, 10.0, 100.0])
def test_no_minus_sign_on_zero(uncertainty: float) -> None:
    assert not rounded(-uncertainty / 1000, uncertainty).startswith("-")


def test_one_thing_is_singular() -> None:
    assert [counted(n, "point") for n in range(3)] == ["0 points", "1 point", "2 points"]


@pytest.mark.parametrize(
    ("probability", "text"),
    [(1.0, ">99.9%"), (0.9994, "99.9%"), (0.5, "50%"), (0.095, "9.5%"), (0.0001, "<0.1%")],
)
def test_percentages_keep_the_digits_that_matter(probability, text):
    assert percent(probability) == text
