"""Fits from subsets: every place that a group of points agrees on, by the noise model's weights."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.density.robust_fits import POINTS, LinearPixels, robust_fits
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT

LEVELS = (NoiseLevel.inferred(), NoiseLevel.inferred())
SIGMA = 0.5


ONE, OTHER = np.array([0, 20, 5, -3.0]), np.array([30, 40, 5, -3.0])


def two_lines(n, share):
    """r of a share of the points lies on another line than that of the rest; c on one line."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, n)
    slopes = np.zeros((2, n, 4))
    slopes[0, :, :2] = slopes[1, :, 2:] = np.column_stack([np.ones(n), x])
    values = np.where(rng.permutation(n) < share * n, slopes @ OTHER, slopes @ ONE)
    values += SIGMA * rng.standard_normal((2, n))
    return LinearPixels(
        values, slopes, np.zeros(4), 1e-6 * np.eye(4), np.ones((2, n)), LEVELS
    )  # fmt: skip


def nearest(found, line):
    """The fit nearest to a line, and its distance in units of sigma."""
    fit = min(found, key=lambda fit: np.abs(fit.x - line).max())
    return fit, np.abs(fit.x - line).max() / SIGMA


@pytest.mark.parametrize("n", [60, 3 * POINTS])
def test_each_line_that_half_of_the_points_lie_on_is_found(n):
    found = robust_fits(two_lines(n, 0.5), OutlierMixture())
    for line in (ONE, OTHER):
        fit, distance = nearest(found, line)
        assert distance < 5 * np.sqrt(6 / min(n, POINTS))
        # Sigma is taken from a grid of steps of 34 %.
        assert np.abs(fit.log_sigma - np.log(SIGMA)).max() < 0.35


@pytest.mark.parametrize("noise", [OutlierMixture(), StudentT()], ids=lambda noise: noise.name)
def test_a_fifth_of_the_points_does_not_draw_the_line_away(noise):
    _, distance = nearest(robust_fits(two_lines(100, 0.2), noise), ONE)
    assert distance < 5 * np.sqrt(3 / 80)


def test_clean_points_have_one_fit_that_of_least_squares():
    pixels = two_lines(60, 0.5)
    line = pixels.slopes @ ONE
    rng = np.random.default_rng(1)
    clean = LinearPixels(
        line + rng.normal(0, SIGMA, line.shape), pixels.slopes, pixels.prior_slope,
        pixels.prior_precision, pixels.deviations, LEVELS,
    )  # fmt: skip
    (fit,) = robust_fits(clean, StudentT(1e9))
    flat = clean.slopes.reshape(-1, 4)
    expected = np.linalg.lstsq(flat, clean.residuals.ravel(), rcond=None)[0]
    assert fit.x == pytest.approx(expected, abs=1e-5)


def test_a_prior_counts_as_its_precision_says():
    """Against points that say the same."""
    pixels = two_lines(30, 0.5)
    mean, sd = np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.1, 0.2, 0.3, 0.4])
    informed = LinearPixels(
        pixels.residuals, pixels.slopes, mean / sd**2, np.diag(sd**-2.0), pixels.deviations, LEVELS
    )
    precision = np.random.default_rng(2).uniform(0.5, 2, pixels.residuals.shape)
    rows = np.concatenate([pixels.slopes.reshape(-1, 4), np.eye(4)])
    values = np.concatenate([pixels.residuals.ravel(), mean])
    root = np.sqrt(np.concatenate([precision.ravel(), sd**-2.0]))
    expected = np.linalg.lstsq(rows * root[:, None], values * root, rcond=None)[0]
    assert informed.solve(precision) == pytest.approx(expected, rel=1e-10)
