"""The calibrated camera from Python: of a result, a run or a file, and what it predicts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bayescal.errors import InputError
from bayescal.prediction.calibrated import CalibratedCamera
from bayescal.prediction.columns import prediction_columns
from bayescal.prediction.predict import predict as predict_pixels


def camera(
    source: Any, *, average: bool | None = None, model: str | None = None
) -> CalibratedCamera:
    """Make the calibrated camera of a calibration: what is needed to measure, without its points.

    Parameters
    ----------
    source : a result of `compare`, `compare_families`, `calibrate`; CalibratedCamera, str or Path
        A result; or a run's folder, or a file that `keep_camera` wrote.
    average : bool, optional
        Whether it averages over all plausible models by their probabilities, or takes the most
        probable one; by default it averages where the verdict is undecided.
    model : str, optional
        Take this one of the plausible models alone.

    Returns
    -------
    CalibratedCamera

    Raises
    ------
    InputError
        Where the source holds no camera, or has no such model.
    """
    if isinstance(source, CalibratedCamera):
        found = source
    elif isinstance(source, str | Path):
        from bayescal.report.camera import camera_at

        found = camera_at(source)
    else:
        from bayescal.prediction.sources import camera_of

        found = camera_of(source)
    return (found if model is None else found.only(model)).average(average)


def predict(source: Any, world: Any, *, average: bool | None = None) -> Any:
    """Predict where points of the world appear, with their uncertainty.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    world : array_like or DataFrame
        x, y, z, ``(n, 3)``, world units; a data frame has columns x, y, z.
    average : bool, optional
        As in `camera`.

    Returns
    -------
    Prediction or DataFrame
        Means and deviations of the mapping and of a new measurement, px. For a data frame its
        rows with the columns that ``bayescal predict`` writes.

    Raises
    ------
    InputError
        Where the points have another shape, or a number is not finite.
    """
    fitted = camera(source)
    if not hasattr(world, "columns"):
        return predict_pixels(fitted, world, average=average)
    missing = [name for name in "xyz" if name not in world.columns]
    if missing:
        raise InputError(f"world: the data frame has no column {missing[0]!r}; it needs x, y, z")
    found = predict_pixels(fitted, np.asarray(world[["x", "y", "z"]]), average=average)
    return world.assign(**prediction_columns(found))
