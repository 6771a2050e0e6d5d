"""Shape of the tail of importance weights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from arviz_stats.base import array_stats

from bayescal.inference.pareto import pareto_shape


@pytest.mark.parametrize("n", [50, 225, 226, 1000, 4000])
@pytest.mark.parametrize("scale", [0.1, 0.5, 1.0, 2.0, 5.0])
def test_shapes_are_those_of_arviz(n: int, scale: float) -> None:
    """Truth: ArviZ."""
    log_weights = scale * np.random.default_rng(n).standard_exponential(n)
    _, truth = array_stats.psislw(-log_weights, axis=-1)
    assert pareto_shape(log_weights) == pytest.approx(float(truth), abs=1e-9)


def test_tail_of_a_pareto_distribution_has_its_shape() -> None:
    """Truth: weights u^-k have shape k, of 300 tail draws known to (1 + k) / sqrt(300)."""
    for k in (0.2, 0.5, 0.9):
        log_weights = k * np.random.default_rng(1).standard_exponential(10_000)
        assert pareto_shape(log_weights) == pytest.approx(k, abs=4 * (1 + k) / math.sqrt(300))


@pytest.mark.parametrize("log_weights", [np.zeros(100), np.zeros(20), np.arange(24.0)])
def test_a_tail_without_a_shape(log_weights: np.ndarray) -> None:
    assert pareto_shape(log_weights) == math.inf


def test_draws_outside_the_support_change_nothing_of_the_tail() -> None:
    log_weights = np.random.default_rng(1).standard_exponential(1000)
    outside = np.where(np.arange(1000) % 2 & (log_weights < 0.5), -np.inf, log_weights)
    assert pareto_shape(outside) == pareto_shape(log_weights)
