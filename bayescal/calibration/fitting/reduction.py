r"""The normal equations of all views, with poses and the target's offsets eliminated.

Residuals e = y - f(x, poses), J their derivatives by the lens (x) and P by the pose of a view,
G by the target's points; R the covariance of a view's noise and L L' that of the offsets, both
over sigma^2. Minimising over the poses and over the offsets leaves a quadratic in the step of x:

    S(x + s) = e'e - 2 s' J'e + s' J'J s   (in the metric of what is left),

by the Schur complement of each view's 6 x 6 block and then of the offsets' block
T = I + L' F L, F = sum_v G' M G (Golub & Pereyra 1973; Triggs et al. 2000, section 6.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from bayescal.arrays import Array, IntArray
from bayescal.calibration.fitting.stacking import Stacked
from bayescal.calibration.model.error_model import Shared
from bayescal.calibration.model.observations import Observations


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
    pose_step : Array
        What of those a pose takes by its step, the points of the target held, as `pose_cross`.
    pose_offset : Array
        With the target's points, ``(n_views, 6, 3 n_target)``.
    """

    gram: Array
    cross: Array
    inner: Array
    pose_precision: Array
    pose_cross: Array
    pose_step: Array
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

    def turned(self, basis: Array, kept: IntArray) -> Sums:
        """Give offsets along directions over the target, ``(n_target, n_target)``, axis by axis.

        Of these, which are to be kept.
        """
        m, columns = len(basis), self.cross.shape[1]
        cross = (basis.T @ self.cross.reshape(m, -1)).reshape(-1, columns)
        axes = len(cross) // m
        blocks = self.inner.reshape(m, axes, m, axes).transpose(1, 3, 0, 2)
        inner = (basis.T @ blocks @ basis).transpose(2, 0, 3, 1).reshape(len(cross), -1)
        return replace(self, cross=cross[kept], inner=inner[np.ix_(kept, kept)])


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
    columns = stack.columns
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
        return Views(rest, none, empty, precision, pose_cross, solved, np.zeros((v, 6, 0)))
    # G' R^-1 [P, J, e]: each point of the target meets the places where it was seen.
    met = data.by_target(stack.by_target.swapaxes(2, 3) @ weighted).reshape(v, -1, d + 7)
    pose_offset = met[..., :6].swapaxes(1, 2)
    cross = met[..., 6:] - met[..., :6] @ solved
    whitened = (np.linalg.inv(np.linalg.cholesky(precision)) @ pose_offset).reshape(6 * v, -1)
    inner = _inner(stack, data, shared) - whitened.T @ whitened
    return Views(rest, cross, inner, precision, pose_cross, solved, pose_offset)


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
    if data.alike:
        places = data.which[0]
        sides, noise = np.zeros((m, 3, 2 * v)), np.zeros((m, m))
        sides[places] = stack.by_target.transpose(1, 3, 0, 2).reshape(n, 3, 2 * v)
        noise[np.ix_(places, places)] = shared.inverse[0]
        flat = sides.reshape(3 * m, -1)
        return np.asarray((flat @ flat.T) * noise.repeat(3, axis=0).repeat(3, axis=1))
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
    gram : Array
        Products of derivatives by x, then e, ``(d + 1, d + 1)``.
    log_det : float
        Of the pose blocks and the offsets' block together.
    offset_step : Array
        Offsets of the target as an affine function of the step, in whitened units:
        ``(q, d + 1)``, columns as of `Views`; empty without.
    """

    gram: Array
    log_det: float
    offset_step: Array

    @property
    def precision(self) -> Array:
        """J'J, ``(d, d)``."""
        return self.gram[:-1, :-1]

    @property
    def slope(self) -> Array:
        """J'e, ``(d,)``."""
        return self.gram[:-1, -1]

    @property
    def sum_of_squares(self) -> float:
        """Residuals' own, e'e."""
        return float(self.gram[-1, -1])


def eliminate(sums: Sums, root: Array | None) -> Reduced:
    """Eliminate the target's offsets.

    Parameters
    ----------
    root : Array or None
        Of the offsets' covariance, ``(3 n_target, q)``.
    """
    if root is None:
        return Reduced(sums.gram, sums.log_det, np.zeros((0, len(sums.gram))))
    cross, inner = root.T @ sums.cross, root.T @ sums.inner @ root
    factor = cho_factor(np.eye(len(inner)) + inner, lower=True)
    step = cho_solve(factor, cross)
    log_det = sums.log_det + 2 * float(np.log(np.diag(factor[0])).sum())
    return Reduced(sums.gram - cross.T @ step, log_det, step)


def eliminate_independent(sums: Sequence[Sums], sds: Array) -> tuple[Array, Array]:
    """Eliminate offsets that are independent along their directions, of many sums at once.

    Parameters
    ----------
    sds : Array
        Of the offsets over sigma, ``(n_sums, q)``.

    Returns
    -------
    gram : Array
        ``(n_sums, d + 1, d + 1)``.
    log_det : Array
        Of the pose blocks and the offsets' block together, ``(n_sums,)``.
    """
    cross = sds[:, :, None] * np.array([s.cross for s in sums])
    n, q, columns = cross.shape
    # The root of [[I + F, X], [X', anything large]] has that of I + F, and of X what it takes.
    joint = np.zeros((n, q + columns, q + columns))
    joint[:, :q, :q] = sds[:, :, None] * np.array([s.inner for s in sums]) * sds[:, None, :]
    joint[:, q:, :q] = cross.swapaxes(1, 2)
    diagonal = np.einsum("nii->ni", joint)
    diagonal[:, :q] += 1
    diagonal[:, q:] = 1 + (cross**2).sum(axis=(1, 2))[:, None]
    root = np.linalg.cholesky(joint)
    taken = root[:, q:, :q]
    own = 2 * np.log(np.einsum("nii->ni", root)[:, :q]).sum(axis=1)
    gram = np.array([s.gram for s in sums]) - taken @ taken.swapaxes(1, 2)
    return gram, own + np.array([s.log_det for s in sums])


def pose_response(views: Views, reduced: Reduced, root: Array | None) -> Array:
    """How poses follow: steps as an affine function of that of x, ``(n_views, 6, d + 1)``.

    The step of a pose is column -1 less the other columns times the step of x.
    """
    if root is None:
        return views.pose_step
    coupled = views.pose_cross - (views.pose_offset @ root) @ reduced.offset_step
    return np.asarray(np.linalg.solve(views.pose_precision, coupled))
