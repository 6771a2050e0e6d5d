r"""The normal equations of all views, with poses and the target's offsets eliminated.

Residuals e = y - f(x, poses), J their derivatives by the lens (x) and P by the pose of a view,
G by the target's points; R the covariance of a view's noise and L L' that of the offsets, both
over sigma^2. Minimising over the poses and over the offsets leaves a quadratic in the step of x:

    S(x + s) = e'e - 2 s' J'e + s' J'J s   (in the metric of what is left),

by the Schur complement of each view's 6 x 6 block and then of the offsets' block
T = I + L' F L, F = sum_v G' M G (Golub & Pereyra 1973; Triggs et al. 2000, section 6.1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from bayescal.arrays import Array, IntArray
from bayescal.calibration.error_model import Shared
from bayescal.calibration.observations import Observations
from bayescal.calibration.stacking import Stacked


@dataclass(frozen=True, eq=False)
class Views:
    """What each view adds once its pose is eliminated; columns are those of x, then e.

    Attributes
    ----------
    gram : Array
        ``(n_views, d + 1, d + 1)``.
    cross : Array
        With the target's points, ``(n_views, 3 n_target, d + 1)``; empty without offsets.
    inner : Array
        ``(3 n_target, 3 n_target)``, summed over the views; empty without offsets.
    pose_precision : Array
        ``(n_views, 6, 6)``.
    pose_cross : Array
        With x and e, ``(n_views, 6, d + 1)``.
    pose_offset : Array
        With the target's points, ``(n_views, 6, 3 n_target)``.
    """

    gram: Array
    cross: Array
    inner: Array
    pose_precision: Array
    pose_cross: Array
    pose_offset: Array

    @cached_property
    def log_det_poses(self) -> Array:
        """Log determinant of each pose's precision, ``(n_views,)``."""
        return np.asarray(np.linalg.slogdet(self.pose_precision)[1])

    @cached_property
    def sums(self) -> Sums:
        """Over the views."""
        log_det = float(self.log_det_poses.sum())
        return Sums(self.gram.sum(axis=0), self.cross.sum(axis=0), self.inner, log_det)

    def without(self, view: int, stack: Stacked, data: Observations, shared: Shared) -> Sums:
        """Give the sums over the other views; the rest as of `reduce`."""
        inner = self.inner
        if len(inner):
            coupling = self.pose_offset[view]
            inner = inner + coupling.T @ np.linalg.solve(self.pose_precision[view], coupling)
            at, block = _block(stack, data, shared, view)
            inner[np.ix_(at, at)] -= block
        return Sums(
            self.sums.gram - self.gram[view],
            self.sums.cross - self.cross[view],
            inner,
            self.sums.log_det - float(self.log_det_poses[view]),
        )


@dataclass(frozen=True, eq=False)
class Sums:
    """What views add together; fields as of `Views`, `log_det` that of the poses."""

    gram: Array
    cross: Array
    inner: Array
    log_det: float

    def turned(self, basis: Array) -> Sums:
        """Give offsets by other coordinates of the target, of which `basis` makes its points."""
        return replace(self, cross=basis.T @ self.cross, inner=basis.T @ self.inner @ basis)


def reduce(
    stack: Stacked, data: Observations, shared: Shared, *, offsets: bool, damping: float = 0.0
) -> Views:
    """Eliminate the poses.

    Parameters
    ----------
    shared : Shared
        Noise within the views.
    offsets : bool
        Whether the target's points may be off.
    damping : float, optional
        Share of its diagonal that is added to each pose's precision.
    """
    v, n, _, d = stack.by_lens.shape
    columns = np.concatenate([stack.by_pose, stack.by_lens, stack.residuals[..., None]], axis=-1)
    flat = columns.reshape(v, n, -1)  # both axes side by side: the noise mixes places, not axes
    weighted = shared.apply(flat).reshape(columns.shape)
    gram = _across(columns.reshape(v, 2 * n, -1), weighted.reshape(v, 2 * n, -1))
    precision, pose_cross = gram[:, :6, :6], gram[:, :6, 6:]
    precision = precision * (1 + damping * np.eye(6))
    solved = np.linalg.solve(precision, pose_cross)
    rest = gram[:, 6:, 6:] - _across(pose_cross, solved)
    if not offsets:
        none = np.zeros((v, 0, d + 1))
        empty = np.zeros((0, 0))
        return Views(rest, none, empty, precision, pose_cross, np.zeros((v, 6, 0)))
    # G' R^-1 [P, J, e]: each point of the target meets the places where it was seen.
    met = data.by_target(stack.by_target.swapaxes(2, 3) @ weighted).reshape(v, -1, d + 7)
    pose_offset = met[..., :6].swapaxes(1, 2)
    cross = met[..., 6:] - met[..., :6] @ solved
    whitened = (np.linalg.inv(np.linalg.cholesky(precision)) @ pose_offset).reshape(6 * v, -1)
    inner = _inner(stack, data, shared) - whitened.T @ whitened
    return Views(rest, cross, inner, precision, pose_cross, pose_offset)


def _across(one: Array, other: Array) -> Array:
    """Products of columns, view by view: ``(n_views, k, l)`` of ``(n_views, n, k)`` and of l."""
    return np.asarray(one.swapaxes(1, 2) @ other)


def _inner(stack: Stacked, data: Observations, shared: Shared) -> Array:
    """G' R^-1 G over all views, ``(3 n_target, 3 n_target)``."""
    m, (v, n) = len(data.target), data.which.shape
    if shared.inverse is None:
        points = stack.by_target.swapaxes(2, 3) @ stack.by_target
        blocks = np.zeros((m, 3, m, 3))
        at = np.arange(m)
        blocks[at, :, at] = data.by_target(points).sum(axis=0)
        return blocks.reshape(3 * m, 3 * m)
    flat = stack.by_target.swapaxes(2, 3).reshape(v, 3 * n, 2)
    if data.alike:
        sides = flat.swapaxes(0, 1).reshape(3 * n, 2 * v)
        blocks = (sides @ sides.T).reshape(n, 3, n, 3) * shared.inverse[0][:, None, :, None]
        total = np.zeros((m, 3, m, 3))
        total[np.ix_(data.which[0], range(3), data.which[0], range(3))] = blocks
        return total.reshape(3 * m, 3 * m)
    total = np.zeros((3 * m, 3 * m))
    for view in range(v):
        at, block = _block(stack, data, shared, view)
        total[np.ix_(at, at)] += block
    return total


def _block(stack: Stacked, data: Observations, shared: Shared, view: int) -> tuple[IntArray, Array]:
    """G' R^-1 G of a view, and its rows of `_inner`."""
    seen = data.seen[view]
    at = (3 * data.which[view, seen][:, None] + np.arange(3)).ravel()
    n = len(at) // 3
    noise = np.eye(n) if shared.inverse is None else shared.inverse[view][np.ix_(seen, seen)]
    sides = stack.by_target[view, seen].swapaxes(1, 2).reshape(3 * n, 2)
    block = (sides @ sides.T).reshape(n, 3, n, 3) * noise[:, None, :, None]
    return at, block.reshape(3 * n, 3 * n)


@dataclass(frozen=True, eq=False)
class Reduced:
    """The quadratic that is left, in the step of x.

    Attributes
    ----------
    precision : Array
        J'J, ``(d, d)``.
    slope : Array
        J'e, ``(d,)``.
    sum_of_squares : float
        e'e.
    log_det : float
        Of the pose blocks and the offsets' block together.
    offset_step : Array
        Offsets of the target as an affine function of the step, in whitened units:
        ``(q, d + 1)``, columns as of `Views`; empty without.
    """

    precision: Array
    slope: Array
    sum_of_squares: float
    log_det: float
    offset_step: Array


def eliminate(sums: Sums, root: Array | None) -> Reduced:
    """Eliminate the target's offsets.

    Parameters
    ----------
    root : Array or None
        Of the offsets' covariance, ``(3 n_target, q)``; where it is diagonal its diagonal,
        ``(3 n_target,)``.
    """
    gram, log_det = sums.gram, sums.log_det
    step = np.zeros((0, gram.shape[1]))
    if root is not None:
        if root.ndim == 1:
            some = np.flatnonzero(root)
            scale = root[some, None]
            cross, inner = (
                scale * sums.cross[some],
                scale * sums.inner[np.ix_(some, some)] * scale.T,
            )
        else:
            cross, inner = root.T @ sums.cross, root.T @ sums.inner @ root
        factor = cho_factor(np.eye(len(inner)) + inner, lower=True)
        step = cho_solve(factor, cross)
        gram = gram - cross.T @ step
        log_det += 2 * float(np.log(np.diag(factor[0])).sum())
    return Reduced(gram[:-1, :-1], gram[:-1, -1], float(gram[-1, -1]), log_det, step)


def pose_response(views: Views, reduced: Reduced, root: Array | None) -> Array:
    """How poses follow: steps as an affine function of that of x, ``(n_views, 6, d + 1)``.

    The step of a pose is column -1 less the other columns times the step of x.
    """
    coupled = views.pose_cross
    if root is not None:
        coupled = coupled - (views.pose_offset @ root) @ reduced.offset_step
    return np.asarray(np.linalg.solve(views.pose_precision, coupled))
