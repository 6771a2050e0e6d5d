"""Simulated views of a chessboard, through OpenCV's projector: the truth of the tests."""

from __future__ import annotations

import cv2
import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import Fit, carried, least_squares
from bayescal.calibration.fitting.start import start_fit
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.cameras.lenses import lens_named

SIZE = (640.0, 480.0)
FOCAL, CENTRE = (530.0, 531.0), (328.0, 235.0)


def board(columns: int = 9, rows: int = 6, square: float = 25.0) -> Array:
    """Corners of a chessboard, ``(n, 3)``, mm about its centre."""
    points = [[i, j, 0] for j in range(rows) for i in range(columns)]
    found = np.array(points, dtype=np.float64) * square
    return found - found.mean(axis=0)


def pictures(
    rng: np.random.Generator,
    n_views: int = 13,
    k: tuple[float, ...] = (-0.28, 0.07, 0.0, 0.0, 0.0),
    sigma: float = 0.2,
    target: Array | None = None,
) -> tuple[Array, Array]:
    """Target and pixels, ``(n_views, n, 2)``, that lie in the image; noise of `sigma` px.

    Both are numbers that single precision holds, which is what OpenCV calibrates with.
    """
    world = board() if target is None else target
    views: list[Array] = []
    while len(views) < n_views:
        turn = rng.normal(0, [0.4, 0.4, 0.3])
        depth = rng.uniform(300, 600)
        at = np.array([rng.uniform(-0.25, 0.25) * depth, rng.uniform(-0.2, 0.2) * depth, depth])
        found = seen(world, turn, at, k)
        if (found > 3).all() and (found < np.array(SIZE) - 4).all():
            views.append(found + rng.normal(0, sigma, found.shape))
    return world, np.array(views).astype(np.float32).astype(np.float64)


def seen(world: Array, turn: Array, at: Array, k: tuple[float, ...] = (0.0,) * 5) -> Array:
    """Pixels of a target by OpenCV's projector, ``(n, 2)``, without noise."""
    matrix = np.array([[FOCAL[0], 0, CENTRE[0]], [0, FOCAL[1], CENTRE[1]], [0, 0, 1.0]])
    return np.asarray(cv2.projectPoints(world, turn, at, matrix, np.array(k))[0].reshape(-1, 2))


def observed(world: Array, pixels: Array) -> Observations:
    """Observations of pictures."""
    v, n = pixels.shape[:2]
    which, view = np.tile(np.arange(n), v), np.repeat(np.arange(v), n)
    return Observations.of(world, which, pixels.reshape(-1, 2), view, SIZE)


def radial(order: int, *, tangential: bool = False, bow: bool = False) -> LensModel:
    """Radial lens model of an order."""
    lens = lens_named("radial", order=order, tangential=tangential)
    return LensModel(f"radial {order}", lens, SIZE, bow=bow)


def fitted(model: LensModel, data: Observations) -> Fit:
    """Least squares from nothing, by way of the lens without distortion."""
    plain = radial(0)
    first = start_fit(plain, data)
    return least_squares(model, data, carried(plain, first.x, model), first.poses)
