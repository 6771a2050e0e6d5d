"""A lens calibrated from simulated views through OpenCV's projector, with its truth."""

from __future__ import annotations

import numpy as np

import bayescal as bc
from bayescal.comparison.lenses.results import LensComparison
from tests.helpers.boards import CENTRE, FOCAL, SIZE, pictures

MATRIX = np.array([[FOCAL[0], 0, CENTRE[0]], [0, FOCAL[1], CENTRE[1]], [0, 0, 1.0]])
DISTORTION = np.array([-0.2, 0.0, 0.0, 0.0, 0.0])


def lens_result(seed: int = 0, n_views: int = 6, sigma: float = 0.2) -> LensComparison:
    """Compare one lens, "radial 1", which is the truth; noise independent."""
    rng = np.random.default_rng(seed)
    world, pixels = pictures(rng, n_views, tuple(DISTORTION), sigma)
    width, height = (int(side) for side in SIZE)
    views = bc.Views.from_arrays([world] * n_views, list(pixels), width=width, height=height)
    return bc.calibrate(views, lenses=["radial 1"], independent=True, ess=100, seed=seed)
