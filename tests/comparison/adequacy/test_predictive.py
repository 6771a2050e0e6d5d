"""Posterior predictive checks against replication by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from bayescal.comparison.adequacy.predictive import (
    lag_one,
    posterior_predictive,
    tail_of_largest,
)
from tests.helpers.residual_problems import problem


def test_ppp_equals_replication_point_by_point():
    """Brute force: replicate pixels from each draw, compare standardised residuals."""
    rng = np.random.default_rng(9)
    x = np.repeat(np.linspace(0.2, 0.9, 9), 2)
    t = 100 + 50 * x + rng.normal(size=18)
    fitted = problem(x, t, 1)
    count = 4000
    sigma = rng.uniform(0.7, 1.5, count)
    b = np.polynomial.polynomial.polyfit(x, t, 1) + rng.normal(size=(count, 2)) * 0.3
    found = posterior_predictive(fitted, np.column_stack([b, sigma]), rng)
    f = b @ np.vstack([np.ones(18), x])
    copies = f + sigma[:, None] * rng.normal(size=f.shape)
    z = [(y - f) / sigma[:, None] for y in (t, copies)]
    outer = np.abs(x - 0.55) > np.median(np.abs(x - 0.55)) + 1e-12

    def means(v):
        return v.reshape(count, 9, 2).mean(axis=2)

    statistics = [
        [np.abs(v).max(axis=1) for v in z],
        [lag_one(means(v)) for v in z],
        [(v[:, outer] ** 2).mean(axis=1) / (v[:, ~outer] ** 2).mean(axis=1) for v in z],
    ]
    for test, (data, copy) in zip(found, statistics, strict=True):
        ppp = np.mean(copy >= data)
        assert abs(test.value - ppp) < 4 * np.sqrt(0.25 / count + 0.25 / 20_000), test.name
        assert test.p_value is None
        assert "not uniform" in test.meaning


def test_tail_of_the_largest_normal():
    a = np.array([0.5, 3.0, 12.0])
    exact = 1 - (2 * stats.norm.cdf(a[:2]) - 1) ** 20
    np.testing.assert_allclose(tail_of_largest(a, 20)[:2], exact, rtol=1e-9)
    np.testing.assert_allclose(tail_of_largest(a, 20)[2], 40 * stats.norm.sf(12), rtol=1e-9)


def test_a_planted_outlier_and_uneven_noise_are_concerns():
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 1, 40)
    noise = rng.normal(size=40)
    draws = np.tile([0.0, 0.0, 1.0], (400, 1))
    clean = posterior_predictive(problem(x, noise, 1), draws, rng)
    assert not any(test.concern for test in clean)
    noise[7] = 6.0
    largest, *_ = posterior_predictive(problem(x, noise, 1), draws, rng)
    assert largest.concern
    assert largest.value == pytest.approx(40 * 2 * stats.norm.sf(6), rel=1e-6)
    uneven = np.where(np.abs(x) > 0.5, 3, 1) * rng.normal(size=40)
    draws[:, 2] = np.sqrt(5)
    assert posterior_predictive(problem(x, uneven, 1), draws, rng)[2].concern


def test_the_autocorrelation_of_noise_has_the_variance_claimed():
    """(k - 1) / (k (k + 2)) for k standard normals, uncentred."""
    values = lag_one(np.random.default_rng(0).normal(size=(50_000, 30)))
    assert np.var(values) == pytest.approx(29 / (30 * 32), rel=4 * np.sqrt(2 / 50_000))


def test_known_sigma_needs_no_column_of_draws():
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 1, 20)
    t = rng.normal(size=20)
    fitted = problem(x, t, 1, sigma=1.0)
    draws = np.tile(np.polynomial.polynomial.polyfit(x, t, 1), (200, 1))
    wide = np.column_stack([draws, np.full(200, 77.0)])  # a tau column is ignored
    few = posterior_predictive(fitted, draws, np.random.default_rng(1))
    assert few == posterior_predictive(fitted, wide, np.random.default_rng(1))
