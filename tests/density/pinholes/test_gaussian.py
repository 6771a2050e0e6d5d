"""The pinhole's posterior: its density in full, its evidence, its sampling."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

import bayescal as bc
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.proposal import ladder, weighted_evidence
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.sampled_posterior import Guess, sample_model
from bayescal.noise.level import NoiseLevel
from scripts.validation.families import model_of, simulated
from tests.helpers.cameras import TURNED, problem, turned_points


def model(points, order, **options) -> GaussianPinhole:
    geometry, prior, data = problem(points, order, **options)
    return GaussianPinhole.of(geometry, prior, data, fit_pinhole(points, geometry, prior, data))


def sampled(made, seed=0, ess=1000):
    modes, log_mass = ladder(made)
    guess = Guess(mixture_about(modes, log_mass), modes[:1])
    return sample_model(made, np.random.default_rng(seed), ess, guess)


def test_density_is_the_likelihood_averaged_over_both_sigmas():
    """Trapezium over ln sigma of scipy's normal densities, each axis on its own."""
    made = model(bc.thesis(), 2)
    theta = np.random.default_rng(0).normal(0, 1, (3, made.dimension))
    found = made.log_prob(theta)
    grid = np.linspace(np.log(0.01), np.log(1000), 4001)
    full = made.coordinates(theta)
    pixels, _ = made.geometry.project(full)
    for i in range(3):
        truth = made.prior.log_density(made.geometry, full[i : i + 1])[0]
        truth += np.linalg.slogdet(made.frame.root)[1]
        for axis in range(2):
            residual = made.data.pixels[axis] - pixels[i, axis]
            each = stats.norm(0, np.exp(grid)[:, None]).logpdf(residual).sum(axis=1)
            truth += logsumexp(each) + np.log((grid[1] - grid[0]) / (grid[-1] - grid[0]))
        assert found[i] == pytest.approx(truth, abs=1e-6)


def test_a_known_sigma_and_a_fixed_tau_leave_nothing_to_average():
    levels = (NoiseLevel.known(3.0), NoiseLevel.known(3.5))
    made = model(bc.thesis(), 1, levels=levels, tau=0.05)
    theta = np.random.default_rng(0).normal(0, 1, (4, made.dimension))
    full = made.complete(theta, np.random.default_rng(1))
    assert full.shape == theta.shape
    assert made.names[-1] == "k_1"
    parts = made.log_likelihood(full).sum(axis=1)
    prior = made.prior.log_density(made.geometry, made.coordinates(theta))
    expected = parts + prior + np.linalg.slogdet(made.frame.root)[1]
    np.testing.assert_allclose(made.log_prob(theta), expected, rtol=1e-12)


def test_many_points_are_taken_in_parts(monkeypatch):
    """Which change nothing: of a fixed tau and known sigmas nothing is drawn either."""
    made = model(bc.thesis(), 1, levels=(NoiseLevel.known(3.0), NoiseLevel.known(3.5)), tau=0.05)
    theta = np.random.default_rng(0).normal(0, 1, (10, made.dimension))
    rng = np.random.default_rng(1)
    whole = made.log_likelihood(theta), made.complete(theta, rng), made.log_prob(theta)
    monkeypatch.setattr("bayescal.density.pinholes.pinhole.CHUNK", 3 * 2 * 57)
    assert [len(part) for part in made.in_parts(theta)] == [3, 3, 3, 1]
    parts = made.log_likelihood(theta), made.complete(theta, rng), made.log_prob(theta)
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)


def test_points_behind_the_camera_have_no_density():
    made = model(bc.thesis(), 0)
    theta = np.zeros((1, made.dimension))
    free = made.frame.mean.copy()
    free[9] = 3.0  # ln(f / depth): the centroid right before the camera
    theta[0] = np.linalg.solve(made.frame.root, free - made.frame.mean)
    assert made.log_prob(theta)[0] == -np.inf


@pytest.mark.parametrize("order", [0, 1, 2])
def test_sampling_and_evidence_of_the_thesis_data(order):
    """The efficiency promised; importance and bridge sampling share no error."""
    found = sampled(model(bc.thesis(), order))
    draws = found.chain.draws.shape[0] * found.chain.draws.shape[1]
    assert found.converged
    assert found.chain.acceptance > 0.70
    assert min(d.ess_bulk for d in found.chain.diagnostics) > 0.45 * draws
    assert max(d.rhat for d in found.chain.diagnostics) < 1.005
    estimate = found.estimate
    assert not estimate.warnings
    assert estimate.error < 0.005
    spread = np.hypot(estimate.error, estimate.bridge_error)
    assert abs(estimate.bridge - estimate.log_evidence) < 4 * spread


def test_evidence_is_the_same_over_seeds():
    made = model(bc.thesis(), 1)
    modes, log_mass = ladder(made)
    proposal = mixture_about(modes, log_mass)
    found = []
    for seed in range(10):
        theta = proposal.draw(np.random.default_rng(seed), 10_000)
        log_w = made.log_prob(theta) - proposal.log_density(theta)
        found.append(logsumexp(log_w) - np.log(len(log_w)))
    assert np.std(found, ddof=1) < 0.01


def test_a_long_lens_turned_by_thirty_degrees():
    """300 points at 0.06 px: one coefficient is preferred, the truth is inside."""
    points = turned_points(0.06)
    evidences = [logsumexp(ladder(model(points, k))[1]) for k in range(3)]
    assert int(np.argmax(evidences)) == 1
    assert evidences[1] - evidences[0] > 100
    found = sampled(model(points, 1))
    assert found.chain.acceptance > 0.70
    truth = {"focal_r": 3043, "centre_r": 300, "position_z": -1768, "k_1": 3.0, "sigma_r": 0.06}
    for name, value in truth.items():
        assert abs(found[name].mean - value) < 4 * found[name].sd


def test_pixels_without_noise_put_sigma_at_its_lower_bound():
    """Then p(sigma | data) falls as sigma^-(n - a + 1), a the parameters the axis determines.

    Its mean is lower * (n - a) / (n - a - 1), with a from 0 to all ten. A proposal as
    narrow as the residuals, 1e-12 px, would miss a posterior that is 0.01 px wide.
    """
    truth = {**TURNED, "k": ()}
    made = model(turned_points(0.0, truth=truth), 0)
    found = sampled(made, ess=400)
    assert found.converged
    assert found.estimate.certain
    assert found.estimate.effective_fraction > 0.5
    n, lower = made.data.n, 0.01
    for axis in "rc":
        sigma = found[f"sigma_{axis}"]
        ends = [lower * (n - a) / (n - a - 1) for a in (0, made.dimension)]
        assert ends[0] - 4 * sigma.mcse_mean < sigma.mean < ends[1] + 4 * sigma.mcse_mean
    for name, value in zip("xyz", truth["position"], strict=True):
        place = found[f"position_{name}"]
        assert place.mean == pytest.approx(value, abs=4 * place.sd)


def test_pixels_that_a_pinhole_fits_best_with_no_focal_length_are_judged():
    """A lens that folds its image: without distortion a constant explains r or c best."""
    points, _, _ = simulated(1, 1085)
    folded, right = model_of(points, 0), model_of(points, 1)
    assert folded.fit.free[:2].min() < np.log(1e-6), "the likelihood's focal length of r or c"
    mode = folded.coordinates(ladder(folded)[0][0].theta[None])[0]
    assert (np.exp(mode[:2]) > 1).all(), "px: the prior holds it, far from the likelihood's"
    values = [
        weighted_evidence(made, np.random.default_rng(0), 2000).log_evidence
        for made in (folded, right)
    ]
    assert np.isfinite(values[0])
    assert values[1] > values[0] + 1000
