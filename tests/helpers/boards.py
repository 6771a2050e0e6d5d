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


def wide_pictures(
    rng: np.random.Generator, n_views: int = 12, k: tuple[float, ...] = (0.05, -0.01, 0.003, -0.001)
) -> list[tuple[Array, Array]]:
    """Targets and pixels of a fisheye of 150 degrees by OpenCV's model, noise of 0.2 px.

    Of a view those points that the image holds.
    """
    matrix = np.array([[210.0, 0, 320], [0, 210.5, 240], [0, 0, 1]])
    world, found = board(11, 7, 40.0), []
    while len(found) < n_views:
        away, about = rng.uniform(0, 1.2), rng.uniform(0, 2 * np.pi)
        ahead = np.array([np.sin(away) * np.cos(about), np.sin(away) * np.sin(about), np.cos(away)])
        across = np.cross([0, 1, 0], ahead) / np.linalg.norm(np.cross([0, 1, 0], ahead))
        facing = np.stack([across, np.cross(ahead, across), ahead], axis=1)
        turn, _ = cv2.Rodrigues(facing @ cv2.Rodrigues(rng.normal(0, 0.4, 3))[0])
        at = rng.uniform(200, 500) * ahead
        if (world @ cv2.Rodrigues(turn)[0].T + at)[:, 2].min() < 20:
            continue
        pixels = cv2.fisheye.projectPoints(world[None], turn, at, matrix, np.array(k))[0][0]
        inside = ((pixels > 0) & (pixels < np.array(SIZE) - 1)).all(axis=1)
        if inside.sum() >= 40:
            found.append((world[inside], pixels[inside] + rng.normal(0, 0.2, (inside.sum(), 2))))
    return found
