"""Boards seen by cameras with known lenses, exact or with the errors that real boards have.

The errors are not of the kinds that the program's error models are made of: correlated noise is
a random smooth field over the *image* of a view, offsets are a random polynomial over the board
with uniform scatter, the board is bent about an oblique axis, the lens has a sinusoidal ripple.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.lenses import Lens, lens_named
from bayescal.cameras.pose import rotations
from bayescal.points.views.views import Views

WIDTH, HEIGHT = 1280, 960
COLUMNS, ROWS, SQUARE = 9, 6, 30.0
RADIUS = float(np.hypot(WIDTH, HEIGHT)) / 2


@dataclass(frozen=True)
class Errors:
    """What is wrong with a board and its pictures, beside white noise of `sigma` px.

    Attributes
    ----------
    sigma, shared, offsets, bow, ripple : float
        Standard deviations in px (of noise, of noise that neighbours share, of the board's
        points), size of the bend in mm, of the lens's ripple in px.
    """

    sigma: float = 0.1
    shared: float = 0.0
    offsets: float = 0.0
    bow: float = 0.0
    ripple: float = 0.0


@dataclass(frozen=True)
class Truth:
    """A lens: displacements at the image's corner in px of k1, k2, ... and of p1, p2."""

    radial: tuple[float, ...]
    tangential: tuple[float, float] | None

    @property
    def key(self) -> str:
        """As `bayescal.calibrate` names it."""
        order = len(self.radial)
        return "pinhole" if not order else f"radial {order}{' + p' * (self.tangential is not None)}"

    def lens(self, focal: float) -> tuple[Lens, Array]:
        """Give the lens and its coefficients at a focal length, px."""
        lens = lens_named("radial", order=len(self.radial), tangential=self.tangential is not None)
        values = dict(zip([n for n in lens.names if n[0] == "k"], self.radial, strict=True))
        if self.tangential is not None:
            values |= {"p1": self.tangential[0], "p2": self.tangential[1]}
        k = [
            values[n] * focal ** (m - 1) / RADIUS**m
            for n, m in zip(lens.names, lens.powers, strict=True)
        ]
        return lens, np.array(k)


def some_lens(rng: np.random.Generator) -> Truth:
    """Draw a typical lens of order 0 to 3, with or without tangential terms."""
    order = int(rng.integers(4))
    sizes = [np.exp(rng.uniform(*np.log(b))) for b in ((10, 150), (3, 60), (3, 30))]
    signs = rng.choice([-1.0, 1.0], 3)
    radial = tuple(float(s * z) for s, z in zip(signs, sizes, strict=True))[:order]
    if not order or rng.random() < 0.5:
        return Truth(radial, None)
    first, second = np.exp(rng.uniform(np.log(0.5), np.log(8), 2)) * rng.choice([-1, 1], 2)
    return Truth(radial, (float(first), float(second)))


def some_intrinsics(rng: np.random.Generator) -> Array:
    """Draw fx, fy, cx, cy, px."""
    focal = float(WIDTH * np.exp(rng.normal(0, 0.15)))
    return np.array(
        [focal, focal * (1 + 0.002 * rng.standard_normal()), WIDTH / 2 + 12, HEIGHT / 2 - 9]
    )


def views_of(
    truth: Truth,
    errors: Errors,
    n_views: int,
    rng: np.random.Generator,
    intrinsics: Array | None = None,
) -> tuple[Views, Array]:
    """Photograph a chessboard so that it lies within the image; with fx, fy, cx, cy."""
    intrinsics = some_intrinsics(rng) if intrinsics is None else intrinsics
    focal = float(intrinsics[0])
    lens, k = truth.lens(focal)
    flat = board()
    bent = with_errors(flat, errors, rng)
    wave = rng.uniform(0, 2 * np.pi, 2)
    pictures: list[Array] = []
    while len(pictures) < n_views:
        turn = rotations(rng.normal(0, [0.35, 0.35, 0.5]))
        depth = focal / WIDTH * rng.uniform(350, 800)
        at = np.array([rng.uniform(-0.35, 0.35), rng.uniform(-0.27, 0.27), 1.0]) * depth
        at[:2] *= WIDTH / focal
        rays = bent @ turn.T + at
        if not lens.seen(rays, k).all():
            continue
        pixels = intrinsics[2:] + intrinsics[:2] * lens.distort(rays, k)
        if (pixels < 5).any() or (pixels > [WIDTH - 6, HEIGHT - 6]).any():
            continue
        pixels = pixels + errors.ripple * np.sin(2 * np.pi * pixels / 400 + wave) * np.sqrt(2)
        pixels = pixels + errors.shared * smooth_field(pixels, rng)
        pictures.append(pixels + errors.sigma * rng.standard_normal(pixels.shape))
    views = Views.from_arrays([flat] * n_views, pictures, width=WIDTH, height=HEIGHT)
    return views, intrinsics


def board() -> Array:
    """Corners of the chessboard, ``(n, 3)``, mm."""
    x, y = np.meshgrid(np.arange(COLUMNS) * SQUARE, np.arange(ROWS) * SQUARE)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])


def with_errors(flat: Array, errors: Errors, rng: np.random.Generator) -> Array:
    """Centre the board as it really is: bent about an oblique axis, its points off."""
    centred = flat - flat.mean(axis=0)
    u, v = (centred[:, :2] / np.abs(centred[:, :2]).max(axis=0)).T
    along = np.cos(0.5) * u + np.sin(0.5) * v
    centred[:, 2] += errors.bow * (1 - np.cosh(1.5 * along) / np.cosh(1.5))
    if errors.offsets:
        terms = np.stack([u * v, u**2, v**2, u**3, v**3, u**2 * v, u * v**2])
        for axis in (0, 1):
            wavy = rng.standard_normal(len(terms)) @ terms
            rough = rng.uniform(-1, 1, len(u)) * np.sqrt(3)
            mixed = wavy / wavy.std() + rough
            # A typical distance is 575 width / focal mm, so that 1 px is 575 / WIDTH mm.
            centred[:, axis] += errors.offsets * mixed / np.sqrt(2) * 575 / WIDTH
    return centred


def smooth_field(pixels: Array, rng: np.random.Generator) -> Array:
    """Draw a random field of sd 1 over the image: ten waves of 100 to 400 px, ``(n, 2)``."""
    out = np.zeros_like(pixels)
    for axis in (0, 1):
        for _ in range(10):
            direction, length = rng.uniform(0, 2 * np.pi), rng.uniform(100, 400)
            number = 2 * np.pi / length * np.array([np.cos(direction), np.sin(direction)])
            out[:, axis] += rng.standard_normal() * np.cos(pixels @ number + rng.uniform(0, 7))
    return out * np.sqrt(2 / 10)
