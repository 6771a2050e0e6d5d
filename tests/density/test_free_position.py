"""Linear families at a free camera position: elimination, its slope, its evidence."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.optimize import minimize
from scipy.stats import multivariate_normal, norm

import bayescal as bc
from bayescal.comparison.families.models import free_model, joint_data, linear_axes, moving_axes
from bayescal.comparison.settings import Settings
from bayescal.density.position_search import best_position, climb, linearised, position_mode
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.proposals.tempering import effective_fraction
from bayescal.inference.sampled_posterior import Guess, sample_model
from bayescal.inference.weighting import weigh
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.least_squares import factorise
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import FINE
from bayescal.noise.level import NoiseLevel
from bayescal.points.setup import Setup
from bayescal.polynomials import bivariate, separable
from bayescal.prior.camera import PositionPrior, position_prior
from tests.helpers.family_axes import axes, axis_of


def exact_evidence(pair, orders):
    total = 0.0
    for axis, k in zip(pair, orders, strict=True):
        prior = axis.rule.of_degrees(axis.data.degrees(k))
        made = LinearModel(factorise(axis.data, k), k, axis.noise, prior)
        total += exact_posterior(made).log_evidence
    return total


@pytest.mark.parametrize("family", [separable, bivariate])
def test_slope_of_the_sum_of_squares_is_that_of_finite_differences(family):
    model, _ = free_model(bc.thesis(), axes(family), (2, 2))
    for axis in model.axes:
        place = np.array([331.0, 56.0, -5.0])
        e, slopes = linearised(axis, place)
        slope = 2 * e @ slopes
        h = 1e-4
        for j, unit in enumerate(np.eye(3)):
            up, down = ((linearised(axis, place + s * h * unit)[0] ** 2).sum() for s in (1, -1))
            # Sums of squares of 1e3 lose 1e-12 of themselves over a step of 1e-4.
            assert slope[j] == pytest.approx((up - down) / (2 * h), rel=1e-5, abs=1e-3)


def test_the_best_position_is_that_of_a_search_without_slopes():
    """Joint BIC 625.6 of orders 4 and 1: what the design says of these data."""
    points = bc.thesis()
    model, rss = free_model(points, axes(separable), (4, 1))
    likelihood = joint_data(axes(separable)).log_likelihood(rss)
    t = [points.pixel(a) for a in "rc"]

    def minus_log_likelihood(position):
        away = points.world - position
        w, u = away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]
        out = 0.0
        for x, y, k in ((w, t[0], 4), (u, t[1], 1)):
            fit = np.polynomial.Polynomial.fit(x, y, k)
            rss = ((y - fit(x)) ** 2).sum()
            out += 57 / 2 * (np.log(2 * np.pi * rss / 57) + 1)
        return out

    options = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 4000, "maxfev": 4000}
    found = minimize(minus_log_likelihood, [330, 57, 0], method="Nelder-Mead", options=options)
    assert likelihood == pytest.approx(-found.fun, abs=1e-6)
    np.testing.assert_allclose(model.start, found.x, atol=2e-3)
    assert -2 * likelihood + 12 * np.log(57) == pytest.approx(625.6, abs=0.05)


def test_a_start_that_ends_in_a_lower_maximum_is_not_the_last_word():
    """One of 600 searches over simulated cameras: from the stated position 16 nat are missed."""
    rng = np.random.default_rng(144)
    m, depth = int(rng.integers(15, 60)), rng.choice([0.05, 0.2, 0.5])
    sides = [rng.uniform(-250, 250, m), rng.uniform(-120, 120, m)]
    world = np.column_stack([*sides, 500 * (1 + rng.uniform(-depth, depth, m))])
    away = world - 50 * rng.normal(0, 1, 3)
    x, bend = away[:, :2] / away[:, 2:], rng.normal(0, 100, 2)
    pixels = np.array([960, 540]) + 1100 * x + bend * x**3
    pixels += rng.normal(0, rng.choice([0.1, 1, 5]), (m, 2))
    setup = Setup(position=(0.0, 0.0, 0.0), width=19200.0, height=10800.0)
    points = bc.Correspondences.from_arrays(world, pixels, setup=setup)
    pair = linear_axes(points, "bivariate", Settings(defend=False), 3)
    moving, prior = moving_axes(points, pair, (2, 2)), position_prior(points)
    lower, height = climb(moving, prior, prior.mean)
    best = best_position(moving, prior)
    assert climb(moving, prior, best)[1] > height + 10
    assert np.abs((best - lower) / prior.sd).max() > 0.1


def test_pixels_without_noise_find_the_camera_and_the_orders_they_came_from():
    """Their likelihood has no top where sigma has no bound: the climb must keep to its prior."""
    points, place = bc.thesis(), np.array([330.0, 57.0, -20.0])
    away = points.world - place
    w, u = away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]
    exact = np.column_stack([900 + 1500 * w - 40 * w**3, 500 + 1400 * u])
    clean = replace(points, pixels=exact)
    pair = linear_axes(clean, "separable", Settings(defend=False), 3)
    found = {k: free_model(clean, pair, k)[0] for k in ((3, 1), (3, 2), (2, 1))}
    for orders in ((3, 1), (3, 2)):
        np.testing.assert_allclose(found[orders].start, place, atol=1e-4)
    masses = {k: position_mode(model).log_mass for k, model in found.items()}
    assert max(masses, key=masses.get) == (3, 1)
    mode = position_mode(found[3, 1])
    proposal = mixture_about((mode,), np.zeros(1))
    draws = weigh(found[3, 1], proposal, np.random.default_rng(0), 600)
    assert effective_fraction(draws.log_weights) > 0.8


@pytest.mark.parametrize("family", [separable, bivariate])
def test_evidence_at_other_positions_is_that_of_the_fine_quadrature(family):
    """Steps of sigma placed at one position serve the others: 5 mnat where it matters."""
    model, _ = free_model(bc.thesis(), axes(family), (3, 1))
    rng = np.random.default_rng(0)
    places = model.start + 0.05 * model.prior.sd * rng.normal(0, 1, (20, 3))
    for axis in model.axes:
        exact = log_evidences(axis.reduced(places), axis.noise, axis.prior, FINE)
        ours = axis.log_evidence(places, axis.offsets(model.start))
        near = exact > exact.max() - 12
        np.testing.assert_allclose(ours[near], exact[near], atol=0.01)


@pytest.mark.parametrize("family", [separable, bivariate])
def test_density_at_the_stated_position_is_the_closed_form(family):
    pair = axes(family)
    model, _ = free_model(bc.thesis(), pair, (2, 1))
    theta = (model.prior.mean - model.start) / model.prior.sd
    prior = model.prior.log_density(model.prior.mean[None])[0] + np.log(model.prior.sd).sum()
    expected = exact_evidence(pair, (2, 1)) + prior
    assert model.log_prob(theta[None])[0] == pytest.approx(expected, abs=0.01)


def test_a_position_known_exactly_leaves_the_closed_form():
    """A prior of 1e-4 world units: the general path must give the exact evidence."""
    pair = axes(separable)
    free, _ = free_model(bc.thesis(), pair, (1, 1))
    prior = PositionPrior(free.prior.mean, np.full(3, 1e-4), True)
    model = replace(free, prior=prior, start=free.prior.mean)
    mode = position_mode(model)
    guess = Guess(mixture_about((mode,), np.zeros(1)), (mode,))
    found = sample_model(model, np.random.default_rng(0), 400, guess, 2000)
    truth = exact_evidence(pair, (1, 1))
    assert found.log_evidence == pytest.approx(truth, abs=4 * found.log_evidence_error + 1e-3)


def test_what_was_integrated_out_is_drawn_from_its_exact_posterior():
    pair = axes(separable)
    free, _ = free_model(bc.thesis(), pair, (2, 1))
    n = 1500
    theta = np.tile((free.prior.mean - free.start) / free.prior.sd, (n, 1))
    drawn = free.report(free.complete(theta, np.random.default_rng(0)))
    made = LinearModel(
        factorise(pair[0].data, 2), 2, pair[0].noise, pair[0].rule.of_order(2), "alpha"
    )
    exact = exact_posterior(made)
    means, sds = exact.summary
    for j in range(5):  # three coefficients, sigma and tau
        assert abs(drawn[:, j].mean() - means[j]) < 4.5 * sds[j] / np.sqrt(n)
        error = np.sqrt((exact.kurtosis[j] - 1) / 4 / n)
        assert drawn[:, j].std() == pytest.approx(sds[j], rel=4.5 * error)


def test_likelihood_of_the_draws_is_that_of_their_polynomials():
    model, _ = free_model(bc.thesis(), axes(separable), (3, 1))
    rng = np.random.default_rng(0)
    full = model.complete(rng.normal(0, 0.01, (4, 3)), rng)
    report = dict(zip(model.names, model.report(full).T, strict=True))
    points, total = bc.thesis(), 0.0
    for symbol, axis, column, k in (("alpha", "r", 0, 3), ("beta", "c", 1, 1)):
        position = np.column_stack([report[f"position_{x}"] for x in "xyz"])
        away = points.world[None] - position[:, None]
        x = away[:, :, column] / away[:, :, 2]
        prediction = sum(report[f"{symbol}_{j}"][:, None] * x**j for j in range(k + 1))
        sigma = report[f"sigma_{axis}"][:, None]
        z = (points.pixel(axis) - prediction) / sigma
        total = total - z**2 / 2 - np.log(sigma) - np.log(2 * np.pi) / 2
    np.testing.assert_allclose(model.log_likelihood(full), total, rtol=1e-8)


def known_sds():
    """The thesis data with a deviation for each pixel, from 1 to 3 px."""
    sd = np.random.default_rng(3).uniform(1, 3, (2, 57))
    return replace(bc.thesis(), sigma={"r": sd[0], "c": sd[1]})


@pytest.mark.parametrize("points", [bc.thesis(), known_sds()], ids=["one sigma", "known"])
def test_density_of_a_point_given_the_others_is_that_of_their_joint_normal(points):
    """With the coefficients integrated out all pixels are jointly normal given the draw."""
    made = [separable.axis_data(points, a) for a in "rc"]
    levels = [NoiseLevel.inferred() if d.sd is None else NoiseLevel.known(1.0) for d in made]
    pair = tuple(axis_of(d, v) for d, v in zip(made, levels, strict=True))
    model, _ = free_model(points, pair, (4, 1))
    rng = np.random.default_rng(0)
    full = model.complete(rng.normal(0, 0.01, (3, 3)), rng)
    found = model.log_left_out(full)
    at = [3, 3 + 5 + 2]
    for row, position in enumerate(model.position(full)):
        expected = np.zeros(57)
        for axis, first in zip(model.axes, at, strict=True):
            log_sigma, log_tau = full[row, first + axis.size : first + axis.size + 2]
            design = axis.design(position[None])[0]
            sd = np.ones(57) if axis.data.sd is None else axis.data.sd
            spread = axis.prior.deviations(np.array([log_tau]))[0]
            total = (design * spread**2) @ design.T + np.diag((np.exp(log_sigma) * sd) ** 2)
            precision = np.linalg.inv(total)
            # Of a joint normal: variance 1 / P_ii, residual (P e)_i / P_ii.
            variance = 1 / np.diag(precision)
            e = precision @ (axis.data.t - design @ axis.prior.mean) * variance
            expected += norm.logpdf(e, scale=np.sqrt(variance))
        # The covariance's entries of 1e6 px^2 leave the inverse some nine digits.
        np.testing.assert_allclose(found[row], expected, rtol=0, atol=1e-5)


@pytest.mark.parametrize("family", [separable, bivariate])
def test_without_a_point_the_basis_and_the_priors_stay(family):
    """The evidence at a position is that of the closed form of the other points."""
    points = bc.thesis()
    whole, _ = free_model(points, axes(family), (2, 1))
    edge = int(np.argmax(whole.axes[0].data.x))  # it spans the domain
    rest = whole.without(edge)
    place = np.array([[331.0, 56.0, -5.0]])
    assert len(rest.axes[0].world) == 56
    for axis, other in zip(whole.axes, rest.axes, strict=True):
        np.testing.assert_array_equal(
            other.design(place)[0], np.delete(axis.design(place)[0], edge, axis=0)
        )
        exact = log_evidences(other.reduced(place), axis.noise, axis.prior, FINE)
        assert other.log_evidence(place, other.offsets(place[0])) == pytest.approx(exact, abs=5e-3)


def test_as_many_coefficients_as_points_lose_a_point():
    """Under a proper prior fewer points than coefficients still have an evidence."""
    points = bc.thesis()
    few = replace(
        points, world=points.world[::12], pixels=points.pixels[::12], labels=points.labels[::12],
        lines=None,
    )  # fmt: skip
    made = [separable.axis_data(few, a) for a in "rc"]
    pair = tuple(axis_of(d, NoiseLevel.known(2.0)) for d in made)
    (axis, _), place = moving_axes(few, pair, (4, 4)), np.array([[330.0, 57.0, 0.0]])
    assert (len(few), axis.size) == (5, 5)
    rest = axis.without(2)
    found = rest.log_evidence(place, np.zeros(1))[0]
    design, prior = rest.design(place)[0], axis.prior
    log_tau = np.linspace(*prior.log_tau_bounds, 2001)
    values = [
        multivariate_normal(design @ prior.mean, (design * s**2) @ design.T + 4 * np.eye(4)).logpdf(
            rest.data.t
        )
        for s in prior.deviations(log_tau)
    ]
    density = np.exp(values) * np.exp(prior.log_tau_density())
    assert found == pytest.approx(np.log(simpson(density, x=log_tau)), abs=5e-3)
