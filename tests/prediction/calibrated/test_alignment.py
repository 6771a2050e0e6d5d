"""The turn that poses absorb, against a known turn and the lens comparison's linear algebra."""

from __future__ import annotations

import numpy as np

import bayescal as bc
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotations
from bayescal.comparison.lenses.prediction import (
    View,
    deviation,
    image_grid,
    observed_sample,
    response,
)
from bayescal.prediction.calibrated.alignment import absorbed_turns
from tests.helpers.boards import SIZE


def test_a_turn_is_found_again():
    """Truth: the turn that the pixels were made with; to rounding."""
    lens = lens_named("radial", order=1, tangential=False)
    intrinsics, k = np.array([[500.0, 505.0, 320.0, 240.0]]), np.array([[-0.2]])
    side = np.linspace(-0.4, 0.4, 5)
    sight = np.stack([*np.meshgrid(side, side), np.ones((5, 5))], axis=-1).reshape(-1, 3)
    turn = np.array([[0.03, -0.05, 0.1]])
    moved = sight @ np.swapaxes(rotations(turn), 1, 2)
    pixels = intrinsics[0, 2:] + intrinsics[0, :2] * lens.distort(moved, k)[0]
    found = absorbed_turns(lens, intrinsics, k, sight, pixels)
    np.testing.assert_allclose(found, turn, rtol=0, atol=1e-12)


def test_a_lens_is_as_sure_as_its_linear_response(lens_comparison):
    """Truth: T C T' of the comparison's own coordinates, the turn taken out; Monte Carlo error."""
    problem, data = lens_comparison.best.evidence.problem, lens_comparison.setting.data
    grid, sample = image_grid(SIZE, 5, 4), observed_sample(data)
    response_map = response(View(problem.model, problem.x), grid, sample, None)
    expected = deviation(response_map, np.cov(lens_comparison.draws.T))
    camera = bc.camera(lens_comparison)
    member = camera.chosen
    sight = member.rays(member.parameters.mean[None], grid[None], None)
    found = bc.predict(camera, sight.direction[0] * 500.0)
    sd = np.sqrt((found.sd**2).mean(axis=1))
    # 1000 of the draws, whose sds have an error of 1/sqrt(2000); a sample of 100 fixes the turn.
    np.testing.assert_allclose(sd, expected, rtol=5 / np.sqrt(2000))
    still = member.parameters.draws.copy()
    still[:, member.n_lens :] = 0  # without the turn: far less sure of the same lens
    pixels, _ = member.project(still, sight.direction[0])
    assert np.median(pixels.std(axis=0) / found.sd) > 1.5


def test_a_lens_camera_is_kept(lens_comparison, tmp_path):
    camera = bc.camera(lens_comparison)
    assert not camera.posed
    bc.keep_camera(camera, tmp_path / "camera.npz")
    points = np.array([[10.0, 20.0, 400.0]])
    again = bc.predict(tmp_path / "camera.npz", points)
    np.testing.assert_array_equal(again.sd, bc.predict(camera, points).sd)
