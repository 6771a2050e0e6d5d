"""A pinhole under noise that forgives bad points: its modes, its sampling."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.inference.optimum import find_modes
from bayescal.inference.pinhole import PinholeModel
from bayescal.inference.pinhole_fit import fit_pinhole
from bayescal.inference.pinhole_laplace import linear_pixels
from bayescal.inference.sampled_posterior import sample_model
from bayescal.models.noise.outlier_mixture import OutlierMixture
from scripts.robust_cameras import robust_model
from tests.cameras import problem, turned_points


def model(points, order, noise=None) -> PinholeModel:
    geometry, prior, data = problem(points, order)
    return PinholeModel.of(geometry, prior, data, fit_pinhole(points, geometry, prior, data), noise)


def two_cameras(apart):
    """Half of the points as one camera sees them, the same points as another with its r shifted."""
    one = turned_points(0.3)
    some = np.random.default_rng(1).permutation(len(one))[:30]
    world, pixels = one.world[some], one.pixels[some]
    shift = np.array([apart / 2, 0.0])
    both = np.concatenate([pixels + shift, pixels - shift])
    return bc.Correspondences.from_arrays(np.concatenate([world, world]), both, setup=one.setup)


@pytest.mark.parametrize("points", [bc.thesis(), turned_points(0.1)], ids=["thesis", "turned"])
def test_pixels_linearised_at_the_frame_have_a_standard_normal_posterior(points):
    made = model(points, 1)
    pixels = linear_pixels(made.geometry, made.data, made.frame)
    slope, gram = pixels.normal(pixels.plain)
    assert slope == pytest.approx(np.zeros(11), abs=1e-4)
    assert gram == pytest.approx(np.eye(11), abs=1e-9)
    # The prior alone holds nothing back: its precision is positive semi-definite.
    assert np.linalg.eigvalsh(pixels.prior_precision).min() > -1e-9


def test_two_cameras_that_half_of_the_points_follow_share_the_posterior():
    """By symmetry: shifting the principal point turns the one into the other."""
    made = model(two_cameras(40.0), 0, OutlierMixture())
    modes = find_modes(made.log_prob, made.starts())
    found = sample_model(made, np.random.default_rng(0), 400)
    assert len(found.modes) == len(modes) >= 2
    # The anchor is the pixel of the points' centroid; the cameras' differ by the shift.
    theta = made.geometry.full(made.free(found.chain.theta.reshape(-1, made.dimension)))
    middle = made.frame.mean[7]
    right = (theta[:, 7] > middle).reshape(found.chain.theta.shape[:2]).mean(axis=1)
    error = right.std(ddof=1) / np.sqrt(len(right))
    assert abs(right.mean() - 0.5) < 5 * error
    assert found.converged
    assert found.estimate.certain


def test_the_mixture_on_the_thesis_data_is_accepted_often():
    """Order 1 is the hardest: eight modes, of groups of readings at the edge."""
    found = sample_model(
        robust_model(bc.thesis(), 1, "outlier-mixture"), np.random.default_rng(1), 400
    )
    assert found.chain.acceptance > 0.45
    assert found.converged
    assert found.estimate.certain
    assert found.log_evidence_error < 0.05
