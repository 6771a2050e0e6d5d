"""Points of a target seen in many views, as arrays padded to the longest view."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, IntArray, frozen
from bayescal.points.views.views import Views

FLAT = 1e-9  # of the target's diagonal: thinner than this it is planar


@dataclass(frozen=True, eq=False)
class Observations:
    """What was seen, per view; places a view lacks have weight 0.

    The target's coordinates are scaled by its diagonal and centred, so that numbers are of
    order one.

    Attributes
    ----------
    target : Array
        Points of the target, ``(n_target, 3)``, in diagonals from its centre.
    which : IntArray
        Point of the target at each place, ``(n_views, n_places)``.
    pixels : Array
        r, c, ``(n_views, n_places, 2)``, px.
    weight : Array
        1 over the relative standard deviation of r and of c, ``(n_views, n_places, 2)``;
        0 where nothing was seen.
    size : tuple of float
        Width and height of the image, px.
    diagonal : float
        Of the target, in its own unit.
    levels : Array or None
        Noise of each view over that of the usual one, which the weights hold, ``(n_views,)``;
        None where all are alike.
    """

    target: Array
    which: IntArray
    pixels: Array
    weight: Array
    size: tuple[float, float]
    diagonal: float
    levels: Array | None = None

    @classmethod
    def of(
        cls,
        target: Array,
        which: IntArray,
        pixels: Array,
        view: IntArray,
        size: tuple[float, float],
        weight: Array | None = None,
    ) -> Observations:
        """Arrange a long table: a row per point seen.

        Parameters
        ----------
        target : Array
            ``(n_target, 3)``, the target's own unit.
        which, view : IntArray
            Point of the target and number of the view of each row, ``(n_rows,)``.
        pixels : Array
            ``(n_rows, 2)``, px.
        size : tuple of float
            Width and height of the image, px.
        weight : Array, optional
            ``(n_rows, 2)``.
        """
        low, high = target.min(axis=0), target.max(axis=0)
        diagonal = float(np.linalg.norm(high - low))
        scaled = (target - (low + high) / 2) / diagonal
        counts = np.bincount(view)
        order = np.argsort(view, kind="stable")
        column = np.concatenate([np.arange(n) for n in counts])
        shape = (len(counts), int(counts.max()))
        places = np.zeros(shape, dtype=np.intp)
        seen, weights = np.zeros((*shape, 2)), np.zeros((*shape, 2))
        row = view[order]
        places[row, column] = which[order]
        seen[row, column] = pixels[order]
        weights[row, column] = 1.0 if weight is None else weight[order]
        places.setflags(write=False)
        return cls(frozen(scaled), places, frozen(seen), frozen(weights), size, diagonal)

    @classmethod
    def from_views(cls, views: Views, size: tuple[float, float]) -> Observations:
        """Arrange views; a plane is turned to z = 0.

        Deviations that say only how points compare are scaled to a median of 1.
        """
        target = views.target
        if views.planar:
            centred = target - target.mean(axis=0)
            if np.ptp(centred[:, 2]) > FLAT * views.diagonal:
                axes = np.linalg.svd(centred)[2]
                target = centred @ (axes * np.linalg.det(axes)).T
            target = target * np.array([1.0, 1.0, 0.0])
        weight = None
        if views.sigma is not None:
            unit = float(np.median(views.sigma)) if views.relative_sigma else 1.0
            weight = unit / views.sigma
        return cls.of(target, views.corner, views.pixels, views.view, size, weight)

    @property
    def n_views(self) -> int:
        """Number of views."""
        return len(self.which)

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Where a view has a point, ``(n_views, n_places)``."""
        return np.asarray(self.weight[..., 0] > 0)

    @cached_property
    def complete(self) -> bool:
        """Whether every view has a point at every place."""
        return bool(self.seen.all())

    @cached_property
    def counts(self) -> IntArray:
        """Points of each view, ``(n_views,)``."""
        return self.seen.sum(axis=1)

    @property
    def n_points(self) -> int:
        """Points seen, over all views."""
        return int(self.counts.sum())

    @cached_property
    def world(self) -> Array:
        """Target's point at each place, ``(n_views, n_places, 3)``, diagonals."""
        return np.asarray(self.target[self.which])

    @cached_property
    def planar(self) -> bool:
        """Whether the target is a plane at z = 0."""
        return bool(np.ptp(self.target[:, 2]) < FLAT)

    @cached_property
    def log_weight(self) -> float:
        """Sum of the logs of the weights."""
        return float(np.log(self.weight[self.seen]).sum())

    @cached_property
    def alike(self) -> bool:
        """Whether every view shows the same points in the same places."""
        return self.complete and bool((self.which == self.which[0]).all())

    def by_target(self, values: Array) -> Array:
        """Move values at the places of each view to its points of the target.

        Parameters
        ----------
        values : Array
            ``(n_views, n_places, ...)``.

        Returns
        -------
        Array
            ``(n_views, n_target, ...)``, 0 where a view lacks the point.
        """
        out = np.zeros((len(values), len(self.target), *values.shape[2:]))
        if self.alike:
            out[:, self.which[0]] = values
            return out
        view, place = np.nonzero(self.seen)
        out[view, self.which[view, place]] = values[view, place]
        return out

    def without(self, points: NDArray[np.bool_]) -> Observations:
        """Leave points out, ``(n_views, n_places)``; their places stay, as of points not seen."""
        return replace(self, weight=np.where(points[..., None], 0.0, self.weight))

    def with_levels(self, levels: Array) -> Observations:
        """Give every view its level of noise, ``(n_views,)``."""
        return replace(self, weight=self.weight / levels[:, None, None], levels=levels)

    def between(self, views: slice) -> Observations:
        """Give the observations of neighbouring views, every place kept."""
        return replace(
            self,
            which=self.which[views],
            pixels=self.pixels[views],
            weight=self.weight[views],
            levels=None if self.levels is None else self.levels[views],
        )

    def places_of(self, views: IntArray) -> IntArray:
        """Places that some views keep by themselves, those seen first, ``(n_some, n_kept)``."""
        n = int(self.counts[views].max())
        return np.argsort(~self.seen[views], axis=1, kind="stable")[:, :n]

    def only(self, views: IntArray) -> Observations:
        """Give the observations of some views, in that order."""
        at = np.asarray(views)[:, None], self.places_of(views)
        levels = None if self.levels is None else self.levels[views]
        return replace(
            self,
            which=self.which[at],
            pixels=self.pixels[at],
            weight=self.weight[at],
            levels=levels,
        )
