"""Fits of the sweep reach the noise where a lens bends the image so much that it nearly folds."""

import numpy as np
import pytest

from bayescal.calibration.fitting.least_squares import rms
from bayescal.calibration.judging.laplace import INFERRED
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.sweep import Sweep
from scripts.validation.simulated_boards import Errors, Truth, views_of

SIGMA = 0.3


@pytest.mark.parametrize(
    ("truth", "seed"),
    [
        pytest.param(Truth((-284.0,), None), 3, id="radial"),
        pytest.param(Truth((-250.0,), (90.0, -80.0)), 0, id="tangential"),
    ],
)
def test_a_strongly_bent_image_is_fitted_by_its_own_lens(truth, seed):
    views, _ = views_of(truth, Errors(SIGMA), 6, np.random.default_rng(seed))
    names = ("pinhole", "radial 1", "radial 1 + p", "radial 2", "radial 2 + p")
    sweep = Sweep(views, LensRequest(names, independent=True), INFERRED)
    left = {f.candidate.name: rms(sweep.data, f.fit.sum_of_squares) for f in sweep}
    # Two coordinates a point; 43 to 46 of 648 numbers are spent on lens and poses.
    within = 4 / np.sqrt(2 * views.n_points)
    assert left[truth.key] == pytest.approx(SIGMA * np.sqrt(2 * (1 - 45 / 648)), rel=within)
    assert left["pinhole"] > 2
    assert not sweep.failures
