"""Boards seen by cameras drawn from the prior of `calibrate`, restated from docs/method.md.

The program's prior of a pose is uniform in rotation and position, which no simulation can draw
views of a board from. Here poses are drawn from another density g, given the lens; the analysis
is told of it by the weight g of its draws (`log_pose_density`). A set of which a measured point
falls outside the image is drawn anew as a whole, lens, noise and all: what is selected by the
data alone leaves posteriors what they are, as does a lens that can't see some point, which the
likelihood excludes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.fitting.stacking import Poses
from bayescal.calibration.model.error_model import Geometry
from bayescal.calibration.model.observations import Observations
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotation_vectors, rotations
from bayescal.points.views.views import Views
from scripts.validation.simulated_boards import HEIGHT, RADIUS, SQUARE, WIDTH, board

N_VIEWS = 6
TAUS = {"radial": (1e-3, 0.5), "tangential": (1e-4, 0.05), "bow": (1e-4, 0.03)}
SIGMA = (0.01, 10.0)
# Of g: rotation vector, rad; ln of the distance over f / width diagonals; direction, px / width.
TURN_SD = np.array([0.35, 0.35, 0.5])
DISTANCE, DISTANCE_SD = np.log(2.2), 0.2
ASIDE_SD = np.array([0.1, 0.07])


@dataclass(frozen=True, eq=False)
class Case:
    """A set of views, and what it was made from.

    Attributes
    ----------
    truth : dict
        Parameters by the names that the program reports.
    """

    views: Views
    key: str
    truth: dict[str, float]


def lens_of(key: str) -> tuple[str, int, bool]:
    """Name, order and tangential switch of a lens as tables call it."""
    name, _, order = key.removesuffix(" + p").partition(" ")
    return ("radial" if name == "pinhole" else name), int(order or 0), key.endswith(" + p")


def drawn_cases(keys: tuple[str, ...], rng: np.random.Generator, *, exact: bool) -> Iterator[Case]:
    """Draw lenses, noise and views, those of which all lies in the image.

    Parameters
    ----------
    keys : tuple of str
        Lenses, equally probable.
    exact : bool
        Whether noise is independent and the board exact; else the error model is drawn too.
    """
    while True:
        found = _drawn(keys[int(rng.integers(len(keys)))], rng, exact)
        if found is not None:
            yield found


def _drawn(key: str, rng: np.random.Generator, exact: bool) -> Case | None:
    name, order, tangential = lens_of(key)
    options = {"tangential": tangential} if name == "radial" else {}
    lens = lens_named(name, order=order, **options)
    fx = WIDTH * np.exp(rng.normal(0, 0.7))
    fy = fx * np.exp(rng.normal(0, 0.05))
    centre = np.array([WIDTH - 1, HEIGHT - 1]) / 2 + rng.normal(0, 0.1 * WIDTH, 2)
    present = [*dict.fromkeys(lens.groups), *(() if exact else ("bow",))]
    taus = {group: log_uniform(rng, *TAUS[group]) for group in present}
    sizes = np.array([rng.normal(0, taus[g] * WIDTH) for g in lens.groups])
    powers = np.array(lens.powers)
    k = sizes * fx ** (powers - 1.0) / RADIUS**powers
    sigma = log_uniform(rng, *SIGMA)
    truth = dict(zip(("fx", "fy", "cx", "cy"), (fx, fy, *centre), strict=True))
    truth |= dict(zip(lens.names, k, strict=True))
    flat = board()
    middle = flat.mean(axis=0)
    diagonal = float(np.linalg.norm(np.ptp(flat, axis=0)))
    points = (flat - middle) / diagonal
    if not exact:
        bow = rng.normal(0, taus["bow"], 2)
        truth |= {"bow_x": bow[0] * diagonal, "bow_y": bow[1] * diagonal}
        scaled = points[:, :2] / np.abs(points[:, :2]).max(axis=0)
        points = points + np.outer((1 - scaled**2) @ bow, [0, 0, 1])
    poses = drawn_poses(fx, rng)

    def seen_at(board_points: Array) -> Array | None:
        rays = board_points @ np.swapaxes(poses.rotation, 1, 2) + poses.translation[:, None]
        if not lens.seen(rays.reshape(-1, 3), k).all():
            return None
        return np.asarray(centre + [fx, fy] * lens.distort(rays, k))

    pixels = seen_at(points)
    if pixels is None or outside(pixels):
        return None
    if exact:
        noise = sigma * rng.standard_normal(pixels.shape)
    else:
        model = drawn_errors(rng)
        # What 1 px is on the board, as the program defines it, but by the exact pixels.
        unit = Geometry(Observations.from_views(photographed(pixels), (WIDTH, HEIGHT))).pixel
        noise = sigma * shared_noise(points, SQUARE / diagonal, model, pixels.shape, rng)
        moved = seen_at(points + sigma * unit * offsets(points, model, rng))
        if moved is None:
            return None
        pixels = moved
    pixels = pixels + noise
    if outside(pixels):
        return None
    truth |= {"sigma": sigma, **{f"tau {group}": tau for group, tau in taus.items()}}
    return Case(photographed(pixels), key, {name: float(value) for name, value in truth.items()})


def outside(pixels: Array) -> bool:
    """Whether some point is not in the image."""
    return bool((pixels < 0).any() or (pixels > [WIDTH - 1, HEIGHT - 1]).any())


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn_poses(focal: float, rng: np.random.Generator) -> Poses:
    """Draw the poses of a set's views from g."""
    turn = rotations(rng.normal(0, TURN_SD, (N_VIEWS, 3)))
    distance = focal / WIDTH * np.exp(rng.normal(DISTANCE, DISTANCE_SD, N_VIEWS))
    aside = rng.normal(0, ASIDE_SD, (N_VIEWS, 2)) * distance[:, None] * WIDTH / focal
    return Poses(turn, np.column_stack([aside, distance]))


def log_pose_density(focal: Array, poses: Poses) -> Array:
    """Log of g by the uniform measures of rotation and position, over all views, ``(...,)``.

    Parameters
    ----------
    focal : Array
        ``(...,)``, px.
    poses : Poses
        Of the same leading axes.
    """
    x, y, z = np.moveaxis(poses.translation, -1, 0)
    front, z = (z > 0).all(axis=-1), np.maximum(z, 1e-9)
    distant = (np.log(z * WIDTH / focal[..., None]) - DISTANCE) / DISTANCE_SD
    scale = focal[..., None] / (WIDTH * z)
    aside = np.stack([x * scale, y * scale], axis=-1) / ASIDE_SD
    turn = rotation_vectors(poses.rotation)
    angle = np.maximum(np.linalg.norm(turn, axis=-1), 1e-9)
    each = -0.5 * (distant**2 + (aside**2).sum(axis=-1) + ((turn / TURN_SD) ** 2).sum(axis=-1))
    # Rotation vectors have the uniform measure (sin(a / 2) / (a / 2))^2 times their own.
    each += 2 * np.log(scale) - np.log(z) - 2 * np.log(np.sin(angle / 2) / (angle / 2))
    return np.where(front, each.sum(axis=-1), -np.inf)


def photographed(pixels: Array) -> Views:
    """Make views of the board whose pixels are those, ``(n_views, n, 2)``."""
    return Views.from_arrays([board()] * len(pixels), list(pixels), width=WIDTH, height=HEIGHT)


def drawn_errors(rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Draw correlation, its length in spacings, rough and smooth offsets: each there or not."""
    there = rng.random(3) < 0.5
    correlated, rough, smooth = (
        2.0 ** rng.integers(low, high + 1) for low, high in ((-3, 7), (-4, 3), (-4, 3))
    )
    length = 2.0 ** rng.integers(-1, 6)
    return correlated * there[0], length, rough * there[1], smooth * there[2]


def shared_noise(
    points: Array,
    spacing: float,
    model: tuple[float, float, float, float],
    shape: tuple[int, ...],
    rng: np.random.Generator,
) -> Array:
    """Draw noise of variance 1 + rho within each view, ``shape``."""
    gap = np.linalg.norm(points[:, None] - points[None], axis=-1)
    covariance = np.eye(len(points)) + model[0] * np.exp(-gap / (model[1] * spacing))
    return np.asarray(np.linalg.cholesky(covariance) @ rng.standard_normal(shape))


def offsets(
    points: Array, model: tuple[float, float, float, float], rng: np.random.Generator
) -> Array:
    """Draw how far points of the board are off, px of sigma, ``(n, 3)``."""
    _, _, rough, smooth = model
    gap = np.linalg.norm(points[:, None] - points[None], axis=-1)
    kernel = np.exp(-0.5 * (gap / 0.25) ** 2)
    values, vectors = np.linalg.eigh(kernel)
    root = vectors * np.sqrt(np.maximum(values, 0))
    rough_part = rough * rng.standard_normal(points.shape) * [1, 1, 0]
    return np.asarray(rough_part + smooth * (root @ rng.standard_normal(points.shape)))
