"""The noise that a calibrated camera keeps, against what its views were made with."""

from __future__ import annotations

import numpy as np

import bayescal as bc
from tests.helpers.boards import pictures


def test_a_calibration_keeps_what_neighbours_share(tmp_path):
    """Truth: 0.1 px of each point's own, sqrt(2) times as much shared over 100; the draws' sd."""
    rng = np.random.default_rng(3)
    world, pixels = pictures(rng, 6, (-0.2, 0.0, 0.0, 0.0, 0.0), 1e-6)
    apart = np.linalg.norm(world[:, None] - world[None], axis=2)
    root = 0.1 * np.linalg.cholesky(np.eye(len(world)) + 2 * np.exp(-apart / 100.0))
    pixels = pixels + root @ rng.standard_normal(pixels.shape)
    views = bc.Views.from_arrays([world] * 6, list(pixels), width=640, height=480)
    camera = bc.camera(bc.calibrate(views, lenses=["radial 1"], ess=100))
    levels = camera.chosen.noise.neighbours
    sharing = levels[levels[:, 1] > 0]
    assert len(sharing) > 900
    mean, sd = np.log(sharing).mean(axis=0), np.log(sharing).std(axis=0)
    assert (np.abs(mean - np.log([0.1, 0.1 * np.sqrt(2), 100.0])) < 3 * sd).all()
    bc.keep_camera(camera, tmp_path / "camera.npz")
    again = bc.camera(tmp_path / "camera.npz")
    np.testing.assert_array_equal(again.chosen.noise.neighbours, levels)


def test_independent_noise_is_shared_by_none(lens_comparison):
    assert bc.camera(lens_comparison).chosen.noise.neighbours is None
