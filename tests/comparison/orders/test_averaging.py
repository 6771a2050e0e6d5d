"""Predictions averaged over orders, against draws of the mixture."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.legendre import legvander

from bayescal.comparison.evidence import probabilities
from bayescal.comparison.orders.averaging import PLACES, averaged_prediction
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.differences import amplitude_draws
from tests.helpers.problems import make_model, thesis_axis


@pytest.mark.parametrize("axis", ["r", "c"])
def test_the_average_is_that_of_draws_of_every_order(axis):
    """Truth: order drawn by its probability, amplitudes from its closed form; 5 errors."""
    data, rng, n = thesis_axis(axis), np.random.default_rng(0), 60_000
    exact = {k: exact_posterior(make_model(data, k)) for k in range(1, 6)}
    chances = dict(zip(exact, probabilities([e.log_evidence for e in exact.values()]), strict=True))
    found = averaged_prediction(data.domain, exact, chances, 3)
    parts = [
        amplitude_draws(exact[k], rng, count) @ legvander(np.array(PLACES), k).T
        for k, count in zip(exact, rng.multinomial(n, list(chances.values())), strict=True)
    ]
    draws = np.concatenate(parts)
    assert np.abs((draws.mean(axis=0) - found.mean) / found.sd).max() < 5 / np.sqrt(n)
    z = (draws - found.mean) / found.sd
    error = np.sqrt(((z**4).mean(axis=0) - 1) / n)
    assert (np.abs((z**2).mean(axis=0) - 1) < 5 * error).all()
    assert found.x == pytest.approx(data.domain.middle + data.domain.half_range * np.array(PLACES))


def test_the_part_between_orders_is_the_scatter_of_their_means():
    """Truth: with one order certain there is none; with two alike it is half their distance."""
    data = thesis_axis("c")
    exact = {k: exact_posterior(make_model(data, k)) for k in (1, 2)}
    sure = averaged_prediction(data.domain, exact, {1: 0.0, 2: 1.0}, 2)
    np.testing.assert_allclose(sure.between, 0, atol=1e-9)
    np.testing.assert_allclose(sure.sd, sure.chosen_sd, rtol=1e-12)
    even = averaged_prediction(data.domain, exact, {1: 0.5, 2: 0.5}, 1)
    other = averaged_prediction(data.domain, exact, {1: 0.5, 2: 0.5}, 2)
    np.testing.assert_allclose(even.between, np.abs(even.chosen - other.chosen) / 2, rtol=1e-9)
