r"""The normal equations of all views, with poses and the target's offsets eliminated.

Residuals e = y - f(x, poses), J their derivatives by the lens (x) and P by the pose of a view,
G by the target's points; R the covariance of a view's noise and L L' that of the offsets, both
over sigma^2. Minimising over the poses and over the offsets leaves a quadratic in the step of x:

    S(x + s) = e'e - 2 s' J'e + s' J'J s   (in the metric of what is left),

by the Schur complement of each view's 6 x 6 block and then of the offsets' block
T = I + L' F L, F = sum_v G' M G (Golub & Pereyra 1973; Triggs et al. 2000, section 6.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from bayescal.arrays import Array
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
    gram = np.einsum("vnak,vnal->vkl", columns, weighted, optimize=True)
    precision, pose_cross = gram[:, :6, :6], gram[:, :6, 6:]
    precision = precision * (1 + damping * np.eye(6))
    solved = np.linalg.solve(precision, pose_cross)
    rest = gram[:, 6:, 6:] - np.swapaxes(pose_cross, 1, 2) @ solved
    if not offsets:
        none = np.zeros((v, 0, d + 1))
        empty = np.zeros((0, 0))
        return Views(rest, none, empty, precision, pose_cross, np.zeros((v, 6, 0)))
    m = 3 * len(data.target)
    # G' R^-1 [P, J, e]: each point of the target meets the places where it was seen.
    met = np.einsum("vnai,vnak->vnik", stack.by_target, weighted)
    scattered = np.zeros((v, len(data.target), 3, d + 7))
    np.add.at(scattered, (np.arange(v)[:, None], data.which), met)
    scattered = scattered.reshape(v, m, d + 7)
    pose_offset = np.swapaxes(scattered[..., :6], 1, 2)
    cross = scattered[..., 6:] - scattered[..., :6] @ solved
    inner = _inner(stack, data, shared)
    inner -= np.einsum(
        "vpi,vpj->ij", pose_offset, np.linalg.solve(precision, pose_offset), optimize=True
    )
    return Views(rest, cross, inner, precision, pose_cross, pose_offset)


def _inner(stack: Stacked, data: Observations, shared: Shared) -> Array:
    """G' R^-1 G over all views, ``(3 n_target, 3 n_target)``."""
    m, n = len(data.target), data.which.shape[1]
    total = np.zeros((m, 3, m, 3))
    alike = bool((data.which == data.which[0]).all() and data.seen.all())
    flat = stack.by_target.transpose(0, 1, 3, 2).reshape(data.n_views, 3 * n, 2)
    summed = np.zeros((n, 3, n, 3))
    for v in range(data.n_views):
        which = data.which[v]
        if shared.inverse is None:
            slope = stack.by_target[v][data.seen[v]]
            # A view shows each point once.
            total[which[data.seen[v]], :, which[data.seen[v]]] += np.einsum(
                "nai,naj->nij", slope, slope
            )
            continue
        block = (flat[v] @ flat[v].T).reshape(n, 3, n, 3) * shared.inverse[v][:, None, :, None]
        if alike:
            summed += block
        else:
            seen = data.seen[v]
            block = block[seen][:, :, seen].transpose(0, 2, 1, 3)
            total[which[seen][:, None], :, which[seen][None, :], :] += block
    if alike and shared.inverse is not None:
        total[data.which[0][:, None], :, data.which[0][None, :], :] += summed.transpose(0, 2, 1, 3)
    return total.reshape(3 * m, 3 * m)


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


def eliminate(views: Views, root: Array | None) -> Reduced:
    """Sum the views and eliminate the target's offsets.

    Parameters
    ----------
    root : Array or None
        Of the offsets' covariance, ``(3 n_target, q)``.
    """
    gram = views.gram.sum(axis=0)
    log_det = float(views.log_det_poses.sum())
    step = np.zeros((0, gram.shape[1]))
    if root is not None:
        cross = root.T @ views.cross.sum(axis=0)
        block = np.eye(root.shape[1]) + root.T @ views.inner @ root
        factor = cho_factor(block, lower=True)
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
