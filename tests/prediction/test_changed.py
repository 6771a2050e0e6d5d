"""Two calibrations of one camera against known changes, and false alarms against their rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.comparison.lenses.candidates import named_candidate
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.lenses import lens_member
from bayescal.prediction.calibrated.members import Estimate, Parameters
from bayescal.prediction.calibrated.noise import NewNoise
from bayescal.prediction.calibrated.polynomial_member import PolynomialMember
from bayescal.prediction.changed import changed
from tests.helpers.cases import camera_points

DOF, POINTS = 12, 15


@pytest.fixture(scope="module")
def straight() -> CalibratedCamera:
    return bc.camera(bc.fit(camera_points(40, noise=1.0, seed=1), 1, 1, ess=100))


def of_students_t(
    camera: CalibratedCamera, rng: np.random.Generator, shift: float = 0.0, narrow: float = 1.0
):
    """Simulate a calibration of the same camera whose posterior is known: Student's t.

    The posterior is given `narrow` times as wide as it is.
    """
    member = camera.chosen
    assert isinstance(member, PolynomialMember)
    unit = np.eye(4)
    estimate = np.array([960.0 + shift, 500.0, 540.0, 300.0]) + unit @ rng.standard_normal(4)
    sigma = narrow * np.sqrt(rng.chisquare(DOF) / DOF)  # estimated, of a true 1
    wide = sigma * np.sqrt(DOF / rng.chisquare(DOF, (1000, 1)))
    draws = estimate + wide * (rng.standard_normal((1000, 4)) @ unit)
    kept = Parameters(estimate, sigma * unit, draws, False)
    alone = Estimate(estimate, sigma * unit, ((4, DOF),))
    made = replace(member, parameters=kept, estimate=alone)
    return replace(camera, members=(made,), averaged=False)


@pytest.mark.parametrize("narrow", [1.0, 0.7])
def test_false_alarms_are_as_many_as_stated(straight, narrow):
    """Truth: p-values of pairs that did not change are uniform; control: sds 30 % too small."""
    rng = np.random.default_rng(4)

    def calibration() -> CalibratedCamera:
        return of_students_t(straight, rng, narrow=narrow)

    found = [changed(calibration(), calibration()).p_value for _ in range(60)]
    assert (stats.kstest(found, "uniform").pvalue > 1e-3) == (narrow == 1.0)


def of_a_lens(rng: np.random.Generator, narrow: float) -> CalibratedCamera:
    """Simulate a calibration of radial 2 whose posterior is known, but for a factor: normal."""
    truth = np.array([np.log(530), np.log(530), 320, 240, -0.28, 0.08])
    root = np.diag([0.003, 0.003, 1.5, 1.5, 0.01, 0.02])
    root[1, :2] = 0.003 * 0.99, 0.003 * 0.14
    mean = truth + root @ rng.standard_normal(6)
    draws = mean + narrow * rng.standard_normal((300, 6)) @ root.T
    hull = np.array([[20.0, 20], [620, 20], [620, 460], [20, 460]])
    columns, rows = np.meshgrid(np.linspace(30, 610, 10), np.linspace(30, 450, 10))
    noise = NewNoise(np.zeros((300, 2)), np.empty((300, 2, 0)))
    seen = np.column_stack([columns.ravel(), rows.ravel()])
    alone = Estimate(mean, narrow * root, ((6, np.inf),))
    lens = lens_member(named_candidate("radial 2"), draws, hull, noise, seen)
    member = replace(lens, estimate=alone)
    return CalibratedCamera(
        (member,), (1.0,), 1.0, False, (640, 480), False, hull, 10.0, "made"
    )  # fmt: skip


@pytest.mark.parametrize("narrow", [1.0, 0.7])
def test_lenses_that_did_not_change_have_uniform_p_values(narrow):
    """Truth: uniform (Kolmogorov-Smirnov); the turn that is taken out must not count."""
    rng = np.random.default_rng(1)
    found = [changed(of_a_lens(rng, narrow), of_a_lens(rng, narrow)).p_value for _ in range(20)]
    assert (stats.kstest(found, "uniform").pvalue > 0.01) == (narrow == 1.0)


def calibrations(order: int, rng: np.random.Generator, n: int, **options) -> list[CalibratedCamera]:
    """Calibrate a straight camera again and again, by polynomials of some order."""
    found = []
    for _ in range(n):
        ratios = rng.uniform([-0.5, -0.4], [0.5, 0.4], (30, 2))
        world = 100 * np.column_stack([ratios, np.ones(30)])
        pixels = np.array([960.0, 540.0]) + 1000 * ratios + rng.standard_normal((30, 2))
        points = bc.Correspondences.from_arrays(
            world, pixels, setup=bc.Setup(width=1920, height=1080)
        )
        found.append(bc.camera(bc.fit_family(points, "separable", (order, order), **options)))
    return found


@pytest.mark.parametrize("tau", [1e-4, 0.05])
def test_one_polynomial_is_tested_as_nested_models_are(tau):
    """Truth: Chow's test, the squares that one polynomial for both leaves more than two do."""
    rng, pairs = np.random.default_rng(3), []
    for seed in range(4):
        world = [camera_points(40, noise=0.0, seed=10 * seed + i).world for i in (0, 1)]
        aside = (0.0, 0.3 * seed)
        pixels = [
            np.column_stack([960 + a + 1100 * w[:, 0] / w[:, 2], 540 + 900 * w[:, 1] / w[:, 2]])
            + rng.standard_normal((40, 2))
            for w, a in zip(world, aside, strict=True)
        ]
        pairs.append((world, pixels))
    for world, pixels in pairs:
        setup = bc.Setup(width=1920, height=1080)
        cameras = [
            bc.camera(
                bc.fit_family(
                    bc.Correspondences.from_arrays(w, p, setup=setup),
                    "separable", (3, 2), sigma=1.0, tau=tau,
                )
            )
            for w, p in zip(world, pixels, strict=True)
        ]  # fmt: skip
        squares = 0.0
        for axis, order in ((0, 3), (1, 2)):
            designs = [np.vander(w[:, axis] / w[:, 2], order + 1) for w in world]
            readings = [p[:, axis] for p in pixels]
            apart = sum(rss(d, t) for d, t in zip(designs, readings, strict=True))
            squares += rss(np.concatenate(designs), np.concatenate(readings)) - apart
        expected = stats.chi2.sf(squares, 7)
        found = changed(*cameras)
        assert found.by_data
        assert found.tested == ("separable (3, 2), position stated",) * 2
        error = np.sqrt(expected * (1 - expected) / 1000)  # draws of each
        assert found.p_value == pytest.approx(expected, abs=4 * error + 1e-3)


def rss(design, readings) -> float:
    return float(((readings - design @ np.linalg.lstsq(design, readings)[0]) ** 2).sum())


def test_a_prior_that_shrinks_both_hides_no_change():
    """Truth: mean 1/2 of p-values; control: of the posteriors themselves it is far larger."""
    cameras = calibrations(4, np.random.default_rng(5), 20, sigma=1.0, tau=1e-5)
    pairs = list(zip(cameras[::2], cameras[1::2], strict=True))

    def bare(camera: CalibratedCamera) -> CalibratedCamera:
        members = tuple(replace(m, estimate=None) for m in camera.members)
        return replace(camera, members=members)

    found = np.array(
        [[changed(*pair).p_value, changed(*map(bare, pair)).p_value] for pair in pairs]
    )
    se = np.sqrt(1 / 12 / len(pairs))
    assert abs(found[:, 0].mean() - 0.5) < 3 * se
    assert found[:, 1].mean() - 0.5 > 3 * se
    assert not changed(*map(bare, pairs[0])).by_data


def test_the_model_that_both_find_plausible_is_tested(straight):
    """Truth: products of probabilities .1 x .6 and .9 x .2; without a common one the chosen."""

    def named(*models: tuple[str, float]) -> CalibratedCamera:
        members = tuple(replace(straight.chosen, name=name) for name, _ in models)
        shares = tuple(share for _, share in models)
        return replace(straight, members=members, probabilities=shares, averaged=True)

    one, two = named(("a", 0.9), ("b", 0.1)), named(("b", 0.6), ("a", 0.2), ("c", 0.2))
    assert changed(one, two).tested == ("a", "a")
    assert changed(named(("a", 0.5), ("b", 0.5)), two).tested == ("b", "b")
    assert changed(named(("d", 1.0)), two).tested == ("d", "b")


def test_the_size_of_a_change_has_no_noise_in_it(straight):
    """Truth: 6 px of r; squares of the reported sizes average to it, within 4 standard errors."""
    rng = np.random.default_rng(8)
    squares = np.array([
        changed(of_students_t(straight, rng), of_students_t(straight, rng, shift=6.0)).rms ** 2
        for _ in range(30)
    ])  # fmt: skip
    assert abs(squares.mean() - 36) < 4 * squares.std(ddof=1) / np.sqrt(30)


def test_a_shift_is_found_and_measured(straight):
    """Truth: all of r shifted by 40 px, known to about 1.4."""
    rng = np.random.default_rng(6)
    found = changed(of_students_t(straight, rng), of_students_t(straight, rng, shift=40.0))
    assert found.changed
    assert found.p_value < 1e-3
    assert abs(found.rms - 40) < 10
    assert found.bound > found.rms
    centre = found.named.shift[0]
    assert abs(centre[0] - 40) < 4 * found.named.sd[0] * np.sqrt(2)
    assert "has changed" in found.verdict


def test_a_camera_is_the_same_as_itself(straight, lens_comparison):
    for camera in (straight, bc.camera(lens_comparison)):
        found = changed(camera, camera)
        assert found.rms < 1e-8
        assert not found.changed
        assert "No change is seen" in found.verdict


def test_lenses_are_compared_after_their_turn(lens_comparison):
    """Truth: a principal point shifted is nearly a turn; a longer focal length is none."""
    camera = bc.camera(lens_comparison)
    member = camera.chosen
    assert isinstance(member, LensMember)

    def moved(column: int, by: float) -> CalibratedCamera:
        draws = member.parameters.draws.copy()
        draws[:, column] += by
        changed_member = replace(member, parameters=Parameters.of_draws(draws), estimate=None)
        return replace(camera, members=(changed_member,))

    shifted = changed(camera, moved(2, 3.0))
    assert shifted.rms < 0.3 * 3.0
    longer = changed(camera, moved(0, 0.02))
    assert longer.p_value < 1e-3
    assert longer.rms > 1.0


def test_other_cameras_are_refused(straight, lens_comparison):
    lens = bc.camera(lens_comparison)
    for other, said in (
        (lens, "images of 1920 by 1080 px and images of 640 by 480 px"),
        (replace(straight, c_from_bottom=not straight.c_from_bottom), "c counted from"),
        (replace(lens, size=straight.size, c_from_bottom=straight.c_from_bottom), "many views"),
    ):
        with pytest.raises(InputError, match=said):
            changed(straight, other)
    away = replace(straight, pixel_hull=straight.pixel_hull + 5000.0)
    with pytest.raises(InputError, match="no part of the image in common"):
        changed(straight, away)
