"""What must not change an inference, and what must change it by a known amount."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import SIGMA_BOUNDS
from bayescal.points.setup import StatedPrior
from bayescal.polynomials.axis_data import AxisData
from tests.helpers.problems import make_axis, make_model
from tests.helpers.strategies import axes, settings_for

factors = st.sampled_from([1e-6, 0.01, 0.3, 1.0, 7.0, 1e4])


def reordered(data: AxisData, seed: int) -> AxisData:
    order = np.random.default_rng(seed).permutation(len(data))
    sd = None if data.sd is None else data.sd[order]
    labels = tuple(data.labels[i] for i in order)
    return replace(data, x=data.x[order], t=data.t[order], sd=sd, labels=labels)


def scaled(data: AxisData, k: float) -> AxisData:
    sd = None if data.sd is None else k * data.sd
    return replace(data, t=k * data.t, sd=sd, size=k * data.size)


def scaled_bounds(k: float) -> tuple[float, float]:
    return k * SIGMA_BOUNDS[0], k * SIGMA_BOUNDS[1]


@settings_for(40)
@given(axes(), st.integers(0, 1000), st.booleans())
def test_reordering_the_points_changes_nothing_beyond_rounding(problem, seed, weighted):
    """Identity: a sum does not depend on its order, to eps times cond(X) here."""
    data, order = problem
    if weighted:
        data = replace(data, sd=np.random.default_rng(seed).uniform(0.5, 4, len(data)))
    other = reordered(data, seed)
    first, second = make_model(data, order), make_model(other, order)
    a, b = exact_posterior(first), exact_posterior(second)
    assert a.log_evidence == pytest.approx(b.log_evidence, abs=1e-8)
    sd = a.summary[1]
    assert (np.abs(a.summary[0] - b.summary[0]) / sd).max() < 1e-7
    np.testing.assert_allclose(b.summary[1], sd, rtol=1e-7)
    theta = np.append(a.mean, [0.7, np.log(0.01)])[: first.dimension][None]
    np.testing.assert_allclose(log_prob(first, theta), log_prob(second, theta), rtol=1e-9)


@settings_for(40)
@given(axes(), factors, st.sampled_from([None, 0.05]))
def test_scaling_pixels_and_priors_shifts_the_evidence_by_n_ln_k(problem, k, tau):
    """Identity: the same model in another unit, so each point's density is 1/k as high."""
    data, order = problem
    one = exact_posterior(make_model(data, order, tau=tau))
    other = exact_posterior(
        make_model(scaled(data, k), order, tau=tau, bounds=scaled_bounds(k), pixel=k)
    )
    shift = -len(data) * np.log(k)
    assert other.log_evidence - one.log_evidence == pytest.approx(shift, abs=1e-6)
    size = make_model(data, order).size
    units = np.append(np.full(size, k), [k, 1.0])[: len(one.summary[0])]
    for a, b in zip(one.summary, other.summary, strict=True):
        assert (np.abs(b / units - a) / one.summary[1]).max() < 1e-6


@settings_for(30)
@given(axes(), factors, st.floats(0.5, 20))
def test_scaling_known_noise_and_stated_priors_does_the_same(problem, k, sigma):
    data, order = problem
    mean, sd = tuple(range(order + 1)), tuple(50.0 + j for j in range(order + 1))
    stated = StatedPrior(mean, sd)
    larger = StatedPrior(tuple(k * m for m in mean), tuple(k * s for s in sd))
    one = exact_posterior(make_model(data, order, sigma=sigma, prior="stated", stated=stated))
    other = exact_posterior(
        make_model(scaled(data, k), order, sigma=k * sigma, prior="stated", stated=larger)
    )
    shift = -len(data) * np.log(k)
    assert other.log_evidence - one.log_evidence == pytest.approx(
        shift, abs=1e-12 * abs(one.log_evidence) + 1e-8
    )


@settings_for(30)
@given(axes(), st.sampled_from([1e-3, 1.0, 50.0]), st.floats(-100, 100))
def test_another_unit_of_the_regressor_changes_no_evidence(problem, k, shift):
    """Identity: the domain moves with the points; rounding x costs shift / width in eps."""
    data, order = problem
    moved = replace(data, x=k * (data.x + shift))
    one, other = (exact_posterior(make_model(d, order)) for d in (data, moved))
    assert other.log_evidence == pytest.approx(one.log_evidence, abs=1e-6)


@settings_for(30)
@given(axes())
def test_equal_deviations_per_point_are_one_known_sigma(problem):
    """Identity: sd_i = s for all points, and sigma = s."""
    data, order = problem
    own = exact_posterior(make_model(replace(data, sd=np.full(len(data), 2.5)), order))
    common = exact_posterior(make_model(data, order, sigma=2.5))
    np.testing.assert_allclose(own.log_evidence, common.log_evidence, rtol=1e-10)
    assert (np.abs(own.summary[0] - common.summary[0]) / own.summary[1]).max() < 1e-7


@settings_for(30)
@given(axes(), st.integers(0, 1000))
def test_a_duplicated_data_set_halves_the_variance(problem, seed):
    """Identity: with sigma known, each point twice equals sigma / sqrt(2)."""
    data, order = problem
    twice = make_axis(np.tile(data.x, 2), np.tile(data.t, 2), data.size)
    doubled = exact_posterior(make_model(reordered(twice, seed), order, sigma=2.0))
    narrower = exact_posterior(make_model(data, order, sigma=2.0 / np.sqrt(2)))
    sd = narrower.summary[1]
    assert (np.abs(doubled.summary[0] - narrower.summary[0]) / sd).max() < 1e-7
    np.testing.assert_allclose(doubled.summary[1], sd, rtol=1e-7)


@settings_for(30)
@given(axes(), st.floats(-500, 500), st.floats(-500, 500))
def test_adding_a_line_moves_only_the_first_two_amplitudes(problem, offset, slope):
    """Identity of least squares: residuals and higher amplitudes stay."""
    data, order = problem
    s = (2 * data.x - data.x.min() - data.x.max()) / np.ptp(data.x)
    moved = replace(data, t=data.t + offset + slope * s)
    one, other = (solve(factorise(d, order), order) for d in (data, moved))
    shift = np.zeros(order + 1)
    shift[:2] = offset, slope
    np.testing.assert_allclose(other.amplitudes, one.amplitudes + shift, atol=1e-8)
    np.testing.assert_allclose(other.rss, one.rss, rtol=1e-6, atol=1e-16)


@settings_for(25)
@given(axes(max_order=4))
def test_the_highest_density_is_never_above_the_maximised_likelihood(problem):
    """Inequality: evidence is an average of the likelihood, so it stays below its maximum."""
    data, order = problem
    rss = factorise(data, order).rss(order)
    n = len(data)
    maximum = -n / 2 * (np.log(2 * np.pi * rss / n) + 1)
    assert exact_posterior(make_model(data, order)).log_evidence < maximum
