"""What poses and the target's offsets take of the residuals' sum of squares at a reference."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.calibration.fitting.reduction import Views
from bayescal.calibration.fitting.stacking import Stacked
from bayescal.calibration.model.error_model import Shared
from bayescal.calibration.model.observations import Observations


@dataclass(frozen=True, eq=False)
class Taking:
    """Poses and offsets eliminated from residuals, by derivatives at a reference.

    Attributes
    ----------
    stack : Stacked
        Derivatives at the reference.
    shared : Shared
        Noise within the views.
    views : Views
        Normal equations, poses eliminated.
    root : Array or None
        Of the covariance of the target's offsets.
    """

    data: Observations
    stack: Stacked
    shared: Shared
    views: Views
    root: Array | None

    def of(self, misfit: Array) -> tuple[Array, Array, Array]:
        """Residuals e and R^-1 e, ``(n_views, 2, n_draws, n_places)``, and what is taken of them.

        Poses and offsets take the square of that, ``(n_draws, 6 n_views + n_offsets)``, from
        e' R^-1 e.
        """
        e, weighted, taken, pulled = self.of_views(slice(None), misfit)
        return e, weighted, self.with_offsets(taken, pulled)

    def of_views(self, views: slice, misfit: Array) -> tuple[Array, Array, Array, Array | None]:
        """Give the first two of neighbouring views, what their poses take, and what then pulls.

        What pulls at the target's points, ``(n_draws, 3 n_target)``, adds up over the views; None
        without offsets.
        """
        e = misfit.transpose(1, 3, 0, 2)
        inverse = self.shared.inverse
        weighted = e if inverse is None else e @ inverse[views, None]
        # H = L L' of each pose: L^-1 P' R^-1 e.
        whiteners = self.pose_whiteners[views].swapaxes(1, 2)[:, None]
        slopes = self.stack.by_pose[views].swapaxes(1, 2) @ whiteners
        poses = (weighted @ slopes).sum(axis=1)
        taken = np.asarray(poses.swapaxes(0, 1).reshape(len(misfit), -1))
        if self.root is None:
            return e, weighted, taken, None
        coupling = self._white_coupling[views].reshape(taken.shape[1], -1)
        return e, weighted, taken, self._pulled(views, weighted) - taken @ coupling

    def with_offsets(self, taken: Array, pulled: Array | None) -> Array:
        """Add what offsets take to what the poses of all views do."""
        if pulled is None:
            return taken
        return np.concatenate([taken, pulled @ self._offset_whitener], axis=1)

    def _pulled(self, views: slice, weighted: Array) -> Array:
        """G' R^-1 e: what pulls at the target's points, ``(n_draws, 3 n_target)``."""
        by_target, data = self.stack.by_target[views], self.data
        pulled = np.zeros((weighted.shape[2], 3, len(data.target)))
        for axis in range(3):
            if data.alike:
                met = np.einsum("vasn,vna->sn", weighted, by_target[..., axis])
                pulled[:, axis, data.which[0]] = met
                continue
            seen_by = zip(data.which[views], data.seen[views], strict=True)
            for view, (which, seen) in enumerate(seen_by):
                met = np.einsum("asn,na->sn", weighted[view], by_target[view, ..., axis])
                pulled[:, axis, which[seen]] += met[:, seen]
        return pulled.swapaxes(1, 2).reshape(len(pulled), -1)

    @cached_property
    def pose_whiteners(self) -> Array:
        """Inverse roots of the poses' blocks, ``(n_views, 6, 6)``."""
        return np.linalg.inv(np.linalg.cholesky(self.views.pose_precision))

    @cached_property
    def _white_coupling(self) -> Array:
        """L^-1 P' R^-1 G of each pose, ``(n_views, 6, 3 n_target)``."""
        return np.asarray(self.pose_whiteners @ self.views.pose_offset)

    @cached_property
    def _offset_whitener(self) -> Array:
        """B with B B' = L (I + L' F L)^-1 L', L the offsets' root, ``(3 n_target, n_offsets)``."""
        assert self.root is not None
        inner = np.eye(self.root.shape[1]) + self.root.T @ self.views.inner @ self.root
        whitener = solve_triangular(np.linalg.cholesky(inner), self.root.T, lower=True)
        return np.asarray(whitener.T)
