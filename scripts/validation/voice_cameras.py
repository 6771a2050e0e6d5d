"""Simulated cameras whose truth is known, of the kinds that a verdict should survive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

import bayescal as bc
from bayescal.arrays import Array
from bayescal.polynomials.basis import legendre_design

SIZE = np.array([1920.0, 1080.0])  # px
FOCAL = 1400.0  # px
N = 60


@dataclass(frozen=True, eq=False)
class Camera:
    """Points of a camera, and the order of each axis that describes them.

    Attributes
    ----------
    points : Correspondences
    order : dict of str to int
        The true order of an axis; 0 where no polynomial of one coordinate is true.
    curve : dict of str to Array
        True amplitudes of an axis where it has an order, px.
    settings : dict
        Options of the comparison.
    """

    points: bc.Correspondences
    order: dict[str, int]
    curve: dict[str, Array]
    settings: dict[str, object]


@dataclass(frozen=True)
class Truth:
    """What a separable camera is made with.

    Attributes
    ----------
    order : int
        Of both axes.
    sigma : float
        Noise, px.
    bend : float
        sd of every amplitude from order 2 on, px.
    """

    order: int
    sigma: float = 0.5
    bend: float = 3.0


def world(rng: np.random.Generator, n: int = N) -> Array:
    """Points on six planes before a camera at the origin, ``(n, 3)``."""
    z = np.repeat(np.linspace(400, 900, 6), -(-n // 6))[:n]
    slopes = np.column_stack([rng.uniform(-0.6, 0.6, n), rng.uniform(-0.34, 0.34, n)])
    return np.column_stack([slopes * z[:, None], z])


def amplitudes(truth: Truth, axis: int, rng: np.random.Generator) -> Array:
    """Legendre amplitudes of an axis, ``(order + 1,)``, px."""
    bent = truth.bend * rng.standard_normal(max(truth.order - 1, 0))
    return np.concatenate([[SIZE[axis] / 2, FOCAL * (0.6, 0.34)[axis]], bent])


def separable(
    truth: Truth, rng: np.random.Generator, at: Array | None = None, **settings: object
) -> Camera:
    """Curves of one coordinate each, with Gaussian noise."""
    points = world(rng) if at is None else at
    pixels, curve = np.empty((len(points), 2)), {}
    for i, axis in enumerate("rc"):
        x = points[:, i] / points[:, 2]
        low, high = x.min(), x.max()
        s = (2 * x - low - high) / (high - low)
        curve[axis] = amplitudes(truth, i, rng)
        pixels[:, i] = legendre_design(s, truth.order) @ curve[axis]
    pixels += truth.sigma * rng.standard_normal(pixels.shape)
    order = dict.fromkeys("rc", truth.order)
    return Camera(made(points, pixels), order, curve, settings)


def made(points: Array, pixels: Array) -> bc.Correspondences:
    """Correspondences on the image, from a camera at the origin."""
    setup = bc.Setup(width=SIZE[0], height=SIZE[1])
    return bc.Correspondences.from_arrays(points, pixels, setup=setup)


def pinhole(rng: np.random.Generator, degrees: float = 0.0, off: float = 0.0) -> Camera:
    """Turn a pinhole by so many degrees, or put it `off` its position by a share of z."""
    points = world(rng)
    axis = rng.standard_normal(3)
    turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    step = rng.standard_normal(3)
    shift = off * 650 * step / np.linalg.norm(step)
    seen = (points - shift) @ turn.T
    slopes = seen[:, :2] / seen[:, 2:]
    bent = slopes * (1 - 0.05 * (slopes**2).sum(axis=1, keepdims=True))
    pixels = SIZE / 2 + FOCAL * bent + 0.5 * rng.standard_normal((len(points), 2))
    return Camera(made(points, pixels), {"r": 0, "c": 0}, {}, {})


def other_coordinate(rng: np.random.Generator) -> Camera:
    """Each pixel bends with the square of the other coordinate, 3 px at the edge."""
    camera = separable(Truth(2), rng)
    slopes = camera.points.world[:, :2] / camera.points.world[:, 2:]
    bent = camera.points.pixels + 3 * (slopes[:, ::-1] / [0.34, 0.6]) ** 2
    return Camera(made(camera.points.world, bent), {"r": 0, "c": 0}, {}, {})


def gross(rng: np.random.Generator) -> Camera:
    """Three readings in a hundred are anywhere within 50 px."""
    camera = separable(Truth(int(rng.integers(1, 4))), rng)
    bad = rng.random((len(camera.points), 2)) < 0.03
    pixels = camera.points.pixels + bad * rng.uniform(-50, 50, bad.shape)
    return replace(camera, points=made(camera.points.world, pixels))


def shared(rng: np.random.Generator) -> Camera:
    """Points of a plane share an error of four times the noise."""
    camera = separable(Truth(int(rng.integers(1, 4))), rng)
    _, plane = np.unique(camera.points.world[:, 2], return_inverse=True)
    pixels = camera.points.pixels + 2.0 * rng.standard_normal((plane.max() + 1, 2))[plane]
    return replace(camera, points=made(camera.points.world, pixels))


def whole(rng: np.random.Generator) -> Camera:
    """Round the readings to whole pixels; their noise is 0.2 px."""
    camera = separable(Truth(int(rng.integers(1, 4)), 0.2), rng)
    return replace(camera, points=made(camera.points.world, np.round(camera.points.pixels)))


def stacked(rng: np.random.Generator) -> Camera:
    """Ten images of the same points, whose world coordinates have errors worth 1 px."""
    once = world(rng)
    camera = separable(Truth(int(rng.integers(1, 4))), rng, np.tile(once, (10, 1)))
    wrong = np.tile(once + 0.5 * rng.standard_normal(once.shape), (10, 1))
    points = made(wrong, camera.points.pixels)
    return replace(camera, points=points, settings={"sigma": "replicates"})


KINDS: dict[str, Callable[[np.random.Generator], Camera]] = {
    "separable, order 1 to 3": lambda rng: separable(Truth(int(rng.integers(1, 4))), rng),
    "separable, 1500 points": lambda rng: separable(
        Truth(int(rng.integers(1, 4))), rng, world(rng, 1500)
    ),
    "pinhole turned by 10 degrees": lambda rng: pinhole(rng, degrees=10),
    "pinhole, position wrong by 5 %": lambda rng: pinhole(rng, off=0.05),
    "bends with the other coordinate": other_coordinate,
    "3 % gross errors": gross,
    "errors shared by planes": shared,
    "whole pixels": whole,
    "order 5, compared up to 3": lambda rng: separable(Truth(5), rng, orders=(1, 2, 3)),
    "0.05 px of noise, bends of 0.05 px": lambda rng: separable(Truth(3, 0.05, 0.05), rng),
    "0.05 px of noise, bends of 0.1 px": lambda rng: separable(Truth(3, 0.05, 0.1), rng),
    "0.05 px of noise, bends of 0.2 px": lambda rng: separable(Truth(3, 0.05, 0.2), rng),
    "sigma stated five times too small": lambda rng: separable(
        Truth(int(rng.integers(1, 4))), rng, sigma=0.1
    ),
    "ten images, world errors, replicates": stacked,
}
