"""Predictions against closed forms, the sampler's own draws, OpenCV and the classical interval."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.prediction.calibrated.hull import hull_of, within
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.members import Parameters
from bayescal.prediction.calibrated.noise import GRID, NewNoise, mixture_quantiles
from bayescal.prediction.predict import _by_steps, _over_draws, averaged, moments
from tests.helpers.cameras import turned_points
from tests.helpers.cases import camera_points

POINTS = np.array([[300.0, 60.0, 250.0], [310.0, 80.0, 300.0], [200.0, 20.0, 400.0]])


@pytest.fixture(scope="module")
def pinhole() -> bc.CalibratedCamera:
    """A turned pinhole of one radial coefficient."""
    return bc.camera(bc.fit_family(turned_points(0.3), "pinhole", (1,), ess=400))


def ratios(points: Array) -> Array:
    """x/z and y/z from the thesis's camera."""
    away = points - np.array(bc.thesis().setup.position)
    return away[:, :2] / away[:, 2:]


def test_one_model_is_the_closed_form(thesis_comparison):
    """Truth: mean and covariance of the monomial coefficients, put into powers of x/z."""
    found = bc.predict(thesis_comparison, POINTS, average=False)
    for axis, (name, order) in enumerate(thesis_comparison.orders.items()):
        exact = thesis_comparison.axes[name][order].exact
        to_monomials = exact.model.factors.monomials.lead(order)
        powers = ratios(POINTS)[:, axis, None] ** np.arange(order + 1)
        mean = powers @ to_monomials @ exact.mean
        covariance = to_monomials @ exact.covariance @ to_monomials.T
        sd = np.sqrt(np.einsum("np,pq,nq->n", powers, covariance, powers))
        recorded = mean if name == "r" else bc.thesis().setup.height - mean
        np.testing.assert_allclose(found.mean[:, axis], recorded, rtol=0, atol=1e-6)
        np.testing.assert_allclose(found.sd[:, axis], sd, rtol=1e-4)
    assert (found.between == 0).all()


def test_one_model_agrees_with_the_samplers_draws(thesis_comparison):
    """Truth: emcee's chain of r's chosen order, each draw's polynomial; 5 standard errors."""
    chosen = thesis_comparison.axes["r"].chosen
    draws = chosen.posterior.chain.draws.reshape(-1, chosen.posterior.chain.draws.shape[2])
    powers = ratios(POINTS)[:, 0, None] ** np.arange(chosen.order + 1)
    pixels = draws[:, : chosen.order + 1] @ powers.T
    found = bc.predict(thesis_comparison, POINTS, average=False)
    n = 0.9 * len(pixels)
    assert (np.abs(found.mean[:, 0] - pixels.mean(axis=0)) < 5 * found.sd[:, 0] / n**0.5).all()
    assert (np.abs(found.sd[:, 0] / pixels.std(axis=0) - 1) < 5 * (1 / n) ** 0.5).all()


def test_an_average_has_the_variance_of_the_pooled_models(thesis_comparison):
    """Truth: the law of total variance, by pooling weighted draws of all members."""
    camera = bc.camera(thesis_comparison, average=True)
    rng = np.random.default_rng(1)
    counts = rng.multinomial(200_000, camera.probabilities)
    pooled = np.concatenate(
        [
            moments(m, POINTS).mean
            + moments(m, POINTS).sd * rng.standard_normal((k, len(POINTS), 2))
            for m, k in zip(camera.members, counts, strict=True)
        ]
    )
    found = bc.predict(camera, POINTS)
    np.testing.assert_allclose(found.sd, pooled.std(axis=0), rtol=5 / 200_000**0.5)
    assert (found.between[:, 1] > 0.01).all()
    alone = bc.predict(camera, POINTS, average=False)
    assert (found.sd[:, 1] > alone.sd[:, 1]).all()


def test_under_a_flat_prior_the_interval_is_the_classical_one():
    """Truth: mean +- t(n - p) s sqrt(1 + h), Student's prediction interval (Draper & Smith)."""
    n, order = 25, 2
    points = camera_points(n, (960.0, 700.0, 30.0), noise=1.5)
    result = bc.fit(points, order, 1, prior="flat", ess=8000)
    new = np.array([[10.0, 5.0, 120.0], [-30.0, -20.0, 100.0]])
    found = bc.predict(result, new)
    x, t = points.world[:, 0] / points.world[:, 2], points.pixels[:, 0]
    design, rows = np.vander(x, order + 1), np.vander(new[:, 0] / new[:, 2], order + 1)
    b, rss, *_ = np.linalg.lstsq(design, t, rcond=None)
    dof = n - order - 1
    gram = np.linalg.inv(design.T @ design)
    half = stats.t.ppf(0.975, dof) * np.sqrt(
        rss[0] / dof * (1 + np.einsum("np,pq,nq->n", rows, gram, rows))
    )
    np.testing.assert_allclose(found.mean[:, 0], rows @ b, atol=1e-6)
    # ln sigma has sd 1 / sqrt(2 dof); 1000 draws of it.
    error = 5 / np.sqrt(2 * dof * 1000)
    np.testing.assert_allclose((found.upper - found.lower)[:, 0] / 2, half, rtol=error)


def test_a_pinhole_projects_as_opencv(pinhole):
    """Truth: cv2.projectPoints with the same parameters, 1e-9 px."""
    (member,) = pinhole.members
    assert isinstance(member, LensMember)
    theta = member.parameters.draws[:5]
    intrinsics, k = member.intrinsics(theta)
    rotation, translation = member.pose(theta)
    world = turned_points(0.0).world
    pixels, seen = member.project(theta, world)
    assert seen.all()
    for i in range(5):
        fx, fy, cx, cy = intrinsics[i]
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        expected, _ = cv2.projectPoints(
            world, cv2.Rodrigues(rotation[i])[0], translation[i], matrix, np.array([*k[i], 0, 0, 0])
        )
        np.testing.assert_allclose(pixels[i], expected[:, 0], rtol=0, atol=1e-9)


def test_steps_and_draws_agree_on_a_pinhole(pinhole):
    """Two ways of propagation: sds within Monte Carlo error, means too."""
    (member,) = pinhole.members
    world = turned_points(0.0).world[::20]
    steps, draws = _by_steps(member, world), _over_draws(member, world)
    n = len(member.parameters.draws)
    np.testing.assert_allclose(steps.sd, draws.sd, rtol=0.01 + 5 / np.sqrt(2 * n))
    assert (np.abs(steps.mean - draws.mean) < 5 * draws.sd / np.sqrt(n)).all()


def test_steps_are_exact_where_the_mapping_is_linear(thesis_comparison):
    """Truth: mean and covariance of the coefficients; negative control: a wrong root."""
    member = bc.camera(thesis_comparison).chosen
    exact, steps = moments(member, POINTS), _by_steps(member, POINTS)
    np.testing.assert_allclose(steps.sd, exact.sd, rtol=1e-9)
    np.testing.assert_allclose(steps.mean, exact.mean, rtol=1e-12)


def test_a_reopened_family_predicts_what_it_fitted(pinhole):
    """Noise 0.3 px on 300 points: means within 5 sds of the truth, sds far below the noise."""
    truth = turned_points(0.0)
    found = bc.predict(pinhole, truth.world)
    assert (np.abs(found.mean - truth.pixels) < 5 * found.sd + 1e-9).all()
    assert found.sd.max() < 0.15
    assert np.abs(found.new_sd - 0.3).max() < 0.05
    assert not found.extrapolated.any()


def test_points_that_cannot_be_seen_have_no_numbers(thesis_comparison, pinhole):
    behind = np.array([[330.0, 57.0, -200.0]])
    found = bc.predict(thesis_comparison, behind)
    assert not found.seen[0]
    assert np.isnan(found.mean).all()
    (member,) = pinhole.members
    rotation, translation = member.pose(member.parameters.mean[None])
    centre = -rotation[0].T @ translation[0]
    ahead = rotation[0].T @ np.array([0.0, 0.0, 500.0])
    found = bc.predict(pinhole, np.stack([centre + ahead, centre - ahead]))
    assert found.seen.tolist() == [True, False]


def test_extrapolation_is_flagged_where_the_domain_ends(thesis_comparison):
    """Truth: x/z and y/z of the thesis's points."""
    x, y = ratios(bc.thesis().world).T
    position = np.array(bc.thesis().setup.position)

    def at(w: float, u: float) -> Array:
        return position + 300.0 * np.array([w, u, 1.0])

    inside = at(x.max() - 1e-6, y.min() + 1e-6)
    found = bc.predict(thesis_comparison, [inside, at(x.max() + 1e-3, 0.0), at(0, y.min() - 1e-3)])
    assert found.extrapolated.tolist() == [False, True, True]


def test_the_quantile_of_a_mixture():
    """Truth: the mixture's distribution at what is found is the probability asked for."""
    rng = np.random.default_rng(3)
    shapes = np.stack([stats.norm.cdf(GRID), stats.t.cdf(GRID, 4)])
    centres, scales = rng.normal(0, 5, (2, 50)), rng.uniform(0.5, 3, (2, 50))
    weights = np.array([0.3, 0.7])
    for p in (0.025, 0.5, 0.975):
        at = mixture_quantiles(shapes, centres, scales, weights, p)
        z = (at - centres) / scales
        below = 0.3 * stats.norm.cdf(z[0]) + 0.7 * stats.t.cdf(z[1], 4)
        np.testing.assert_allclose(below, p, atol=1e-4)  # the grid's steps


def test_noise_of_an_inferred_sigma_is_students_t():
    """Truth: sigma^2 ~ scaled inverse chi-squared makes t; tails lie above a normal's."""
    dof, n = 6, 20_000
    sigma = np.sqrt(dof / np.random.default_rng(2).chisquare(dof, (n, 2)))
    noise = NewNoise(np.log(sigma), np.empty((n, 2, 0)))
    expected = stats.t.cdf(GRID * noise.scale[0], dof)
    assert np.abs(noise.distribution[0] - expected).max() < 5 * 0.5 / n**0.5
    far = GRID == -4.0
    assert noise.distribution[0][far] > 2 * stats.norm.cdf(-4.0)


def test_robust_noise_widens_the_interval_not_the_scale():
    """Truth: scipy's t of 3 degrees of freedom."""
    n = 1000
    noise = NewNoise(np.zeros((n, 2)), np.empty((n, 2, 0)), "student-t", 3.0)
    inside = stats.t.ppf((1 + 0.6826894921370859) / 2, 3)
    np.testing.assert_allclose(noise.scale, inside, rtol=0.02)
    at = np.interp(0.975, noise.distribution[0], GRID) * noise.scale[0]
    assert at == pytest.approx(stats.t.ppf(0.975, 3), rel=0.03)


def test_averaging_of_one_model_changes_nothing(thesis_comparison):
    one = moments(bc.camera(thesis_comparison).chosen, POINTS)
    mean, within, between = averaged([one, one], (0.4, 0.6))
    np.testing.assert_allclose(mean, one.mean)
    np.testing.assert_allclose(within, one.sd**2)
    assert np.abs(between).max() < 1e-20


def test_the_root_of_draws_has_their_covariance():
    draws = np.random.default_rng(0).normal(size=(500, 3)) @ np.array(
        [[1, 0, 0], [2, 1, 0], [0, 1, 3]]
    )
    kept = Parameters.of_draws(draws)
    np.testing.assert_allclose(kept.root @ kept.root.T, np.cov(draws, rowvar=False))


def test_the_hull_holds_its_points_and_no_others():
    points = np.random.default_rng(4).uniform(0, 1, (200, 2))
    hull = hull_of(points)
    assert within(hull, points).all()
    assert not within(hull, np.array([[1.2, 0.5], [-0.1, -0.1]])).any()
    assert not within(hull_of(points[:2]), points).any()


def test_what_is_no_point_is_refused(thesis_comparison):
    with pytest.raises(InputError, match=r"world must have shape \(n, 3\)"):
        bc.predict(thesis_comparison, [[1.0, 2.0]])
    with pytest.raises(InputError, match="row 2: holds a number that is not finite"):
        bc.predict(thesis_comparison, [[1, 2, 3], [np.nan, 1, 1]])
    with pytest.raises(InputError, match="is none of the plausible models"):
        bc.camera(thesis_comparison, model="separable (9, 9)")
    with pytest.raises(InputError, match="of one axis alone"):
        bc.camera(bc.compare(bc.thesis(), [1], axis="r", ess=100))


@pytest.mark.parametrize(
    ("noise", "position"), [("student-t", "free"), ("outlier-mixture", "stated")]
)
def test_every_robust_family_makes_a_camera(noise, position):
    """Truth: the straight camera the points come from; the 95 % interval holds most of them."""
    points = camera_points(40, noise=1.0, seed=2)
    result = bc.compare_families(
        points, ["separable"], [1], position=[position], noise=noise, ess=100
    )
    camera = bc.camera(result, average=True)
    found = bc.predict(camera, points.world)
    inside = (points.pixels > found.lower) & (points.pixels < found.upper)
    assert 0.85 < inside.mean() <= 1
    assert found.sd.max() < 2.0


def test_data_frames_come_back_as_data_frames(thesis_comparison):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(POINTS, columns=["x", "y", "z"], index=["a", "b", "c"])
    found = bc.predict(thesis_comparison, frame)
    assert list(found.index) == ["a", "b", "c"]
    np.testing.assert_array_equal(found["r"], bc.predict(thesis_comparison, POINTS).mean[:, 0])
    with pytest.raises(InputError, match="no column 'z'"):
        bc.predict(thesis_comparison, frame[["x", "y"]])
