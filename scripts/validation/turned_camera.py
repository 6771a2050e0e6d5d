"""A camera like that of Tsai's non-coplanar set, and the points it sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

import bayescal as bc
from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotations
from bayescal.points.camera import StatedCamera
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import Setup

# Five planes of 60 points; a long lens turned by 30 degrees.
TURNED: Mapping[str, Sequence[float]] = {
    "focal": (3043.0, 3042.0),
    "centre": (300.0, 200.0),
    "rotation": (0.5235, 0.0175, 0.035),
    "position": (138.0, -926.0, -1768.0),
    "k": (3.0,),
}


def projected(
    world: Array,
    focal: Sequence[float],
    centre: Sequence[float],
    rotation: Sequence[float],
    position: Sequence[float],
    k: Sequence[float] = (),
) -> Array:
    """Pixels of world points, ``(n, 2)``."""
    camera = Camera(lens_named("radial", order=len(k), tangential=False))
    turn = np.array(rotation)
    translation = -rotations(turn) @ np.array(position)
    return camera.project(np.array([*focal, *centre]), np.array(k), turn, translation, world)[0]


def turned_points(
    noise: float,
    seed: int = 5,
    truth: Mapping[str, Sequence[float]] = TURNED,
    pixels: Callable[..., Array] = projected,
) -> Correspondences:
    """300 points that a turned camera sees, with noise of so many px."""
    x, y, z = np.meshgrid(np.arange(10.0, 210, 20), np.arange(10.0, 250, 40), np.arange(5) * 40.0)
    world = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    exact = pixels(world, **truth)
    noisy = exact + np.random.default_rng(seed).normal(0, noise, exact.shape)
    camera = StatedCamera(position_sd=(50.0, 50.0, 50.0), orientation=(30.0, 0.0, 0.0))
    setup = Setup(position=(120.0, -900.0, -1800.0), width=576.0, height=384.0, camera=camera)
    return bc.Correspondences.from_arrays(world, noisy, setup=setup)
