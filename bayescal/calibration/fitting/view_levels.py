"""How much noisier one view is than another, from what lenses with many terms leave over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import Fit, least_squares
from bayescal.calibration.fitting.stacking import residuals
from bayescal.calibration.fitting.start import start_fit
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations

TURNS = 3  # of fit and levels: a loud view pulls at the first fit as strongly as the others
SHARED = 4.0  # values that every view is given at the common level: a view of few points is near it


def view_levels(data: Observations, models: Sequence[LensModel]) -> Array:
    """Noise of each view over that of the median view, ``(n_views,)``.

    Parameters
    ----------
    models : sequence of LensModel
        With terms enough for any lens: the one that fits best is taken.

    Returns
    -------
    Array
        1 for every view where none of the models can see all points.
    """
    levels = np.ones(data.n_views)
    start = [(model, start_fit(model, data)) for model in models]
    model, fit = min(start, key=lambda pair: pair[1].sum_of_squares)
    if not np.isfinite(fit.sum_of_squares):
        return levels
    for _ in range(TURNS):
        levels = _levels(data, model, fit)
        fit = least_squares(model, data.with_levels(levels), fit.x, fit.poses)
    return levels


def _levels(data: Observations, model: LensModel, fit: Fit) -> Array:
    left, _ = residuals(model, data, fit.x, fit.poses)
    squares, dof = (left**2).sum(axis=(1, 2)), 2 * data.counts - 6
    common = np.median(squares / np.maximum(dof, 1))
    found = np.sqrt((squares + SHARED * common) / (dof + SHARED))
    return np.asarray(found / np.median(found))
