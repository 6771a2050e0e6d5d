"""Draws of the closed form, and how far nested orders lie apart."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.legendre import legval, legvander

from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.differences import amplitude_draws, largest_differences
from bayescal.linear.least_squares import factorise
from tests.helpers.problems import make_axis, make_model, thesis_axis


@pytest.mark.parametrize(("axis", "order"), [("r", 4), ("c", 2), ("c", 1)])
def test_draws_have_the_moments_of_the_closed_form(axis, order):
    """Mean and covariance within 5 Monte Carlo errors, kurtosis of the closed form included."""
    exact = exact_posterior(make_model(thesis_axis(axis), order))
    n = 40_000
    draws = amplitude_draws(exact, np.random.default_rng(1), n)
    sd = np.sqrt(np.diag(exact.covariance))
    assert np.abs((draws.mean(axis=0) - exact.mean) / sd).max() < 5 / np.sqrt(n)
    # The kurtosis of an amplitude averaged over a wide tau may be some tens.
    fourth = (((draws - exact.mean) / sd) ** 4).mean(axis=0)
    found = np.cov(draws.T)
    error = np.sqrt(np.outer(fourth, fourth) ** 0.5 / n)
    assert (np.abs(found - exact.covariance) / np.outer(sd, sd) < 5 * error).all()


def test_a_difference_is_what_leaving_out_orders_costs_on_the_same_points():
    """Truth: numpy's weighted fit of the lower order to the higher one's curve at the points."""
    rng = np.random.default_rng(2)
    x, sd = np.sort(rng.uniform(-0.4, 0.7, 23)), rng.uniform(0.5, 3, 23)
    data = make_axis(x, rng.normal(500, 100, 23), sd=sd)
    amplitudes = rng.normal(0, 20, (50, 5))
    found = largest_differences(factorise(data, 4).r, amplitudes, 2)
    s, fine = data.domain.scale(x), np.linspace(-1, 1, 2001)
    for b, largest in zip(amplitudes, found, strict=True):
        low = np.linalg.lstsq(legvander(s, 2) / sd[:, None], legval(s, b) / sd)[0]
        truth = np.abs(legval(fine, b) - legval(fine, low)).max()
        # The largest of 201 places: the curve bends by at most some 1e-3 of itself between.
        assert largest == pytest.approx(truth, rel=5e-3)


def test_equal_orders_do_not_differ():
    data = thesis_axis("c")
    draws = np.ones((7, 3))
    assert (largest_differences(factorise(data, 3).r, draws, 2) == 0).all()
