"""Least trimmed squares: a known minimum, every subset tried, and two curves in one data set."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from bayescal.density.trimmed import KEPT, POINTS, trimmed_fits


def test_the_tightest_fit_is_the_best_of_all_halves():
    """Truth: least squares over every subset of half of twelve points."""
    rng = np.random.default_rng(4)
    x = np.column_stack([np.ones(12), rng.uniform(-1, 1, 12)])
    t = x @ [5, 2] + rng.normal(0, 1, 12)
    t[:4] += 20
    half = (12 + 2 + 1) // 2
    residual = [
        np.linalg.lstsq(x[list(chosen)], t[list(chosen)], rcond=None)[1][0]
        for chosen in combinations(range(12), half)
    ]
    amplitudes, scale = trimmed_fits(x, t)[0]
    assert scale == pytest.approx(np.sqrt(min(residual) / half), rel=1e-10)
    assert np.abs(t - x @ amplitudes)[:4].min() > 10


def test_both_of_two_curves_are_found():
    """A half takes some points of the other line with it, which pull it by a pixel or two."""
    x = np.column_stack([np.ones(600), np.linspace(-1, 1, 600)])
    lines = np.array([[100.0, 30.0], [160.0, -20.0]])
    which = np.random.default_rng(1).permutation(np.arange(600) % 2)
    t = (x * lines[which]).sum(axis=1) + np.random.default_rng(2).normal(0, 0.3, 600)
    found = trimmed_fits(x, t)
    assert len(x) > POINTS
    assert 2 <= len(found) <= KEPT
    for line in lines:
        assert min(np.abs(amplitudes - line).max() for amplitudes, _ in found) < 3


def test_no_more_points_than_coefficients_leave_nothing_to_trim():
    assert trimmed_fits(np.eye(3), np.arange(3.0)) == []
