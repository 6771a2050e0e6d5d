"""Least squares of the pinhole: known cameras, another parametrisation, and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

import bayescal as bc
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.errors import InputError
from bayescal.noise.level import NoiseLevel
from bayescal.simulation import simulate
from tests.helpers.cameras import TURNED, pixels, problem, turned_points


def natural(geometry, free):
    theta = geometry.full(free[None])
    return np.concatenate(
        [
            np.exp(theta[0, :2]),
            theta[0, 2:4],
            geometry.position(theta)[0],
            geometry.coefficients(theta)[0],
        ]
    )


def test_an_exact_camera_comes_back():
    points = turned_points(0.0)
    levels = (NoiseLevel.known(0.1), NoiseLevel.known(0.1))
    geometry, prior, data = problem(points, 1, levels=levels)
    fit = fit_pinhole(points, geometry, prior, data)
    truth = [*TURNED["focal"], *TURNED["centre"], *TURNED["position"], *TURNED["k"]]
    np.testing.assert_allclose(natural(geometry, fit.free), truth, rtol=1e-7)
    assert fit.rss.max() < 1e-16


@pytest.mark.parametrize(("order", "radial"), [(0, "even"), (1, "even"), (1, "all")])
def test_the_thesis_optimum_is_that_of_plain_parameters(order, radial):
    """scipy in focal lengths, rotation, position and k themselves, with numerical slopes.

    Joint BIC 630.1 at order 0 with camera z about -17: what the design says of these data.
    """
    points = bc.thesis()
    geometry, prior, data = problem(points, order, radial)
    fit = fit_pinhole(points, geometry, prior, data)
    measured = data.pixels.T

    def misfit(p, sigma):
        found = pixels(points.world, p[:2], p[2:4], p[4:7], p[7:10], p[10:], radial)
        return ((measured - found) / sigma).ravel()

    p = np.array([1000.0, 1000, 960, 540, 0, 0, 0, 330, 57, 0, *[0.0] * order])
    sigma = np.ones(2)
    for _ in range(8):
        p = least_squares(misfit, p, x_scale="jac", args=(sigma,), xtol=1e-15, ftol=1e-15).x
        rss = (misfit(p, np.ones(2)).reshape(-1, 2) ** 2).sum(axis=0)
        sigma = np.sqrt(rss / 57)
    # ln L is flat at its maximum: numerical slopes give it to the square of their error.
    np.testing.assert_allclose(fit.log_likelihood, data.log_likelihood(rss), rtol=0, atol=1e-5)
    if order == 0:
        assert -2 * fit.log_likelihood + 12 * np.log(57) == pytest.approx(630.1, abs=0.05)
        assert geometry.position(geometry.full(fit.free[None]))[0, 2] == pytest.approx(-17, abs=0.1)


def test_a_lens_with_distortion_fits_no_worse_than_without():
    """Where r alone is curved one mode follows r at the cost of c: ln L 25 below order 0's."""
    points, _ = simulate({"r": 3, "c": 1}, 1.0, np.random.default_rng([0, 1]))
    plain, curved = (fit_pinhole(points, *problem(points, k)).log_likelihood for k in (0, 1))
    assert curved > plain


def test_estimates_scatter_as_their_covariance_says():
    """chi-squared of all parameters over data sets: mean 11, sd sqrt(22 / sets)."""
    levels = (NoiseLevel.known(0.06), NoiseLevel.known(0.06))
    sets = 30
    truth_points = turned_points(0.0)
    geometry, prior, data = problem(truth_points, 1, levels=levels)
    truth = fit_pinhole(truth_points, geometry, prior, data).free
    total = 0.0
    for seed in range(sets):
        points = turned_points(0.06, seed)
        geometry, prior, data = problem(points, 1, levels=levels)
        fit = fit_pinhole(points, geometry, prior, data)
        off = fit.free - truth
        total += off @ np.linalg.solve(fit.covariance, off)
    assert abs(total / sets - 11) < 4 * np.sqrt(22 / sets)


def refused(points, match, **options):
    geometry, prior, data = problem(points, 0, **options)
    with pytest.raises(InputError, match=match) as caught:
        fit_pinhole(points, geometry, prior, data)
    assert "\n" not in str(caught.value)


def test_what_no_pinhole_can_be_had_from_is_refused():
    points = turned_points(0.05)
    refused(replace(points, pixels=points.pixels * [1, -1]), "mirrored world")
    refused(replace(points, world=points.world * [1, 1, 0]), "in one plane")
    few = bc.Correspondences.from_arrays(
        points.world[::60], points.pixels[::60], setup=points.setup
    )
    refused(few, "it needs 6 points at least")


def test_points_behind_the_camera_are_refused():
    """Pixels of no pinhole in front: points on both sides of a camera at a fixed place."""
    thesis = bc.thesis()
    both = replace(thesis, setup=replace(thesis.setup, position=(330.0, 57.0, 600.0)))
    refused(both, "in front of it", fixed=True)


def test_coplanar_points_serve_where_the_position_is_held():
    points = turned_points(0.0)
    flat = points.world[:, 2] == 0
    position = TURNED["position"]
    setup = replace(points.setup, position=position)
    plane = bc.Correspondences.from_arrays(points.world[flat], points.pixels[flat], setup=setup)
    levels = (NoiseLevel.known(0.1), NoiseLevel.known(0.1))
    geometry, prior, data = problem(plane, 1, fixed=True, levels=levels)
    fit = fit_pinhole(plane, geometry, prior, data)
    assert fit.rss.max() < 1e-12


@pytest.mark.parametrize("seed", [22, 24])
@pytest.mark.parametrize("followed", ["r", "c"])
def test_whichever_axis_a_climb_follows_first_ends_no_higher(seed, followed):
    """scipy, the axes weighed in turn, from a fit that follows one axis at the other's cost."""
    rng = np.random.default_rng([0, seed])
    camera = {"r": [960.0, 1250.0, 40.0, -90.0], "c": [540.0, 1270.0]}
    points, _ = simulate({}, 1.0, rng, coefficients=camera)
    geometry, prior, data = problem(points, 1, fixed=True)
    fit = fit_pinhole(points, geometry, prior, data)

    def misfit(free, sigma):
        return ((data.pixels - geometry.project(geometry.full(free[None]))[0][0]).T / sigma).ravel()

    free, sigma = fit.free, np.array([0.1, 10.0] if followed == "r" else [10.0, 0.1])
    for _ in range(60):
        free = least_squares(misfit, free, x_scale="jac", args=(sigma,)).x
        rss = (misfit(free, np.ones(2)).reshape(-1, 2) ** 2).sum(axis=0)
        sigma = np.sqrt(rss / 57)
    assert fit.log_likelihood > data.log_likelihood(rss) - 1e-9
