r"""What makes residuals: noise that neighbours share within a view, and points that are off.

Given sigma, the noise of a view has covariance sigma^2 (I + rho exp(-d / l)) for r and for c,
d the distance of two points on the target. Points of the target are off by the same amounts in
all views: within its plane by rough sigma u each on its own, and smoothly over the target by
smooth sigma u with correlation exp(-d^2 / (2 s^2)), s = 0.25 diagonals, where u is the length on
the target that makes 1 px. All of it is Gaussian and scales with sigma, so that sigma can still
be integrated out in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from bayescal.arrays import Array, IntArray, frozen
from bayescal.calibration.model.observations import Observations

SMOOTH_LENGTH = 0.25  # diagonals
KEPT = 20_000_000  # numbers of covariances kept, 160 MB
LARGEST_TARGET = 400  # points: with more, offsets of single points are not tried


@dataclass(frozen=True, order=True)
class ErrorModel:
    """Levels of the parts, in units of sigma; 0 where there is none.

    Attributes
    ----------
    correlated : float
        Variance rho of what neighbours share within a view.
    length : float
        Its correlation length l, diagonals; 0 without it.
    rough, smooth : float
        Deviations of the target's points, px of sigma.
    """

    correlated: float = 0.0
    length: float = 0.0
    rough: float = 0.0
    smooth: float = 0.0

    @property
    def offsets(self) -> bool:
        """Whether points of the target are off."""
        return self.rough > 0 or self.smooth > 0


WHITE = ErrorModel()


@dataclass(frozen=True, eq=False)
class Shared:
    """Noise within each view: the inverse of its covariance over sigma^2.

    Attributes
    ----------
    inverse : Array or None
        ``(n_views, n_places, n_places)``; None for independent noise.
    log_dets : Array
        Log determinant of each view's covariance, over both axes, ``(n_views,)``; empty for
        independent noise.
    """

    inverse: Array | None
    log_dets: Array

    @property
    def log_det(self) -> float:
        """Log determinant over all views."""
        return float(self.log_dets.sum())

    def only(self, views: IntArray, places: IntArray) -> Shared:
        """Noise within some views, of places that hold all they see, ``(n_some, n_kept)``."""
        if self.inverse is None:
            return self
        rows, columns = places[:, :, None], places[:, None, :]
        inverse = self.inverse[np.asarray(views)[:, None, None], rows, columns]
        return Shared(inverse, self.log_dets[views])

    def between(self, views: slice) -> Shared:
        """Noise within neighbouring views, every place kept."""
        if self.inverse is None:
            return self
        return Shared(self.inverse[views], self.log_dets[views])

    def apply(self, values: Array) -> Array:
        """Multiply by the inverse, ``(..., n_views, n_places, k)``."""
        return values if self.inverse is None else np.asarray(self.inverse @ values)


INDEPENDENT = Shared(None, frozen(np.zeros(0)))


class Geometry:
    """Distances on the target, from which the covariances come."""

    def __init__(self, data: Observations) -> None:
        self.data = data
        self._kept: dict[tuple[float, float], Shared] = {}

    @cached_property
    def spacing(self) -> float:
        """Median distance of a point of the target to its nearest neighbour, diagonals."""
        distance, _ = cKDTree(self.data.target).query(self.data.target, k=2)
        return float(np.median(distance[:, 1]))

    @cached_property
    def pixel(self) -> float:
        """Length on the target that makes 1 px, from neighbours in the views, diagonals."""
        squares = []
        for which, pixels, seen in zip(
            self.data.which, self.data.pixels, self.data.seen, strict=True
        ):
            points, at = self.data.target[which[seen]], pixels[seen]
            distance, nearest = cKDTree(points).query(points, k=2)
            apart = at[nearest[:, 1]] - at
            squares.append((apart**2).sum(axis=1) / distance[:, 1] ** 2)
        return float(1 / np.sqrt(np.concatenate(squares).mean()))

    @cached_property
    def distance(self) -> Array:
        """Between points of the target, ``(n_target, n_target)``."""
        target = self.data.target
        return np.array([np.sqrt(((target - point) ** 2).sum(axis=-1)) for point in target])

    def shared(self, error: ErrorModel) -> Shared:
        """Noise within the views."""
        if not error.correlated:
            return INDEPENDENT
        key = error.correlated, error.length
        if key not in self._kept:
            size = self.data.which.shape[1] ** 2 * (1 if self.data.alike else self.data.n_views)
            while len(self._kept) * size > KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = self._made(*key)
        return self._kept[key]

    def _made(self, correlated: float, length: float) -> Shared:
        data = self.data
        kernel = correlated * np.exp(-self.distance / length)
        one = data.alike and data.n_views > 0
        which, seen = (data.which[:1], data.seen[:1]) if one else (data.which, data.seen)
        n = which.shape[1]
        inverse, log_det = np.empty((len(which), n, n)), np.empty(len(which))
        for view, (points, has) in enumerate(zip(which, seen, strict=True)):
            covariance = kernel[np.ix_(points, points)] * (has[:, None] & has) + np.eye(n)
            log_det[view] = 4 * np.log(np.diagonal(np.linalg.cholesky(covariance))).sum()
            inverse[view] = np.linalg.inv(covariance)
        if one:
            inverse = np.broadcast_to(inverse, (data.n_views, n, n))
            log_det = np.broadcast_to(log_det, data.n_views)
        return Shared(inverse, log_det)

    def offset_sds(self, error: ErrorModel, unit: float) -> Array:
        """Deviations of the target's offsets over sigma along `directions`, axis by axis.

        Parameters
        ----------
        unit : float
            Length on the target that makes 1 px, diagonals.

        Returns
        -------
        Array
            Of `free` ones, ``(n_free,)``.
        """
        values = self._smooth[0]
        rough = error.rough**2 * self._axes
        squares = error.smooth**2 * values[:, None] + rough
        return np.asarray(unit * np.sqrt(squares.ravel()[self.free]))

    @property
    def _axes(self) -> Array:
        """Whether points are off each on its own in x, y and z."""
        return np.array([1.0, 1.0, 0.0 if self.data.planar else 1.0])

    @cached_property
    def free(self) -> IntArray:
        """Which of the target's offsets along `directions`, axis by axis, there may be."""
        return np.flatnonzero(self._smooth[0][:, None] + self._axes)

    @property
    def directions(self) -> Array:
        """Directions over the target in which offsets are independent, whatever their levels.

        Orthonormal columns, ``(n_target, n_target)``; each serves x, y and z.
        """
        return self._smooth[1]

    def offset_root(self, error: ErrorModel, unit: float) -> Array | None:
        """Root of the covariance of the target's offsets over sigma^2, ``(3 n_target, q)``."""
        if not error.offsets:
            return None
        sds = self.offset_sds(error, unit)
        return np.asarray((self._basis * sds)[:, sds > 0])

    @cached_property
    def _basis(self) -> Array:
        return np.asarray(np.kron(self.directions, np.eye(3))[:, self.free])

    @cached_property
    def _smooth(self) -> tuple[Array, Array]:
        """Variances and directions of the smooth offsets; 0 where they are negligible."""
        kernel = np.exp(-0.5 * (self.distance / SMOOTH_LENGTH) ** 2)
        values, vectors = np.linalg.eigh(kernel)
        return np.where(values > 1e-4 * values.max(), values, 0.0), vectors
