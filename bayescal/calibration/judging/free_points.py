r"""How far each point is from where all the others put it, and how improbable that is.

Give one point a shift of its own, free in r and c. With poses, lens and the target's offsets
eliminated the residuals e have the metric

    Q = C^-1 - C^-1 A (A' C^-1 A)^-1 A' C^-1,

C the covariance of noise and offsets over sigma^2, A the derivatives by lens and poses. The shift
is (E'QE)^-1 E'Qe, E picking the point; it lowers S = e'Qe by D = e'QE (E'QE)^-1 E'Qe. Where the
point is as good as the others D / sigma^2 is chi-squared with 2 degrees of freedom, and without
sigma (D / 2) / ((S - D) / (nu - 2)) has F(2, nu - 2), nu those of S: the square of the externally
studentised residual, in two dimensions (Cook & Weisberg 1982, *Residuals and Influence in
Regression*, 2.2.2). F with 2 degrees of freedom above has its tail in closed form.

A point that is given its shift stays so: the next is looked for without it, as in an elimination
one at a time with a fit each. What all other points predict of one is the ratio of two integrals
over lens, poses, offsets and sigma, with the point and without it: a t of the shift, its precision
E'QE. The same of a point that has its shift is what the points without one predict of it; all
shifts together have the precision E'QE, E picking all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.laplace import SIGMA_BOUNDS, Level, degrees

LEAST_FREE = 1e-6  # of a residual's variance: with less the point is needed to place its view
LARGEST = 50_000_000  # numbers of derivatives by the target's offsets: 400 MB
NEGLIGIBLE = 1e-13  # relative: directions of the lens that the points do not tell


@dataclass(frozen=True)
class FreePoint:
    """A point with a shift of its own.

    Attributes
    ----------
    view, place : int
        Which, from 0.
    shift : tuple of float
        How far it is off in r and c, px.
    log_p : float
        Log of the probability that a good point is as far off.
    """

    view: int
    place: int
    shift: tuple[float, float]
    log_p: float


class FreePoints:
    """A settled problem in which points are given shifts of their own, one after the other.

    Attributes
    ----------
    squares : float
        Smallest sum of squares, the shifts given so far free, px^2.
    dof : int
        Its degrees of freedom.
    left : ndarray of bool
        Points that may still be given one, ``(n_views, n_places)``.
    order : list of tuple of int
        View and place of those that have one, as they were given it.
    """

    def __init__(self, problem: Problem) -> None:
        data, model = problem.data, problem.model
        self.data, self._sigma = data, problem.level.sigma
        self.dof = degrees(data) - model.dimension
        v, n = data.which.shape
        inverse = problem.shared.inverse
        self._inverse = np.broadcast_to(np.eye(n), (v, n, n)) if inverse is None else inverse
        by_pose = problem.stack.by_pose
        self._pulled = self._weighed(by_pose)
        self._precision = np.linalg.inv(np.einsum("vnap,vnaq->vpq", by_pose, self._pulled))
        columns = _columns(problem)
        free = self._without_poses(columns)
        gram = np.einsum("vnak,vnal->kl", columns, free, optimize=True)
        inner = gram[1:, 1:]
        offsets = np.arange(model.dimension, len(inner))
        inner[offsets, offsets] += 1  # their prior
        whitener = _inverse_root(inner)
        self._taken = _Columns(free[..., 1:] @ whitener)  # Q = M - taken taken'
        taken = self._taken.values
        self.metric = np.einsum("vnn,ab->vnab", self._inverse, np.eye(2))
        self.metric -= np.einsum(
            "vnap,vpq,vnbq->vnab", self._pulled, self._precision, self._pulled, optimize=True
        )
        self.metric -= taken @ taken.swapaxes(-1, -2)
        pull = whitener.T @ gram[1:, 0]
        self.weighted = free[..., 0] - taken @ pull
        self.squares = float(gram[0, 0] - pull @ pull)
        self._first = self.weighted, taken.shape[-1]
        self.order: list[tuple[int, int]] = []
        self.left = self.data.seen.copy()
        self._withdraw(~data.seen)

    def _gain(self) -> Array:
        """By how much each point's shift lowers the sum of squares; 0 where it has none."""
        a, b, d = (self.metric[..., i, j] for i, j in ((0, 0), (0, 1), (1, 1)))
        r, c = self.weighted[..., 0], self.weighted[..., 1]
        gain = np.zeros(self.left.shape)
        np.divide(d * r**2 - 2 * b * r * c + a * c**2, a * d - b**2, out=gain, where=self.left)
        return gain

    def log_p(self) -> Array:
        """Log p-value of each point's shift, ``(n_views, n_places)``; 0 where it has none."""
        gain = self._gain()
        if self._sigma is not None:
            return np.asarray(-gain / (2 * self._sigma**2))
        with np.errstate(divide="ignore"):
            found = (self.dof - 2) / 2 * np.log1p(-np.minimum(gain / self.squares, 1.0))
        # No sigma is below its bound: rounding of exact pixels is no gross error.
        return np.asarray(np.maximum(found, -gain / (2 * SIGMA_BOUNDS[0] ** 2)))

    def log_density(self) -> Array:
        """Log density of each point as all others predict it, px^-2, ``(n_views, n_places)``.

        NaN of points that have no shift to be given. What is known of the lens beforehand is left
        out, as in `log_p`.
        """
        left = self.metric[self.left]
        log_det = np.log(left[:, 0, 0] * left[:, 1, 1] - left[:, 0, 1] ** 2)
        before = np.full(len(log_det), self.squares)
        after = before - self._gain()[self.left]
        out = np.full(self.left.shape, np.nan)
        out[self.left] = self._ratio(before, after, self.dof, log_det, self.data.weight[self.left])
        return out

    def released(self) -> tuple[Array, Array]:
        """Shifts of the points that have one, and their log densities as the points left predict.

        Returns
        -------
        shifts : Array
            Observed less where the points without a shift put them, px, ``(n_released, 2)``, in
            the order of their release.
        log_density : Array
            Each alone beside the points without a shift, px^-2, ``(n_released,)``.
        """
        if not self.order:
            return np.zeros((0, 2)), np.zeros(0)
        view, place = np.array(self.order).T
        weighted, width = self._first
        k, weight = len(view), self.data.weight[view, place]
        taken, pulled = self._taken.values[view, place, :, :width], self._pulled[view, place]
        alike = view[:, None] == view
        noise = np.where(alike, self._inverse[view[:, None], place[:, None], place], 0.0)
        poses = np.einsum("iap,ipq,jbq->iajb", pulled, self._precision[view], pulled, optimize=True)
        metric = np.einsum("ij,ab->iajb", noise, np.eye(2)) - poses * alike[:, None, :, None]
        metric -= np.einsum("iak,jbk->iajb", taken, taken, optimize=True)
        covariance = np.linalg.inv(metric.reshape(2 * k, 2 * k))
        shifts = (covariance @ weighted[view, place].ravel()).reshape(k, 2)
        own = np.einsum("iaib->iab", covariance.reshape(k, 2, k, 2))
        put_back = (shifts * np.linalg.solve(own, shifts[..., None])[..., 0]).sum(axis=-1)
        after = np.full(k, self.squares)
        log_det = -np.linalg.slogdet(own)[1]
        found = self._ratio(after + put_back, after, self.dof + 2, log_det, weight)
        return shifts / weight, found

    def _ratio(self, before: Array, after: Array, dof: int, log_det: Array, weight: Array) -> Array:
        """Log of the integral with a point over that without, by their sums of squares."""
        level = Level(self._sigma)
        tiny = np.finfo(float).tiny
        one = level.log_density(np.maximum(before, tiny), dof)
        other = level.log_density(np.maximum(after, tiny), dof - 2)
        return np.asarray(one - other + log_det / 2 + np.log(weight).sum(axis=-1))

    def shift(self, view: int, place: int) -> Array:
        """How far a point is off in r and c, px."""
        moved = np.linalg.solve(self.metric[view, place], self.weighted[view, place])
        return np.asarray(moved / self.data.weight[view, place])

    def least_probable(self) -> FreePoint | None:
        """Find the point that its shift gains most; None where there is none to test."""
        if self.dof <= 2 or not self.left.any():
            return None
        log_p = self.log_p()
        view, place = np.unravel_index(int(log_p.argmin()), log_p.shape)
        r, c = self.shift(int(view), int(place)).tolist()
        return FreePoint(int(view), int(place), (r, c), float(log_p[view, place]))

    @property
    def full(self) -> bool:
        """Whether one more would take more memory than is wanted."""
        return self._taken.values.size > LARGEST

    def release(self, view: int, place: int) -> None:
        """Give a point its shift for good."""
        column = np.zeros((*self.left.shape, 2, 2))
        column[view, :, 0, 0] = column[view, :, 1, 1] = self._inverse[view, place]
        column[view] -= np.einsum(
            "nap,pq,bq->nab",
            self._pulled[view],
            self._precision[view],
            self._pulled[view, place],
            optimize=True,
        )
        column -= self._taken.values @ self._taken.values[view, place].T
        root = np.linalg.cholesky(self.metric[view, place])
        taken = column @ np.linalg.inv(root).T
        pull = np.linalg.solve(root, self.weighted[view, place])
        self._taken.add(taken)
        self.metric -= taken @ taken.swapaxes(-1, -2)
        self.weighted = self.weighted - taken @ pull
        self.squares -= float(pull @ pull)
        self.dof -= 2
        self.order.append((view, place))
        gone = np.zeros(self.left.shape, dtype=bool)
        gone[view, place] = True
        self._withdraw(gone)

    def _withdraw(self, gone: NDArray[np.bool_]) -> None:
        """Leave out points that have their shift, and those that others can't do without."""
        own = np.einsum("vnn->vn", self._inverse)
        a, b, d = (self.metric[..., i, j] for i, j in ((0, 0), (0, 1), (1, 1)))
        least = (a + d) / 2 - np.hypot((a - d) / 2, b)  # the smaller eigenvalue
        self.left &= ~gone & (least > LEAST_FREE * own)

    def _weighed(self, columns: Array) -> Array:
        """Apply the inverse of the noise's covariance, ``(n_views, n_places, 2, k)``."""
        v, n, _, k = columns.shape
        return np.asarray((self._inverse @ columns.reshape(v, n, 2 * k)).reshape(columns.shape))

    def _without_poses(self, columns: Array) -> Array:
        """Apply M: the same with each view's pose eliminated."""
        met = np.einsum("vnap,vnak->vpk", self._pulled, columns, optimize=True)
        gone = np.einsum("vnap,vpk->vnak", self._pulled, self._precision @ met, optimize=True)
        return np.asarray(self._weighed(columns) - gone)


class _Columns:
    """Columns ``(n_views, n_places, 2, k)`` to which others are added, without copies of each."""

    def __init__(self, first: Array) -> None:
        self._kept, self._width = first, first.shape[-1]

    @property
    def values(self) -> Array:
        """All of them."""
        return self._kept[..., : self._width]

    def add(self, more: Array) -> None:
        """Add some behind them."""
        before, self._width = self._width, self._width + more.shape[-1]
        if self._width > self._kept.shape[-1]:
            grown = np.empty((*more.shape[:-1], self._width + before // 2 + 16))
            grown[..., :before] = self._kept[..., :before]
            self._kept = grown
        self._kept[..., before : self._width] = more


def _columns(problem: Problem) -> Array:
    """Residuals, and derivatives by lens and whitened offsets, ``(n_views, n_places, 2, k)``.

    Where there are too many numbers the target's offsets stay at their estimates, which so many
    views determine well.
    """
    stack, root = problem.stack, problem.root
    if root is None or stack.residuals.size * root.shape[1] > LARGEST:
        return np.concatenate([problem.noise[..., None], stack.by_lens], axis=-1)
    by_offset = stack.by_target @ root.reshape(-1, 3, root.shape[1])[problem.data.which]
    return np.concatenate([stack.residuals[..., None], stack.by_lens, by_offset], axis=-1)


def _inverse_root(matrix: Array) -> Array:
    """Root of the inverse, of the directions that matter."""
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(matrix * scale * scale[:, None])
    kept = values > NEGLIGIBLE * values.max()
    return np.asarray(scale[:, None] * vectors[:, kept] / np.sqrt(values[kept]))
