"""The pinhole for many draws at once, against the steps of chapter 3 and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.cameras.pinhole import POSE
from bayescal.points.camera import StatedCamera
from bayescal.points.setup import Setup
from bayescal.prior.camera import pinhole_prior, position_prior
from tests.helpers.cameras import pixels, problem, turned_points

FOCAL, CENTRE, TURN = (1500.0, 1600.0), (940.0, 500.0), (0.1, -0.2, 0.05)


def draws(geometry, size=6, seed=0):
    rng = np.random.default_rng(seed)
    theta = np.zeros((size, POSE + geometry.order))
    theta[:, :2] = np.log(FOCAL) + rng.normal(0, 0.05, (size, 2))
    theta[:, 2:4] = rng.normal(CENTRE, 30, (size, 2))
    theta[:, 4:7] = rng.normal(TURN, 0.05, (size, 3))
    theta[:, POSE:] = rng.normal(0, 40, (size, geometry.order))
    return geometry.to_anchor(theta, rng.normal([330, 57, -10], 5, (size, 3)))


@pytest.mark.parametrize("radial", ["even", "all"])
@pytest.mark.parametrize("order", [0, 1, 3])
def test_pixels_are_those_of_the_steps_of_chapter_three(order, radial):
    points = bc.thesis()
    geometry, _, _ = problem(points, order, radial)
    theta = draws(geometry)
    found, depth = geometry.project(theta)
    k, position = geometry.coefficients(theta), geometry.position(theta)
    for i, one in enumerate(theta):
        truth = pixels(points.world, np.exp(one[:2]), one[2:4], one[4:7], position[i], k[i], radial)
        np.testing.assert_allclose(found[i].T, truth, rtol=0, atol=1e-9)
    assert (depth > 0).all()


@pytest.mark.parametrize("coordinates", ["anchor", "fixed", "origin"])
@pytest.mark.parametrize("radial", ["even", "all"])
@pytest.mark.parametrize("order", [0, 2])
def test_jacobian_is_that_of_the_complex_step(order, radial, coordinates):
    """The imaginary part of f(x + ih) is h f'(x) (Squire & Trapp 1998, SIAM Rev. 40, 110)."""
    geometry, _, _ = problem(bc.thesis(), order, radial, fixed=coordinates == "fixed")
    if coordinates == "origin":
        geometry = replace(geometry, origin=np.array([330.0, 57.0, 0.0]))
    free = geometry.free(draws(geometry))[0]
    moved = free + 1e-30j * np.eye(len(free))
    truth = np.moveaxis(geometry.project(geometry.full(moved))[0].imag / 1e-30, 0, 2)
    np.testing.assert_allclose(geometry.jacobian(free), truth, rtol=1e-11, atol=1e-9)


def test_anchor_and_position_are_inverse_with_the_stated_volume():
    geometry, _, _ = problem(bc.thesis(), 1)
    theta = draws(geometry, 1)
    position = geometry.position(theta)
    np.testing.assert_allclose(geometry.to_anchor(theta, position), theta, rtol=1e-12)
    jacobian = np.empty((3, 3))
    for j in range(3):
        h = 1e-6
        moved = [theta.copy(), theta.copy()]
        moved[0][0, 7 + j] += h
        moved[1][0, 7 + j] -= h
        jacobian[:, j] = (geometry.position(moved[0]) - geometry.position(moved[1]))[0] / (2 * h)
    # Differences of positions of 1e2 over 1e-6: 1e-8 of each entry, over entries down to 0.1.
    expected = np.linalg.slogdet(jacobian)[1]
    assert geometry.log_volume(theta)[0] == pytest.approx(expected, abs=1e-5)


def test_a_position_held_itself_is_a_free_coordinate():
    geometry, _, _ = problem(bc.thesis(), 1)
    theta = draws(geometry)
    held = replace(geometry, origin=np.array([330.0, 57.0, 0.0]))
    free = held.free(theta)
    np.testing.assert_allclose(held.full(free), theta, rtol=1e-12)
    np.testing.assert_allclose(free[:, 7:10] + held.origin, geometry.position(theta), rtol=1e-12)
    assert (held.log_volume(theta) == 0).all()
    up, down = (held.project(held.full(free[:1] + s * 1e-4 * np.eye(11)))[0] for s in (1, -1))
    slopes = np.moveaxis(up - down, 0, 2) / 2e-4
    # Rounding of pixels of 1e3 over the step.
    np.testing.assert_allclose(held.jacobian(free[0]), slopes, rtol=1e-4, atol=1e-6)


def test_prior_density_is_the_product_of_its_factors():
    """In natural parameters by scipy.stats, times the volume of the anchor; tau by quadrature."""
    geometry, prior, _ = problem(bc.thesis(), 2)
    theta = draws(geometry)
    found = prior.log_density(geometry, theta)
    position = geometry.position(theta)
    for i, one in enumerate(theta):
        truth = stats.norm(np.log(1920), 1.0).logpdf(one[0])
        truth += stats.norm(0, 0.1).logpdf(one[1] - one[0])
        truth += stats.norm([960, 540], [192, 108]).logpdf(one[2:4]).sum()
        truth += stats.norm(0, np.radians(30)).logpdf(one[4:7]).sum()
        where = position_prior(bc.thesis())
        truth += stats.norm(where.mean, where.sd).logpdf(position[i]).sum()
        truth += geometry.log_volume(theta)[i]
        log_tau = np.linspace(np.log(0.01 / 1920), np.log(0.5), 40001)
        each = stats.norm(0, 1920 * np.exp(log_tau)[:, None]).pdf(one[POSE:]).prod(axis=1)
        truth += np.log(np.trapezoid(each, log_tau) / (log_tau[-1] - log_tau[0]))
        assert found[i] == pytest.approx(truth, abs=1e-6)


def test_draws_of_the_prior_have_its_moments():
    geometry, prior, _ = problem(turned_points(0.1), 1)
    n = 4000
    theta = prior.draw(np.random.default_rng(3), geometry, n)
    seen = np.isfinite(theta).all(axis=1)  # the centroid is in front of the camera
    assert seen.mean() > 0.98
    theta, n = theta[seen], int(seen.sum())
    natural = np.column_stack([theta[:, 0], theta[:, 2:4], theta[:, 4:7], geometry.position(theta)])
    mean = np.array([np.log(576), 288, 192, 0, 0, 0, 120, -900, -1800])
    sd = np.array([1, 57.6, 38.4, *[np.radians(30)] * 3, 50, 50, 50])
    assert np.abs((natural.mean(axis=0) - mean) / sd).max() < 4.5 / np.sqrt(n)
    assert np.abs(natural.std(axis=0) / sd - 1).max() < 4.5 / np.sqrt(2 * n)


def test_the_setup_changes_the_prior_and_the_prior_prints_itself():
    camera = StatedCamera(
        position_sd=(1.0, 2.0, 3.0),
        orientation=(0.0, 90.0, 0.0),
        orientation_sd=(5.0, 5.0, 5.0),
        focal=800.0,
        focal_log_sd=0.2,
        ratio_log_sd=0.01,
        centre=(900.0, 500.0),
        centre_sd=(9.0, 8.0),
    )
    points = bc.Correspondences.from_arrays(
        np.arange(30.0).reshape(10, 3), np.ones((10, 2)), setup=Setup(camera=camera)
    )
    prior = pinhole_prior(points)
    assert prior.focal == 800
    assert (prior.focal_log_sd, prior.ratio_log_sd) == (0.2, 0.01)
    np.testing.assert_allclose(prior.orientation @ [0, 0, 1], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(prior.rotation_sd, np.radians(5.0))
    assert prior.centre.tolist() == [900, 500]
    assert prior.position.sd.tolist() == [1, 2, 3]
    printed = str(prior)
    for words in ("ln 800, 0.2²", "N(900, 9²)", "(5, 5, 5) degrees", "as stated"):
        assert words in printed
