r"""How projections of lenses differ, and how sure they are, once the poses' share is taken out.

Two calibrations of one camera place its frame differently: what one calls a turn the other
absorbs in its lens. So predictions are compared after the turn (and, at a finite range, the
shift) that brings them together over the observed points; dkogan/mrcal calls it the implied
transformation. For small differences this is linear: with J the derivative of a pixel by the
lens at a fixed direction and M that by the turn, a step s of the lens moves the prediction by

    T s = (J - M (M_o^+ J_o)) s,      o the observed points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from bayescal.arrays import Array
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.cameras.pose import cross_matrices, rotations
from bayescal.inference.t_mixture import cholesky

SAMPLE = 400  # observed points that fix the turn
COLUMNS, ROWS = 25, 19  # of the grid over the image
TURNS = 20
DRAWS = 1000  # of a lens, for how far another may lie from it
PROBABILITY = 0.95


@dataclass(frozen=True, eq=False)
class View:
    """A lens at work: rays of pixels, and how pixels follow rays and lens.

    Attributes
    ----------
    x : Array
        Coordinates of the lens, ``(dimension,)``; those of bow are passed over.
    """

    model: LensModel
    x: Array

    def rays(self, pixels: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Give unit rays ``(n, 3)`` and whether each was found, ``(n,)``."""
        key = pixels.tobytes()  # the same pixels are asked for with every other lens
        if key not in self._known:
            self._known[key] = self._found(pixels)
        return self._known[key]

    @cached_property
    def _known(self) -> dict[bytes, tuple[Array, NDArray[np.bool_]]]:
        return {}

    def _found(self, pixels: Array) -> tuple[Array, NDArray[np.bool_]]:
        intrinsics, k, _ = self.model.physical(self.x)
        found = self.model.lens.undistort((pixels - intrinsics[2:]) / intrinsics[:2], k)
        return found.rays, found.found

    def pixels(self, points: Array) -> Array:
        """Pixels of points in the camera's frame, ``(n, 2)``; NaN where not seen."""
        intrinsics, k, _ = self.model.physical(self.x)
        with np.errstate(all="ignore"):
            plane = self.model.lens.distort(points, k)
            seen = self.model.lens.seen(points, k)
        return np.where(seen[:, None], intrinsics[2:] + intrinsics[:2] * plane, np.nan)

    def slopes(self, points: Array, *, shift: bool) -> tuple[Array, Array]:
        """Differentiate by the lens ``(n, 2, d)`` and by turn and shift, ``(n, 2, 3 or 6)``."""
        intrinsics, k, _ = self.model.physical(self.x)
        found = self.model.lens.jacobian(points, k)
        by_point = intrinsics[:2, None] * found.by_ray
        by_k = intrinsics[:2, None] * found.by_coefficient
        stretch = intrinsics[:2] * found.plane
        by_lens = self.model.by_coordinate(self.x, stretch, np.ones_like(stretch), by_k)
        by_move = -by_point @ cross_matrices(points)
        return by_lens, np.concatenate([by_move, by_point], axis=2) if shift else by_move


def observed_sample(data: Observations) -> Array:
    """Take some of the observed pixels, evenly through the views, ``(n, 2)``."""
    pixels = data.pixels[data.seen]
    return np.asarray(pixels[:: max(1, math.ceil(len(pixels) / SAMPLE))])


def image_grid(size: tuple[float, float], columns: int = COLUMNS, rows: int = ROWS) -> Array:
    """Pixels over the whole image, its edges included, ``(rows * columns, 2)``."""
    width, height = size
    r, c = np.meshgrid(np.linspace(0, width - 1, columns), np.linspace(0, height - 1, rows))
    return np.column_stack([r.ravel(), c.ravel()])


def response(
    view: View, pixels: Array, sample: Array, depth: float | None, seen_by: View | None = None
) -> Array:
    """T at pixels, ``(n, 2, d)``; NaN where the lens sees nothing.

    Parameters
    ----------
    pixels, sample : Array
        Where it is wanted, and what the poses hold to, ``(n, 2)`` and ``(m, 2)``.
    depth : float or None
        Distance of the points; None for infinity, where no shift is seen.
    seen_by : View, optional
        Whose pixels they are; the view's own by default.
    """
    scale, shift = (1.0, False) if depth is None else (depth, True)
    pixels_of = view if seen_by is None else seen_by
    rays, found = pixels_of.rays(sample)
    by_lens, by_move = view.slopes(rays[found] * scale, shift=shift)
    d = by_lens.shape[2]
    absorbed = np.linalg.lstsq(by_move.reshape(-1, by_move.shape[2]), by_lens.reshape(-1, d))[0]
    out = np.full((len(pixels), 2, d), np.nan)
    rays, found = pixels_of.rays(pixels)
    by_lens, by_move = view.slopes(rays[found] * scale, shift=shift)
    out[found] = by_lens - by_move @ absorbed
    return out


def deviation(maps: Array, covariance: Array) -> Array:
    """Give the standard deviation at pixels, root mean square of r and c, ``(n,)``, px."""
    variance = np.einsum("nai,ij,naj->n", maps, covariance, maps)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0) / 2))


def difference(one: View, other: View, pixels: Array, sample: Array, depth: float | None) -> Array:
    """Prediction of the other less that of the one, ``(n, 2)``, px; NaN where one sees nothing.

    Parameters
    ----------
    pixels, sample : Array
        Where it is wanted, and what the poses hold to, px.
    depth : float or None
        Distance of the points; None for infinity.
    """
    scale, shift = (1.0, False) if depth is None else (depth, True)
    rays, found = one.rays(sample)
    points, aim = rays[found] * scale, sample[found]
    turn, move = np.eye(3), np.zeros(3)
    for _ in range(TURNS):
        moved = points @ turn.T + move
        miss = aim - other.pixels(moved)
        use = np.isfinite(miss).all(axis=1)
        if use.sum() < 4:
            return np.full((len(pixels), 2), np.nan)
        _, slope = other.slopes(moved[use], shift=shift)
        step = np.linalg.lstsq(slope.reshape(-1, slope.shape[2]), miss[use].ravel())[0]
        spin = rotations(step[:3])
        # The turn is about the camera: what was shifted before turns along.
        turn, move = spin @ turn, spin @ move + (step[3:] if shift else 0.0)
        if np.abs(step).max() < 1e-10:
            break
    rays, found = one.rays(pixels)
    out = np.full((len(pixels), 2), np.nan)
    out[found] = other.pixels(rays[found] * scale @ turn.T + move) - pixels[found]
    return out


def distances_drawn(
    one: View,
    other: View,
    covariance: Array,
    pixels: Array,
    sample: Array,
    rng: np.random.Generator,
) -> Array:
    """Draws of the distance of the other lens's predictions from the one's, ``(DRAWS, n)``, px.

    At each draw of the one lens the other is fitted to what it predicts at the sample: of two
    lenses fitted to the same points that is how their difference varies, their shared noise left
    out. Both lenses are linear about where they are, at infinity; NaN where one sees nothing.

    Parameters
    ----------
    covariance : Array
        Of the one lens's coordinates, ``(d, d)``.
    pixels, sample : Array
        Where it is wanted, and what the other lens and the poses hold to, px.
    """
    apart = difference(one, other, pixels, sample, None)
    held, holding = (response(view, sample, sample, None) for view in (one, other))
    seen = np.isfinite(held).all(axis=(1, 2)) & np.isfinite(holding).all(axis=(1, 2))
    by_other, by_one = (maps[seen].reshape(-1, maps.shape[2]) for maps in (holding, held))
    following = np.linalg.lstsq(by_other, by_one)[0]
    moves = response(other, pixels, sample, None) @ following - response(one, pixels, sample, None)
    steps = rng.standard_normal((DRAWS, len(covariance))) @ cholesky(covariance).T
    drawn = apart + np.einsum("nad,sd->sna", moves, steps, optimize=True)
    return np.asarray(np.hypot(drawn[..., 0], drawn[..., 1]))


def at_most(distances: Array) -> float | None:
    """Give the 95 % quantile of draws' largest distance, px; None as of `largest`."""
    known = np.isfinite(distances).all(axis=0)
    if not known.size or known.mean() <= 0.5:
        return None
    return float(np.quantile(distances[:, known].max(axis=1), PROBABILITY))


def largest(differences: Array) -> float | None:
    """Largest distance, px; None where half the places or more can't be compared."""
    size = np.hypot(differences[:, 0], differences[:, 1])
    known = np.isfinite(size)
    return float(size[known].max()) if len(size) and known.mean() > 0.5 else None


def covered(pixels: Array, data: Observations) -> NDArray[np.bool_]:
    """Whether pixels lie within the hull of the observed points, ``(n,)``."""
    try:
        hull = Delaunay(data.pixels[data.seen])
    except QhullError:
        return np.zeros(len(pixels), dtype=bool)
    return np.asarray(hull.find_simplex(pixels) >= 0)
