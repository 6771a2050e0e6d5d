"""Hogg, Bovy & Lang 2010 (arXiv:1008.4686), Table 1: twenty points, four of them bad."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.report.numbers import point_chances
from tests.helpers.hogg import TABLE

# Their Figure 1: the line through points 5 to 20, slope and intercept with standard errors.
SLOPE, SLOPE_SE = 2.24, 0.11
INTERCEPT, INTERCEPT_SE = 34.0, 18.0


def test_least_squares_without_the_bad_points_is_the_published_line():
    x, y, sd = TABLE[4:].T
    fit = bc.least_squares(x, y, 1, sd=sd)
    assert fit.coefficients[1] == pytest.approx(SLOPE, abs=0.005)  # published to two decimals
    assert fit.coefficients[0] == pytest.approx(INTERCEPT, abs=0.5)
    assert fit.standard_errors == pytest.approx([INTERCEPT_SE, SLOPE_SE], rel=0.05)


def test_the_mixture_flags_points_2_3_and_4_and_finds_that_line_with_all_twenty():
    x, y, sd = TABLE.T
    result = bc.fit_polynomial(x, y, 1, sigma=sd, noise="outlier-mixture", ess=1000)
    flagged = np.flatnonzero(point_chances(result).bad > 0.5) + 1
    assert {2, 3, 4} <= set(flagged.tolist()) <= {1, 2, 3, 4}  # point 1 is mild
    assert abs(result.posterior["beta_1"].mean - SLOPE) < SLOPE_SE
    assert abs(result.posterior["beta_0"].mean - INTERCEPT) < INTERCEPT_SE
    assert result.sound


def test_the_mixtures_order_3_converges():
    """Which points are bad differs from bend to bend; ln Z is that of three seeds."""
    x, y, sd = TABLE.T
    result = bc.fit_polynomial(x, y, 3, sigma=sd, noise="outlier-mixture", ess=1000)
    assert result.sound
    assert result.log_evidence == pytest.approx(-120.38, abs=4 * result.log_evidence_error + 0.01)
    assert result.log_evidence_error < 0.02


def test_gaussian_noise_is_led_astray_by_them():
    """Negative control: with all twenty points least squares is 10 standard errors off."""
    x, y, sd = TABLE.T
    fit = bc.least_squares(x, y, 1, sd=sd)
    assert abs(fit.coefficients[1] - SLOPE) > 10 * SLOPE_SE
