"""A pinhole under noise that forgives bad points: its modes, its sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.comparison.families.models import FittedPinhole, robust_pinhole
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.laplace import linear_pixels
from bayescal.inference.optimum import find_modes
from bayescal.inference.sampled_posterior import sample_model
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from scripts.validation.robust_cameras import robust_model
from tests.helpers.cameras import TURNED, problem, turned_points


def fitted(points, order, **options):
    geometry, prior, data = problem(points, order, **options)
    return FittedPinhole(geometry, prior, data, fit_pinhole(points, geometry, prior, data))


def affine(made, probit):
    """Matrix and offset of the frame's coordinates as functions of the sampled ones, at a tau."""
    d = made.geometry.dimension
    theta = np.zeros((d + 1, made.dimension))
    theta[1:, :d], theta[:, -1] = np.eye(d), probit
    x, log_volume = made._moved(theta)
    return (x[1:] - x[0]).T, x[0], log_volume[0]


def two_cameras(apart):
    """Half of the points as one camera sees them, the same points as another with its r shifted."""
    one = turned_points(0.3)
    some = np.random.default_rng(1).permutation(len(one))[:30]
    world, pixels = one.world[some], one.pixels[some]
    shift = np.array([apart / 2, 0.0])
    both = np.concatenate([pixels + shift, pixels - shift])
    setup = replace(one.setup, position=TURNED["position"])
    return bc.Correspondences.from_arrays(np.concatenate([world, world]), both, setup=setup)


@pytest.mark.parametrize("points", [bc.thesis(), turned_points(0.1)], ids=["thesis", "turned"])
def test_pixels_linearised_at_the_frame_have_a_standard_normal_posterior(points):
    made = GaussianPinhole.of(*fitted(points, 1))
    pixels = linear_pixels(made.geometry, made.data, made.frame)
    slope, gram = pixels.normal(pixels.plain)
    assert slope == pytest.approx(np.zeros(11), abs=1e-4)
    assert gram == pytest.approx(np.eye(11), abs=1e-9)
    # The prior alone holds nothing back: its precision is positive semi-definite.
    assert np.linalg.eigvalsh(pixels.prior_precision).min() > -1e-9


def test_density_averaged_over_tau_is_that_with_tau_integrated_out():
    """At coordinates of the camera: scipy's t at every residual, the priors, and tau by sum."""
    noise = StudentT(4.0)
    known = (NoiseLevel.known(3.0), NoiseLevel.known(2.0))
    geometry, prior, data, fit = fitted(bc.thesis(), 2, levels=known)
    made = robust_pinhole(FittedPinhole(geometry, prior, data, fit), noise)
    rng = np.random.default_rng(0)
    probits = np.linspace(-7, 7, 1401)
    for _ in range(3):
        x = rng.standard_normal(geometry.dimension)
        coordinates = geometry.full((made.frame.mean + made.frame.root @ x)[None])
        pixels, _ = geometry.project(coordinates)
        z = (data.pixels - pixels[0]) / np.array([[3.0], [2.0]])
        truth = stats.t.logpdf(z, 4.0).sum() - data.n * np.log(6.0)
        truth += prior.log_density(geometry, coordinates)[0]
        theta, log_volume = np.empty((len(probits), made.dimension)), np.empty(len(probits))
        for i, probit in enumerate(probits):
            matrix, offset, log_volume[i] = affine(made, probit)
            theta[i] = [*np.linalg.solve(matrix, x - offset), probit]
        logs = made.log_prob(theta) - log_volume - made.log_volume
        found = np.log(np.exp(logs - truth).sum() * (probits[1] - probits[0]))
        assert abs(found) < 1e-6
        assert made.coordinates(made.complete(theta[:1], rng)) == pytest.approx(
            coordinates, rel=1e-9
        )


@pytest.mark.parametrize("probit", [-3.0, 0.0, 2.0])
def test_tau_moves_and_narrows_the_frame_as_its_prior_does(probit):
    """The frame is normal: with another tau's prior it is the product of the two, by inverses."""
    made = robust_pinhole(fitted(bc.thesis(), 2), StudentT())
    matrix, offset, log_volume = affine(made, probit)
    assert log_volume == pytest.approx(np.linalg.slogdet(matrix)[1], abs=1e-9)
    theta = np.zeros((1, made.dimension))
    theta[0, -1] = probit
    tau = float(made.report(made.complete(theta, np.random.default_rng(0)))[0, -1])
    rows = np.s_[-2:]
    mean, root = made.frame.mean[rows], made.frame.root[rows]
    change = (1 / tau**2 - 1 / 0.02**2) / made.prior.width**2
    precision = np.eye(len(matrix)) + change * root.T @ root
    covariance = np.linalg.inv(precision)
    assert matrix @ matrix.T == pytest.approx(covariance, rel=1e-6, abs=1e-9)
    assert offset == pytest.approx(-change * covariance @ root.T @ mean, rel=1e-6, abs=1e-9)


def test_student_t_noise_of_many_degrees_is_gaussian():
    """nu fixed at 1e8: the same density, per unit of the camera's coordinates."""
    levels = (NoiseLevel.known(3.0), NoiseLevel.known(3.5))
    parts = fitted(bc.thesis(), 0, levels=levels)
    plain, heavy = GaussianPinhole.of(*parts), robust_pinhole(parts, StudentT(1e8))
    x = np.random.default_rng(0).normal(0, 1, (5, plain.dimension))
    free = plain.frame.mean + x @ plain.frame.root.T
    other = np.linalg.solve(heavy.frame.root, (free - heavy.frame.mean).T).T
    np.testing.assert_allclose(
        heavy.log_prob(other) - heavy.log_volume, plain.log_prob(x) - plain.log_volume, atol=1e-4
    )


def test_two_cameras_that_half_of_the_points_follow_are_both_modes():
    made = robust_pinhole(fitted(two_cameras(16.0), 0, fixed=True), OutlierMixture())
    modes = find_modes(made.log_prob, made.starts())[:2]
    # The anchor is the pixel of the points' centroid; the cameras' differ by the shift.
    anchor = made.coordinates(np.array([mode.theta for mode in modes]))[:, 7]
    assert np.sort(anchor - made.data.pixels[0].mean()) == pytest.approx([-8, 8], abs=1)


def test_the_mixture_on_the_thesis_data_is_accepted_often():
    """Order 1 is the hardest: eight modes, of groups of readings at the edge."""
    found = sample_model(
        robust_model(bc.thesis(), 1, "outlier-mixture"), np.random.default_rng(1), 400
    )
    assert found.chain.acceptance > 0.45
    assert found.converged
    assert found.estimate.certain
    assert found.log_evidence_error < 0.05
