"""Errors of the world coordinates carried to pixels: closed forms and coverage."""

import dataclasses

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.settings import Settings, noise_level, prior_rule
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise
from bayescal.linear.model import LinearModel
from bayescal.polynomials.separable import axis_data

TRUTH = np.array([986.0, 1066.0, -23.0, -96.0, 203.0])  # px, near the thesis's r
PIXEL_SIGMA, WORLD_SIGMA, SETS = 0.5, 1.0, 1000


@pytest.fixture(scope="module")
def thesis():
    return bc.thesis()


def simulated(thesis, rng):
    """Points whose pixels follow TRUTH at the true places, read with errors of 1 unit."""
    camera = thesis.camera_frame()
    pixel = np.polynomial.polynomial.polyval(camera[:, 0] / camera[:, 2], TRUTH)
    pixels = np.column_stack([pixel + rng.normal(0, PIXEL_SIGMA, 57), thesis.pixels[:, 1]])
    world = thesis.world + rng.normal(0, WORLD_SIGMA, (57, 3))
    setup = dataclasses.replace(thesis.setup, world_sigma=(WORLD_SIGMA,) * 3)
    return axis_data(bc.Correspondences.from_arrays(world, pixels, setup=setup), "r")


def covered(data):
    """Which coefficients' central 95 % intervals hold the truth, without sampling."""
    settings = Settings(sigma=PIXEL_SIGMA)
    data, level, _ = noise_level(data, settings, None, 4)
    factors = factorise(data, 4)
    prior = prior_rule(data, settings, None).of_order(4)
    exact = exact_posterior(LinearModel(factors, 4, level, prior))
    low, high = exact.quantiles(factors.monomials.lead(4), np.array([0.025, 0.975])).T
    return (low < TRUTH) & (high > TRUTH)


def test_intervals_cover_the_truth_where_plain_pixel_noise_fails(thesis):
    """95 % within 4 binomial standard errors for each coefficient; control: no world errors."""
    rng = np.random.default_rng(4)
    with_errors, plain = [], []
    for _ in range(SETS):
        data = simulated(thesis, rng)
        with_errors.append(covered(data))
        plain.append(covered(dataclasses.replace(data, x_sd=None)))
    error = np.sqrt(0.95 * 0.05 / SETS)
    assert (np.abs(np.mean(with_errors, axis=0) - 0.95) < 4 * error).all()
    assert (np.mean(plain, axis=0) < 0.7).all()


def test_a_straight_line_has_the_slope_itself(thesis):
    """Order 1: sd_i^2 = sigma^2 + slope^2 (sx^2/z^2 + x^2 sz^2/z^4), slope of the weighted fit."""
    setup = dataclasses.replace(thesis.setup, world_sigma=(0.5, 0.0, 2.0))
    data = axis_data(dataclasses.replace(thesis, setup=setup), "r")
    found, level, words = noise_level(data, Settings(sigma=0.8), None, 1)
    x, _, z = thesis.camera_frame().T
    slope = np.polynomial.polynomial.polyfit(x / z, data.t, 1, w=1 / found.sd)[1]
    expected = np.sqrt(0.8**2 + slope**2 * (0.25 / z**2 + x**2 * 4 / z**4))
    np.testing.assert_allclose(found.sd, expected, rtol=1e-9)
    assert level.source == "known"
    assert "effective variances" in words


def test_no_world_errors_leave_the_pixels_alone(thesis):
    setup = dataclasses.replace(thesis.setup, world_sigma=(0.0, 0.0, 0.0))
    data = axis_data(dataclasses.replace(thesis, setup=setup), "c")
    found, level, _ = noise_level(data, Settings(sigma=0.8), None, 3)
    assert found.sd is None
    assert level.value == 0.8


def test_columns_go_before_the_setup(thesis):
    own = bc.Correspondences.from_arrays(
        thesis.world,
        thesis.pixels,
        sigma_x=np.full(57, 3.0),
        setup=dataclasses.replace(thesis.setup, world_sigma=(1.0, 1.0, 2.0)),
    )
    np.testing.assert_array_equal(own.world_sigma(), np.tile([3.0, 1.0, 2.0], (57, 1)))


def test_world_errors_without_pixel_noise_are_refused(thesis):
    setup = dataclasses.replace(thesis.setup, world_sigma=(1.0, 1.0, 1.0))
    with pytest.raises(bc.InputError, match="add --sigma PX or a column sigma_r"):
        bc.compare(dataclasses.replace(thesis, setup=setup), [1])
