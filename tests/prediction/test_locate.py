"""Locations against the mapping they invert, closed forms, and repeated noisy measurements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.errors import InputError
from bayescal.prediction.calibrated.members import Parameters
from bayescal.prediction.calibrated.polynomial_member import PolynomialMember
from bayescal.prediction.columns import location_columns, pair_columns
from bayescal.prediction.given import Surface
from bayescal.prediction.locate import locate
from bayescal.prediction.measuring import weighted_quantile
from bayescal.prediction.pairs import _expanded, distances
from bayescal.prediction.predict import predict
from tests.helpers.cameras import turned_points
from tests.helpers.cases import camera_points

AT = 150.0


@pytest.fixture(scope="module")
def cameras() -> dict[str, bc.CalibratedCamera]:
    """One camera of each kind of mapping, with the noise of 1 px (the pinhole 0.3 px)."""
    points = camera_points(60, (960.0, 700.0, 40.0), noise=1.0)
    return {
        "separable": bc.camera(bc.fit(points, 2, 1, ess=400)),
        "bivariate": bc.camera(bc.fit_family(points, "bivariate", (2,))),
        "free": bc.camera(bc.fit_family(points, "separable", (2, 1), position="free", ess=100)),
        "pinhole": bc.camera(bc.fit_family(turned_points(0.3), "pinhole", (1,), ess=400)),
    }


def world_of(name: str) -> np.ndarray:
    """Points well inside the calibrated domain, at one z."""
    if name == "pinhole":
        return np.array([[60.0, 70.0, 80.0], [110.0, 120.0, 80.0], [150.0, 160.0, 80.0]])
    return np.array([[20.0, 10.0, AT], [-30.0, -15.0, AT], [0.0, 25.0, AT]])


@pytest.mark.parametrize("name", ["separable", "bivariate", "free", "pinhole"])
def test_predict_then_locate_is_the_identity(cameras, name):
    """Truth: the points that the pixels were predicted from; to a fraction of the sd."""
    camera, world = cameras[name], world_of(name)
    pixels = predict(camera, world).mean
    found = locate(camera, pixels, surface=Surface((0, 0, 1), world[0, 2]))
    assert (found.count == 1).all()
    assert not found.extrapolated.any()
    error = 5 / np.sqrt(len(camera.chosen.parameters.draws))
    assert (np.abs(found.values - world) <= error * found.sd + 1e-9).all()
    np.testing.assert_allclose(found.sd, found.linear_sd, rtol=0.12, atol=1e-9)
    assert not found.nonlinear.any()


@pytest.mark.parametrize("name", ["separable", "bivariate", "free", "pinhole"])
def test_an_inverse_that_is_claimed_is_one(cameras, name):
    """Truth: the mapping of each draw, put to a point on its ray: 1e-9 px."""
    camera, world = cameras[name], world_of(name)
    member = camera.chosen
    pixels = predict(camera, world).mean
    theta = member.parameters.draws[:50]
    found = member.rays(theta, pixels[None], member.solutions(pixels).scaled)
    assert found.found.all()
    for i in range(len(theta)):
        points = found.origin[i] + 700.0 * found.direction[i]
        back, seen = member.project(theta[i : i + 1], points)
        assert seen.all()
        assert np.abs(back[0] - pixels).max() < 1e-9 * 10  # two roundings of 1000 px more


def test_no_solution_and_several_are_said(cameras):
    """Truth: a parabola with its vertex inside the domain has two solutions, or none above it."""
    member = cameras["separable"].chosen
    assert isinstance(member, PolynomialMember)
    mean = np.array([500.0, 0.0, -200.0, 540.0, 300.0])  # r: falls off on both sides
    bent = replace(member, parameters=replace(member.parameters, mean=mean))
    top = 500.0 + 100.0  # P_2(0) = -1/2
    solved = bent.solutions(np.array([[top - 50.0, 540.0], [top + 5.0, 540.0]]))
    assert solved.count.tolist() == [2, 0]


def test_the_sd_is_the_spread_of_noisy_measurements(cameras):
    """Truth: a straight camera known almost exactly; only the pixel's noise is left."""
    camera = cameras["separable"]
    (member,) = camera.members
    kept = member.parameters
    sure = replace(
        camera,
        members=(
            replace(
                member,
                parameters=replace(
                    kept, draws=np.tile(kept.mean, (1000, 1)), root=np.zeros_like(kept.root)
                ),
            ),
        ),
    )
    world = world_of("separable")
    pixels = predict(sure, world).mean
    found = locate(sure, pixels, surface=Surface((0, 0, 1), AT))
    rng = np.random.default_rng(5)
    noisy = pixels[:, None] + member.noise.scale * rng.standard_normal((3, 2000, 2))
    start = np.repeat(member.solutions(pixels).scaled, 2000, axis=0)
    seen = member.rays(kept.mean[None], noisy.reshape(1, -1, 2), start)
    points = seen.origin[0] + seen.direction[0] * (AT / seen.direction[0, :, 2:])
    spread = points.reshape(3, 2000, 3).std(axis=1)
    np.testing.assert_allclose(found.sd[:, :2], spread[:, :2], rtol=0.15)
    np.testing.assert_allclose(found.linear_sd, found.parts["noise"])


def test_depth_counts_in_proportion(cameras):
    """Truth: x = w (z - z_0), so that dx/dz = w; the error is one for both ends of a distance."""
    world = world_of("separable")
    camera = cameras["separable"]
    pixels = predict(camera, world).mean
    sd = 2.0
    found = locate(camera, pixels, surface=Surface((0, 0, 1), AT, sd))
    np.testing.assert_allclose(found.values[:, 2], AT, rtol=1e-12)  # not off by a draw's error
    np.testing.assert_allclose(found.sd[:, 2], sd, rtol=2e-3)  # of 1000 quantiles
    np.testing.assert_allclose(found.parts["depth"], sd * np.abs(world) / AT, rtol=0.02, atol=0.01)
    apart = distances(camera, pixels[:1], pixels[1:2], Surface((0, 0, 1), AT, sd))
    length = float(np.linalg.norm(world[0] - world[1]))
    assert apart.values[0] == pytest.approx(length, rel=0.01)
    assert apart.parts["depth"][0] == pytest.approx(sd * length / AT, rel=0.02)


def test_expanded_uncertainty_covers_as_stated(cameras):
    """Truth: known distances, by 60 calibrations of known posterior, 5 new pairs of pixels each.

    Within 4 standard errors of 95 %; an expanded uncertainty 30 % too small would show.
    """
    camera, rng = cameras["separable"], np.random.default_rng(11)
    member, world = camera.chosen, world_of("separable")[:2]
    kept, length = member.parameters, np.linalg.norm(world[0] - world[1])
    sure = replace(kept, draws=np.tile(kept.mean, (1000, 1)), root=0 * kept.root)
    exact = predict(replace(camera, members=(replace(member, parameters=sure),)), world).mean
    ratios = []
    for sigma in np.exp(member.noise.log_sigma[::16][:60]):
        mean = kept.mean + kept.root @ rng.standard_normal(len(kept.mean))
        draws = mean + rng.standard_normal((1000, len(mean))) @ kept.root.T
        own = replace(member, parameters=Parameters(mean, kept.root, draws, kept.exact))
        pixels = exact + sigma * rng.standard_normal((5, 2, 2))
        calibrated = replace(camera, members=(own,))
        found = distances(calibrated, pixels[:, 0], pixels[:, 1], Surface((0, 0, 1), AT))
        ratios.append((found.values - length) / found.expanded)
    error = 4 * np.sqrt(0.95 * 0.05 / np.size(ratios))
    assert abs((np.abs(ratios) < 1).mean() - 0.95) < error
    assert (np.abs(ratios) < 0.7).mean() < 0.95 - error  # negative control


def test_draws_without_a_distance_count_as_outside():
    """Truth: order statistics of |e|, by hand; as many draws lost as put the quantile beyond."""
    rng = np.random.default_rng(4)
    away = np.abs(rng.standard_normal((1, 1000, 3)))
    away[0, :30, 1] = np.nan
    away[0, :60, 2] = np.nan
    expanded, error = _expanded(away, np.ones(1))
    whole, part = np.sort(away[0, :, 0]), np.sort(away[0, 30:, 1])
    assert expanded[0] == whole[949]
    assert expanded[1] == part[949]  # the 950th of 1000, though 970 are left
    assert expanded[2] == np.inf
    # Of |e| of a standard normal sqrt(p (1 - p) / n) / f: 0.059; spacings scatter it by a third.
    normal = np.sqrt(0.95 * 0.05 / 1000) / (2 * stats.norm.pdf(1.96))
    assert error[0] == pytest.approx(normal, rel=0.5)


def test_no_certificate_near_the_horizon(cameras):
    """Truth: rays that meet a plane nearly along them: noise turns some of them past it."""
    camera = cameras["separable"]
    pixels = predict(camera, [[0.0, 10.0, AT], [10.0, 10.0, AT], [0.0, 10.0, AT]]).mean
    # Along x = 0 the plane x = z w + d has rays of slope w beside it, off by 1.5 sd (and by 10).
    found = locate(camera, pixels[:1])
    slope = found.values[0, 0] / found.values[0, 2]
    sd = found.linear_sd[0, 0]
    surfaces = [Surface((1.0, 0.0, -(slope - far * sd)), 0.05) for far in (1.5, 10.0)]
    near, off = (distances(camera, pixels[1:2], pixels[:1], s) for s in surfaces)
    assert 0.5 < near.share[0] < 0.95
    assert near.found[0]
    assert not near.certain[0]
    assert np.isnan(near.k[0])
    assert pair_columns(near)["note"][0].endswith("% of draws answer")
    assert off.share[0] == 1
    assert off.certain[0]
    assert off.expanded_error[0] < 0.1 * off.expanded[0]
    located = locate(camera, pixels[:1], surface=surfaces[0])
    assert np.isnan(located.upper).all()
    assert "of draws answer" in location_columns(located)["note"][0]


def test_the_budget_adds_up(cameras):
    """Truth: the linear variance is the sum of its parts, and an average has one between models."""
    camera, world = cameras["pinhole"], world_of("pinhole")
    pixels = predict(camera, world).mean
    found = locate(camera, pixels, surface=Surface((0.1, 0.2, 1), 100.0))
    total = sum(part**2 for part in found.parts.values())
    np.testing.assert_allclose(found.linear_sd**2, total)
    assert (found.parts["models"] == 0).all()
    on_plane = found.values @ np.array([0.1, 0.2, 1])
    np.testing.assert_allclose(on_plane, 100.0)


def test_directions_have_length_one_and_an_angle(cameras):
    camera, world = cameras["pinhole"], world_of("pinhole")
    found = locate(camera, predict(camera, world).mean)
    np.testing.assert_allclose(np.linalg.norm(found.values, axis=1), 1, atol=1e-6)
    # 0.3 px at a focal length of 3043 px, and the pose on top of it.
    assert (found.angle > 0.3 / 3043).all()
    assert (found.angle < 0.1).all()


def test_the_same_seed_gives_the_same_draws(cameras):
    camera, pixels = cameras["separable"], predict(cameras["separable"], world_of("")).mean
    surface = Surface((0, 0, 1), AT, 1.0)
    one, two, other = (locate(camera, pixels, surface=surface, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.values, two.values)
    assert (one.values != other.values).any()


def test_a_weighted_quantile_is_that_of_repeated_values():
    values = np.array([[3.0], [1.0], [2.0]])
    share = np.array([[0.2], [0.5], [0.3]])
    assert weighted_quantile(values, share, 0.5)[0] == 1.0
    assert weighted_quantile(values, share, 0.6)[0] == 2.0
    assert weighted_quantile(values, share, 0.95)[0] == 3.0


def test_surfaces_that_are_none(cameras):
    with pytest.raises(InputError, match="not all 0"):
        Surface((0, 0, 0), 1.0)
    with pytest.raises(InputError, match="can't be negative"):
        Surface((0, 0, 1), 1.0, -1.0)
    with pytest.raises(InputError, match="need a depth or a plane"):
        distances(cameras["separable"], [[1, 2]], [[3, 4]], None)
    behind = locate(cameras["separable"], [[960.0, 540.0]], surface=Surface((0, 0, 1), -50.0))
    assert not behind.found.any()


def test_data_frames_come_back_as_data_frames(cameras):
    """Truth: the same rows as arrays."""
    pandas = pytest.importorskip("pandas")
    camera = cameras["separable"]
    pixels = predict(camera, world_of("separable")).mean
    frame = pandas.DataFrame(pixels, columns=["r", "c"], index=list("abc"))
    found = bc.locate(camera, frame, depth=AT)
    assert list(found.index) == list("abc")
    np.testing.assert_array_equal(found["x"], bc.locate(camera, pixels, depth=AT).values[:, 0])
    pairs = np.column_stack([pixels[:2], pixels[1:]])
    frame = pandas.DataFrame(pairs, columns=["r1", "c1", "r2", "c2"])
    apart = bc.distances(camera, frame, plane=(0, 0, 1, AT))
    np.testing.assert_array_equal(apart["U"], bc.distances(camera, pairs, depth=AT).expanded)
    with pytest.raises(InputError, match="no column 'c2'"):
        bc.distances(camera, frame.drop(columns="c2"), depth=AT)
    with pytest.raises(InputError, match="keep one"):
        bc.locate(camera, pixels, depth=AT, plane=(0, 0, 1, AT))
    with pytest.raises(InputError, match="needs a, b, c, d"):
        bc.locate(camera, pixels, plane=(0, 0, 1))
