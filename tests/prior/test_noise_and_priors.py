"""Noise levels and priors: their densities, and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.noise.level import NoiseLevel
from bayescal.points.pixel import pixel_of
from bayescal.points.setup import StatedPrior
from bayescal.prior.amplitudes import PriorRule


def test_ln_sigma_is_uniform_between_a_hundredth_and_a_thousand_px():
    """Closed form: scipy's log-uniform density, per unit of ln sigma."""
    level = NoiseLevel.inferred()
    sigma = 3.7
    truth = stats.loguniform(0.01, 1000).logpdf(sigma) + math.log(sigma)
    assert level.log_prior() == pytest.approx(truth, rel=1e-14)
    assert level.log_bounds == pytest.approx((math.log(0.01), math.log(1000)))


@pytest.mark.parametrize("pixel", [1.0, 0.25])
def test_ln_tau_is_uniform_between_a_hundredth_of_a_pixel_and_half_the_image(pixel):
    """Closed form: scipy's log-uniform density, from sigma's own lower bound."""
    prior = PriorRule("field", 1000.0, 500.0, pixel=pixel).of_order(3)
    tau = 0.02
    truth = stats.loguniform(0.01 * pixel / 1000, 0.5).logpdf(tau) + math.log(tau)
    assert prior.log_tau_density() == pytest.approx(truth, rel=1e-14)
    assert prior.infers_tau


def test_an_inferred_sigma_stays_above_the_rounding_of_whole_pixels():
    """Truth: the deviation of a uniform of width 1; the density above it is as without."""
    whole, fine = np.array([3.0, 5.0, 8.0]), np.array([3.0, 5.0, 8.25])
    free = NoiseLevel.inferred()
    level = free.on_readings(whole)
    assert level.bounds == pytest.approx((stats.uniform.std(), 1000))
    assert level.log_prior() == pytest.approx(free.log_prior(), rel=1e-14)
    above = stats.loguniform(0.01, 1000).sf(stats.uniform.std())
    assert level.mass == pytest.approx(above, rel=1e-12)
    assert level.on_readings(whole) == level
    assert free.on_readings(fine) == free
    assert NoiseLevel.known(0.1).on_readings(whole) == NoiseLevel.known(0.1)
    scaled = NoiseLevel.scale().on_readings(whole, np.array([2.0, 2.0, 1e4]))
    assert scaled.bounds[0] == pytest.approx(stats.uniform.std() / 2)


def test_known_sigma_and_fixed_tau_have_no_density():
    assert NoiseLevel.known(0.8).log_prior() == 0
    prior = PriorRule("field", 1000.0, 500.0, tau=0.05).of_order(3)
    assert prior.log_tau_density() == 0
    assert not prior.infers_tau


def test_where_the_image_size_is_unknown_the_span_makes_the_pixel():
    """Readings divided by the width, told or not told to be: noise of a pixel is inside."""
    assert pixel_of(1920.0, known=True) == pixel_of(640.0, known=True) == 1
    assert pixel_of(960.0, known=False) == pytest.approx(0.5)
    assert pixel_of(1.0, known=True) == pixel_of(1.0, known=False) == pytest.approx(1 / 1920)
    level = NoiseLevel.inferred_in(pixel_of(0.6, known=False))
    assert level.bounds == pytest.approx((0.01 * 0.6 / 1920, 1000 * 0.6 / 1920))


@pytest.mark.parametrize("tau", [0.001, 0.05, 0.5])
def test_field_prior_is_the_stated_one(tau):
    """b_0 ~ N(size/2, (size/2)^2), b_1 ~ N(0, (size/2)^2), b_j ~ N(0, (tau size)^2)."""
    prior = PriorRule("field", 1920.0, 960.0).of_order(4)
    np.testing.assert_allclose(prior.mean, [960, 0, 0, 0, 0])
    truth = [960, 960, *[tau * 1920] * 3]
    np.testing.assert_allclose(prior.deviations(np.log([tau]))[0], truth, rtol=1e-14)


def test_a_straight_line_has_no_tau():
    assert not PriorRule("field", 1920.0, 960.0).of_order(1).infers_tau


def test_flat_prior_is_improper():
    prior = PriorRule("flat", 1920.0, 960.0).of_order(3)
    assert not prior.proper
    assert not prior.infers_tau


def test_a_stated_prior_gives_its_leading_entries():
    stated = StatedPrior((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    prior = PriorRule("stated", 1920.0, 960.0, stated=stated).of_order(1)
    assert (prior.mean.tolist(), prior.sd.tolist()) == ([1, 2], [4, 5])
    assert prior.proper
    assert not prior.infers_tau


@pytest.mark.parametrize(
    "arguments",
    [
        {"name": "jeffreys"},
        {"name": "stated"},
        {"name": "flat", "tau": 0.05},
        {"name": "field", "tau": 0.0},
        {"name": "field", "tau": math.inf},
    ],
)
def test_unusable_priors_are_refused(arguments):
    with pytest.raises(bc.InputError):
        PriorRule(size=1920.0, centre=960.0, **arguments)


def test_a_stated_prior_that_does_not_reach_the_order_is_refused():
    stated = StatedPrior((1.0, 2.0), (4.0, 5.0))
    with pytest.raises(bc.InputError, match="2 entries but order 2 has 3"):
        PriorRule("stated", 1920.0, 960.0, stated=stated).of_order(2)


@pytest.mark.parametrize("sigma", [0.0, -1.0, math.nan, math.inf])
def test_unusable_sigmas_are_refused(sigma):
    with pytest.raises(bc.InputError):
        NoiseLevel.known(sigma)
