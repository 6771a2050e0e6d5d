"""What places of the image look at: points before the camera whose predictions can be compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import BoolArray

COLUMNS, ROWS = 33, 25  # of a grid over the image


@dataclass(frozen=True, eq=False)
class Sights:
    """Places of the image, and a point of the world that the chosen model sees at each.

    Attributes
    ----------
    pixels : Array
        As recorded, ``(n, 2)``, px.
    world : Array
        At the median distance of the calibration points, ``(n, 3)``; nan where nothing appears.
    found : ndarray of bool
        Where something appears, by a mapping that is monotone up to there, ``(n,)``.
    inside : ndarray of bool
        Where points were calibrated with, ``(n,)``; elsewhere the model is extrapolated.
    """

    pixels: Array
    world: Array
    found: BoolArray
    inside: BoolArray


def image_grid(camera: CalibratedCamera, columns: int = COLUMNS, rows: int = ROWS) -> Array:
    """Pixels over the image, ``(rows * columns, 2)``, px; over the points where it has no size."""
    return spread(*extent(camera), columns, rows)


def spread(low: Array, high: Array, columns: int, rows: int) -> Array:
    """Pixels over a rectangle from corner to corner, ``(rows * columns, 2)``, px."""
    r, c = np.meshgrid(np.linspace(low[0], high[0], columns), np.linspace(low[1], high[1], rows))
    return np.column_stack([r.ravel(), c.ravel()])


def extent(camera: CalibratedCamera) -> tuple[Array, Array]:
    """Centres of the first and the last pixel, ``(2,)`` each, px."""
    if camera.size is None:
        return camera.pixel_hull.min(axis=0), camera.pixel_hull.max(axis=0)
    return np.zeros(2), np.array(camera.size) - 1.0


def sights(camera: CalibratedCamera, pixels: Array) -> Sights:
    """Find what recorded pixels ``(n, 2)`` look at by the chosen model's mean."""
    member, own = camera.chosen, camera.recorded(pixels)
    solved = member.continued(own)
    sight = member.rays(member.parameters.mean[None], own[None], solved.scaled)
    found = (solved.count > 0) & sight.found[0]
    world = sight.origin[0] + camera.distance * sight.direction[0]
    world[~found] = np.nan
    return Sights(pixels, world, found, found & solved.inside)
