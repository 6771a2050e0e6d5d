"""Least squares over many views: the optimum is OpenCV's, the derivatives are right."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bayescal.calibration.fitting.least_squares import cost, rms
from bayescal.calibration.fitting.stacking import stacked
from bayescal.calibration.fitting.start import start_fit
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.cameras.lenses import lens_named
from tests.helpers import boards


def test_the_optimum_is_opencvs() -> None:
    """Truth: cv2.calibrateCamera on the same numbers; RMS to 1e-6 px, parameters to 1e-3 sd."""
    world, pixels = boards.pictures(np.random.default_rng(1))
    data = boards.observed(world, pixels)
    model = boards.radial(3, tangential=True)
    fit = boards.fitted(model, data)
    targets = [world.astype(np.float32)] * len(pixels)
    seen = [p.astype(np.float32).reshape(-1, 1, 2) for p in pixels]
    size = (int(boards.SIZE[0]), int(boards.SIZE[1]))
    stop = (3, 500, 1e-16)
    theirs = cv2.calibrateCameraExtended(targets, seen, size, None, None, criteria=stop)
    assert fit.converged
    assert rms(data, fit.sum_of_squares) == pytest.approx(theirs[0], abs=1e-6)
    matrix, k = theirs[1], theirs[2].ravel()
    theirs_named = dict(
        zip(
            ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"),
            (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *k),
            strict=True,
        )
    )
    deviations = dict(zip(theirs_named, theirs[5].ravel()[:9], strict=True))
    ours = dict(zip(model.names, model.report(fit.x, data.diagonal), strict=True))
    for name, value in theirs_named.items():
        assert ours[name] == pytest.approx(value, abs=2e-3 * deviations[name]), name


@pytest.mark.parametrize("bow", [False, True])
@pytest.mark.parametrize("switches", [{}, {"square": True}, {"centred": True}])
def test_derivatives_are_differences(*, bow: bool, switches: dict[str, bool]) -> None:
    """Truth: central differences of the residuals in every coordinate and pose."""
    world, pixels = boards.pictures(np.random.default_rng(2), n_views=2)
    data = boards.observed(world, pixels)
    plain = boards.radial(2, tangential=True)
    fit = boards.fitted(plain, data)
    model = LensModel("m", plain.lens, boards.SIZE, bow=bow, **switches)
    intrinsics, k, _ = plain.physical(fit.x)
    x = model.coordinates(intrinsics, k, np.array([0.01, -0.02]))
    stack = stacked(model, data, x, fit.poses)
    h = 1e-5
    for j in range(model.dimension):
        step = h * np.eye(model.dimension)[j]
        up, down = (stacked(model, data, x + s, fit.poses).residuals for s in (step, -step))
        np.testing.assert_allclose((down - up) / (2 * h), stack.by_lens[..., j], atol=2e-5)
    for j in range(6):
        move = np.tile(h * np.eye(6)[j], (2, 1))
        up, down = (stacked(model, data, x, fit.poses.moved(m)).residuals for m in (move, -move))
        np.testing.assert_allclose((down - up) / (2 * h), stack.by_pose[..., j], atol=2e-4)


def test_a_body_of_points_is_found_from_nothing() -> None:
    """Truth: noise-free pixels of a three-dimensional target give their camera back."""
    rng = np.random.default_rng(3)
    body = rng.uniform(-100, 100, (30, 3))
    world, pixels = boards.pictures(rng, n_views=4, k=(-0.1, 0, 0, 0, 0), sigma=0.0, target=body)
    data = boards.observed(world, pixels)
    model = boards.radial(1)
    fit = boards.fitted(model, data)
    # Pixels are of single precision: about 2e-5 px.
    assert rms(data, fit.sum_of_squares) < 1e-4
    found = model.report(fit.x, data.diagonal)
    np.testing.assert_allclose(found, [*boards.FOCAL, *boards.CENTRE, -0.1], rtol=1e-4)


def test_views_may_lack_points() -> None:
    """Truth: leaving rows out by weight and leaving them out of the table are the same."""
    world, pixels = boards.pictures(np.random.default_rng(4), n_views=4)
    v, n = pixels.shape[:2]
    which, view = np.tile(np.arange(n), v), np.repeat(np.arange(v), n)
    kept = np.random.default_rng(5).random(v * n) < 0.7
    flat = pixels.reshape(-1, 2)
    weight = np.where(kept[:, None], 1.0, 1e-9) * np.ones(2)
    few = Observations.of(world, which[kept], flat[kept], view[kept], boards.SIZE)
    all_of_them = Observations.of(world, which, flat, view, boards.SIZE, weight)
    model = boards.radial(1)
    fits = [boards.fitted(model, data) for data in (few, all_of_them)]
    np.testing.assert_allclose(fits[0].x, fits[1].x, rtol=1e-6, atol=1e-6)
    swapped = few.only(np.array([2, 0]))
    poses = fits[0].poses.only(np.array([2, 0]))
    assert cost(stacked(model, swapped, fits[0].x, poses)) < fits[0].sum_of_squares


def test_no_start_is_found_where_there_is_none() -> None:
    """Negative control: pixels that no camera makes end in a poor fit, not in an exception."""
    world = boards.board()
    pixels = np.random.default_rng(6).uniform(0, 400, (3, len(world), 2))
    data = boards.observed(world, pixels)
    fit = start_fit(
        LensModel("m", lens_named("radial", order=0, tangential=False), boards.SIZE), data
    )
    assert rms(data, fit.sum_of_squares) > 50 or not np.isfinite(fit.sum_of_squares)


def test_a_step_may_lead_out_of_all_bounds() -> None:
    """Coordinates that overflow: no warning, no exception, and a higher cost."""
    world, pixels = boards.pictures(np.random.default_rng(7), n_views=3)
    data = boards.observed(world, pixels)
    for name in ("eucm", "double-sphere", "division", "radial"):
        model = LensModel(name, lens_named(name), boards.SIZE)
        fit = start_fit(model, data)
        for far in (-1e3, 1e3, 1e6):
            assert cost(stacked(model, data, fit.x + far, fit.poses)) > fit.sum_of_squares
