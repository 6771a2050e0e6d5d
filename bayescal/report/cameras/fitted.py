"""The recommended lens of a comparison over many views, as a camera to be written."""

from __future__ import annotations

import numpy as np

from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.cameras.camera import INTRINSICS, FittedCamera


def fitted_camera(found: LensComparison) -> FittedCamera:
    """Give the most probable lens of a comparison as a camera.

    Its numbers are means of the posterior with the error models averaged; what was held fixed is
    not in the covariance.

    Parameters
    ----------
    found : LensComparison
        As of `bayescal.calibrate`.

    Returns
    -------
    FittedCamera
    """
    model = found.best.evidence.problem.model
    intrinsics, k, _ = model.physical(found.draws)
    draws = np.concatenate([intrinsics, k], axis=1)
    names = np.array([*INTRINSICS, *model.lens.names])
    varied = np.ptp(draws, axis=0) > 0
    mean = draws.mean(axis=0)
    width, height = (round(side) for side in model.size)
    return FittedCamera.from_arrays(
        model.lens,
        mean[:4],
        mean[4:],
        (width, height),
        covariance=np.atleast_2d(np.cov(draws[:, varied].T)),
        names=names[varied].tolist(),
        model=found.best.name,
        sound=found.sound,
    )
