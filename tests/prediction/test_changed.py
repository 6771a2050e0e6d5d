"""Two calibrations of one camera against known changes, and false alarms against their rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.lens_member import LensMember
from bayescal.prediction.calibrated.lenses import lens_member
from bayescal.prediction.calibrated.members import Parameters
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
    return replace(camera, members=(replace(member, parameters=kept),), averaged=False)


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
    mean = np.array([np.log(530), np.log(530), 320, 240, -0.28, 0.08])
    root = np.diag([0.003, 0.003, 1.5, 1.5, 0.01, 0.02])
    root[1, :2] = 0.003 * 0.99, 0.003 * 0.14
    draws = mean + root @ rng.standard_normal(6) + narrow * rng.standard_normal((300, 6)) @ root.T
    hull = np.array([[20.0, 20], [620, 20], [620, 460], [20, 460]])
    columns, rows = np.meshgrid(np.linspace(30, 610, 10), np.linspace(30, 450, 10))
    noise = NewNoise(np.zeros((300, 2)), np.empty((300, 2, 0)))
    seen = np.column_stack([columns.ravel(), rows.ravel()])
    member = lens_member("radial 2", draws, hull, noise, seen)
    return CalibratedCamera(
        (member,), (1.0,), 1.0, False, (640, 480), False, hull, 10.0, "made"
    )  # fmt: skip


@pytest.mark.parametrize("narrow", [1.0, 0.7])
def test_lenses_that_did_not_change_have_uniform_p_values(narrow):
    """Truth: uniform (Kolmogorov-Smirnov); the turn that is taken out must not count."""
    rng = np.random.default_rng(1)
    found = [changed(of_a_lens(rng, narrow), of_a_lens(rng, narrow)).p_value for _ in range(40)]
    assert (stats.kstest(found, "uniform").pvalue > 0.01) == (narrow == 1.0)


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
        changed_member = replace(member, parameters=Parameters.of_draws(draws))
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
