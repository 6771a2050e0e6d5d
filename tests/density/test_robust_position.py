"""Linear families under robust noise: the stated position, a free one, and their limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.comparison.families.models import free_model, moving_axes
from bayescal.comparison.orders.candidates import RobustOrder
from bayescal.comparison.settings import Settings
from bayescal.density.position_search import position_mode
from bayescal.density.robust_pair import RobustPair, paired
from bayescal.density.robust_position import RobustFreePosition, robust_position
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.sampled_posterior import Guess, sample_model
from bayescal.polynomials import bivariate, separable
from bayescal.prior.camera import PositionPrior, position_prior
from tests.helpers.family_axes import axes

GAUSSIAN = Settings(noise="student-t", nu=1e10, defend=False)  # in all but name
HEAVY = Settings(noise="student-t", defend=False)
MIXTURE = Settings(noise="outlier-mixture", defend=False)
TRUE = np.array([330.0, 57.0, -15.0])


def axis_model(axis, order, settings):
    return RobustOrder.of(axis, order, settings.choice.model(1.0)).model


def free_robust_model(points, pair, orders, settings, prior=None):
    r, c = (
        RobustOrder.of(axis, k, settings.choice.model(1.0)).model
        for axis, k in zip(pair, orders, strict=True)
    )
    moving = moving_axes(points, pair, orders)
    return RobustFreePosition.of((r, c), moving, prior or position_prior(points))


def with_errors(share, seed=1):
    """Points of a separable camera away from the stated place; some off by tens of pixels."""
    rng = np.random.default_rng(seed)
    points = bc.thesis()
    away = points.world - TRUE
    w, u = away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]
    pixels = np.column_stack([980 + 1100 * w - 60 * w**3, 490 + 1080 * u])
    pixels += rng.normal(0, 0.5, pixels.shape)
    bad = rng.choice(len(pixels), int(share * len(pixels)), replace=False)
    pixels[bad] += rng.choice([-1, 1], (len(bad), 2)) * rng.uniform(20, 80, (len(bad), 2))
    return bc.Correspondences.from_arrays(points.world, pixels, setup=points.setup)


@pytest.mark.parametrize("family", [separable, bivariate])
def test_density_is_the_plain_sum_over_the_points(family):
    model = free_robust_model(bc.thesis(), axes(family), (2, 1), HEAVY)
    rng = np.random.default_rng(0)
    theta = model.starts()[0] + rng.normal(0, 0.05, (5, model.dimension))
    expected = stats.norm.logpdf(model.position(theta), model.prior.mean, model.prior.sd)
    expected = (expected + np.log(model.prior.sd)).sum(axis=1)
    at = 3
    parts = zip(model.axes, model.moving, model.ridges, (1920, 1080), strict=True)
    for axis, moving, ridge, size in parts:
        p, own = axis.size, theta[:, at : at + axis.dimension]
        at += axis.dimension
        for i, place in enumerate(model.position(theta)):
            design = moving.design(place[None])[0]
            near = design.T @ (design * ridge.weights[:, None]) + np.diag(ridge.precision)
            pull = design.T @ (ridge.weights * (axis.t - design @ ridge.mean))
            b = ridge.mean + np.linalg.solve(near, pull) + own[i, :p]
            low, high = axis.level.log_bounds
            sigma = np.exp(low + (high - low) * stats.norm.cdf(own[i, p]))
            nu = np.exp(own[i, p + 1])
            expected[i] += stats.t.logpdf(axis.t - design @ b, nu, scale=sigma).sum()
            expected[i] += stats.norm.logpdf(own[i, p]) + np.log(axis.level.mass)
            expected[i] += stats.gamma.logpdf(nu, 2, scale=10) + np.log(nu)
            # tau, from a hundredth of a pixel to half the image, by a dense midpoint rule.
            low, high = np.log(0.01 / size), np.log(0.5)
            log_tau = low + (np.arange(4000) + 0.5) / 4000 * (high - low)
            sd = np.where(axis.prior.scaled, np.exp(log_tau)[:, None], 1.0) * axis.prior.sd
            prior = stats.norm.logpdf(b, axis.prior.mean, sd).sum(axis=1)
            expected[i] += np.log(np.mean(np.exp(prior - prior.max()))) + prior.max()
    np.testing.assert_allclose(model.log_prob(theta), expected, atol=1e-4)


def test_light_tails_at_a_free_position_give_the_evidence_of_gaussian_noise():
    """That of the path which eliminates everything but the position."""
    pair = axes(separable)
    plain, _ = free_model(bc.thesis(), pair, (2, 1))
    mode = position_mode(plain)
    guess = Guess(mixture_about((mode,), np.zeros(1)), (mode,))
    exact = sample_model(plain, np.random.default_rng(0), 200, guess, 4000)
    model = free_robust_model(bc.thesis(), pair, (2, 1), GAUSSIAN)
    found = sample_model(model, np.random.default_rng(0), 400)
    error = np.hypot(found.log_evidence_error, exact.log_evidence_error)
    assert found.log_evidence == pytest.approx(exact.log_evidence, abs=4 * error + 3e-3)
    for name in ("position_z", "alpha_1", "sigma_c", "tau_r"):
        ours, other = found[name], exact[name]
        apart = 4.5 * np.hypot(ours.mcse_mean, other.mcse_mean)
        assert ours.mean == pytest.approx(other.mean, abs=apart)


@pytest.mark.parametrize("settings", [HEAVY, MIXTURE], ids=lambda s: s.noise)
def test_a_position_known_exactly_leaves_the_two_axes(settings):
    points, pair = bc.thesis(), axes(separable)
    prior = PositionPrior(position_prior(points).mean, np.full(3, 1e-4), True)
    model = free_robust_model(points, pair, (1, 1), settings, prior)
    found = sample_model(model, np.random.default_rng(0), 400)
    r, c = (sample_model(axis, np.random.default_rng(i), 400) for i, axis in enumerate(model.axes))
    error = np.sqrt(sum(p.log_evidence_error**2 for p in (found, r, c)))
    truth = r.log_evidence + c.log_evidence
    assert found.log_evidence == pytest.approx(truth, abs=4 * error + 1e-3)


def test_a_pair_is_the_product_of_its_axes():
    pair = axes(separable)
    r, c = (
        sample_model(axis_model(axis, k, HEAVY), np.random.default_rng(k), 400)
        for axis, k in zip(pair, (3, 1), strict=True)
    )
    model = RobustPair((r.model, c.model))
    joint = paired(r, c, model)
    assert joint.log_evidence == r.log_evidence + c.log_evidence
    assert joint.log_evidence_error == np.hypot(r.log_evidence_error, c.log_evidence_error)
    theta = joint.chain.theta.reshape(-1, model.dimension)
    np.testing.assert_allclose(model.log_prob(theta), joint.chain.log_prob.ravel(), atol=1e-9)
    full = joint.full.reshape(-1, joint.full.shape[2])
    both = np.sum(model.log_likelihoods(full), axis=0)
    np.testing.assert_allclose(model.log_likelihood(full), both, rtol=1e-12)
    np.testing.assert_array_equal(model.report(full), joint.chain.draws.reshape(len(full), -1))
    for name in ("alpha_2", "sigma_r", "tau_r", "beta_1", "nu_c"):
        own, axis = (name, r if name[-1] == "r" or name[0] == "a" else c)
        plain = axis[own if own in axis.names else own[:-2]]
        assert joint[name].mean == pytest.approx(plain.mean, abs=5 * plain.mcse_mean)
    # Independent draws: correlations across the axes are those of chance.
    across = np.corrcoef(full.T)[: r.model.dimension, r.model.dimension : model.dimension]
    assert np.abs(across).max() < 5 / np.sqrt(min(p.ess_bulk for p in joint.parameters))


def test_gross_errors_move_the_gaussian_position_and_not_the_robust_one():
    points = with_errors(0.1)
    pair = tuple(
        replace(a, data=separable.axis_data(points, n))
        for a, n in zip(axes(separable), "rc", strict=True)
    )
    prior = position_prior(points)
    moving = moving_axes(points, pair, (3, 1))
    plain, _ = free_model(points, pair, (3, 1))
    robust, _ = robust_position(moving, prior)
    assert np.abs(plain.start - TRUE).max() > 10
    assert np.abs(robust - TRUE).max() < 3
    model = free_robust_model(points, pair, (3, 1), HEAVY)
    found = sample_model(model, np.random.default_rng(0), 400)
    for j, name in enumerate(("position_x", "position_y", "position_z")):
        assert abs(found[name].mean - TRUE[j]) < 3.5 * found[name].sd


def test_a_mixture_on_clean_points_is_near_gaussian_noise():
    """The fraction of bad points takes little: means within a fifth of an sd, sds within 10 %."""
    points = with_errors(0.0)
    pair = tuple(
        replace(a, data=separable.axis_data(points, n))
        for a, n in zip(axes(separable), "rc", strict=True)
    )
    ours, gaussian = (
        sample_model(free_robust_model(points, pair, (3, 1), s), np.random.default_rng(0), 1000)
        for s in (MIXTURE, GAUSSIAN)
    )
    for p in gaussian.parameters:
        if p.name[:3] not in ("sig", "tau"):
            assert ours[p.name].mean == pytest.approx(p.mean, abs=0.2 * p.sd)
            assert ours[p.name].sd == pytest.approx(p.sd, rel=0.1)
