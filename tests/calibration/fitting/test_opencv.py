"""Least squares on the bundled photographs: the optimum is OpenCV's, lens by lens."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import bayescal as bc
from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import rms
from bayescal.calibration.judging.laplace import INFERRED
from bayescal.cameras.lenses.fisheye import Fisheye
from bayescal.comparison.lenses.fitted import FittedLens
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.sweep import Sweep

NAMES = (
    "pinhole",
    "radial 1",
    "radial 2",
    "radial 2 + p",
    "radial 3 + p",
    "fisheye 0",
    "fisheye 2",
)
STOP = (3, 500, 1e-16)
HELD = {"k1": cv2.CALIB_FIX_K1, "k2": cv2.CALIB_FIX_K2, "k3": cv2.CALIB_FIX_K3}


def fisheye_flag(name: str) -> int:
    """Find a flag of fisheye.calibrate: OpenCV 5 has one set for all lenses."""
    return int(getattr(cv2, f"fisheye_CALIB_{name}", None) or getattr(cv2, f"CALIB_{name}"))


VIEWS = bc.chessboard()


@pytest.fixture(scope="module")
def fits() -> dict[str, FittedLens]:
    request = LensRequest((*NAMES, "radial 1 + p", "fisheye 1"), independent=True)
    return {str(lens.key): lens for lens in Sweep(VIEWS, request, INFERRED)}


def planes(lens: FittedLens) -> tuple[list[Array], list[Array], tuple[int, int]]:
    """Points of the target and pixels per view, as OpenCV takes them."""
    world = [VIEWS.world[part] for part in VIEWS.slices]
    pixels = [VIEWS.pixels[part] for part in VIEWS.slices]
    width, height = lens.setting.data.size
    return world, pixels, (int(width), int(height))


def by_opencv(lens: FittedLens) -> tuple[float, dict[str, float], dict[str, float] | None]:
    """RMS, parameters, and their standard deviations where OpenCV gives them."""
    world, pixels, size = planes(lens)
    names = lens.model.lens.names
    if isinstance(lens.model.lens, Fisheye):
        held = [f"FIX_{name.upper()}" for name in ("k1", "k2", "k3", "k4") if name not in names]
        flags = sum(map(fisheye_flag, ("FIX_SKEW", "RECOMPUTE_EXTRINSIC", *held)))
        value, matrix, k, *_ = cv2.fisheye.calibrate(
            [w[None] for w in world], [p[None] for p in pixels], size,
            np.eye(3), np.zeros(4), flags=flags, criteria=STOP,
        )  # fmt: skip
        spread, order = None, ("k1", "k2", "k3", "k4")
    else:
        flags = sum(flag for name, flag in HELD.items() if name not in names)
        flags |= cv2.CALIB_ZERO_TANGENT_DIST * ("p1" not in names)
        single = [[v.astype(np.float32) for v in values] for values in (world, pixels)]
        value, matrix, k, _, _, sds, *_ = cv2.calibrateCameraExtended(
            *single, size, None, None, flags=flags, criteria=STOP
        )
        spread, order = sds.ravel(), ("k1", "k2", "p1", "p2", "k3")
    labels = ("fx", "fy", "cx", "cy", *order)
    values = (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *np.ravel(k))
    found = dict(zip(labels, map(float, values), strict=False))
    sds = None if spread is None else dict(zip(labels, map(float, spread), strict=False))
    return value, found, sds


@pytest.mark.parametrize("name", NAMES)
def test_the_optimum_is_opencvs(name: str, fits: dict[str, FittedLens]) -> None:
    """Truth: OpenCV's own optimisers; RMS to 1e-6 px, parameters to 1e-3 of their deviations."""
    lens = fits[name]
    data = lens.setting.data
    value, theirs, spread = by_opencv(lens)
    assert rms(data, lens.fit.sum_of_squares) == pytest.approx(value, abs=1e-6)
    ours = dict(
        zip(lens.model.names, lens.model.report(lens.fit.x, data.diagonal).tolist(), strict=True)
    )
    sds = deviations(lens)
    for parameter, number in ours.items():
        assert theirs[parameter] == pytest.approx(number, abs=1e-3 * sds[parameter]), parameter
        if spread is not None:
            assert spread[parameter] == pytest.approx(sds[parameter], rel=0.02), parameter


def deviations(lens: FittedLens) -> dict[str, float]:
    """Standard deviations of independent noise, poses inferred, dof 2N - K as OpenCV's."""
    data, model, fit = lens.setting.data, lens.model, lens.fit
    problem = lens.setting.problem(model, fit.x, fit.poses, (0, 0, 0, 0))
    dof = 2 * data.n_points - model.dimension - 6 * data.n_views
    covariance = np.linalg.inv(problem.reduced.precision) * fit.sum_of_squares / dof
    step = 1e-6 * np.sqrt(np.diag(covariance))
    rows = [
        (model.report(fit.x + s, 1.0) - model.report(fit.x - s, 1.0)) / (2 * s.sum())
        for s in np.diag(step)
    ]
    slope = np.array(rows).T
    return dict(zip(model.names, np.sqrt(np.diag(slope @ covariance @ slope.T)), strict=True))
