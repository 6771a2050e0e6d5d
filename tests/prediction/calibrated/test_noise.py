"""The noise that a calibrated camera keeps, against what its views were made with."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.lenses.results import LensComparison
from tests.helpers.boards import pictures


@pytest.fixture(scope="module")
def sharing() -> LensComparison:
    """Calibrate with 0.1 px of each point's own, sqrt(2) times as much shared over 100."""
    rng = np.random.default_rng(3)
    world, pixels = pictures(rng, 6, (-0.2, 0.0, 0.0, 0.0, 0.0), 1e-6)
    apart = np.linalg.norm(world[:, None] - world[None], axis=2)
    root = 0.1 * np.linalg.cholesky(np.eye(len(world)) + 2 * np.exp(-apart / 100.0))
    pixels = pixels + root @ rng.standard_normal(pixels.shape)
    views = bc.Views.from_arrays([world] * 6, list(pixels), width=640, height=480)
    return bc.calibrate(views, lenses=["radial 1"], ess=100)


def test_a_calibration_keeps_what_neighbours_share(sharing, tmp_path):
    """Truth: what the pixels were made with; the draws' sd."""
    camera = bc.camera(sharing)
    levels = camera.chosen.noise.neighbours
    shared = levels[levels[:, 1] > 0]
    assert len(shared) > 900
    mean, sd = np.log(shared).mean(axis=0), np.log(shared).std(axis=0)
    assert (np.abs(mean - np.log([0.1, 0.1 * np.sqrt(2), 100.0])) < 3 * sd).all()
    bc.keep_camera(camera, tmp_path / "camera.npz")
    again = bc.camera(tmp_path / "camera.npz")
    np.testing.assert_array_equal(again.chosen.noise.neighbours, levels)


def test_a_new_measurement_has_what_poses_absorb_of_shared_noise(sharing):
    """Truth: noise of sqrt(3) 0.1 px about the mapping; residuals, after the poses, have less."""
    truth = 0.1 * np.sqrt(3)
    assert sharing.best.rms / np.sqrt(2) < 0.85 * truth
    camera = bc.camera(sharing)
    noise = camera.chosen.noise
    levels = noise.log_sigma[:, 0]
    assert abs(levels.mean() - np.log(truth)) < 2 * levels.std()
    body = np.random.default_rng(3).uniform(-60, 60, (8, 3))
    found = bc.predict(camera, body + np.array([0.0, 0.0, 400.0]))
    np.testing.assert_allclose(found.new_sd, np.hypot(found.sd, noise.scale))
    drawn = np.random.default_rng(0).standard_normal((1000, len(body), 2))
    new = found.mean + np.hypot(found.sd, truth) * drawn
    inside = ((new > found.lower) & (new < found.upper)).mean()
    assert 0.93 < inside < 0.99  # by the residuals' noise 0.88


def test_independent_noise_is_shared_by_none(lens_comparison):
    assert bc.camera(lens_comparison).chosen.noise.neighbours is None
