r"""The density that is sampled: p(data | lens) p(lens), poses, offsets, sigma and tau integrated.

At a lens x the poses start where the linear response about a reference puts them, and one
Newton step with the reference's precision H gives the smallest sum of squares,

    S(x) = e' C^-1 e - g' H^-1 g,    g = P' C^-1 e,

C the covariance of all noise over sigma^2: the error is of fourth order in the distance. The log
determinant of the poses' blocks is evaluated at x, the coupling by the offsets at the reference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from bayescal.arrays import Array, IntArray
from bayescal.calibration.error_model import Shared
from bayescal.calibration.laplace import INFERRED, Laplace, Level, constant, degrees, laplace
from bayescal.calibration.lens_model import LensModel
from bayescal.calibration.observations import Observations
from bayescal.calibration.reduction import Reduced, Views, eliminate, pose_response, reduce
from bayescal.calibration.stacking import Poses, Stacked, residuals, stacked
from bayescal.calibration.strengths import strengths
from bayescal.inference.proposals.t_mixture import cholesky
from bayescal.prior.strength import Strength

AT_A_TIME = 100_000  # numbers of residuals


@dataclass(frozen=True, eq=False)
class Problem:
    """A lens model under an error model, linearised about a lens and poses.

    Attributes
    ----------
    x : Array
        ``(dimension,)``.
    shared : Shared
        Noise within the views.
    root : Array or None
        Of the covariance of the target's offsets.
    """

    model: LensModel
    data: Observations
    x: Array
    poses: Poses
    shared: Shared
    root: Array | None
    level: Level = INFERRED

    @cached_property
    def stack(self) -> Stacked:
        """Residuals and derivatives at the reference."""
        return stacked(self.model, self.data, self.x, self.poses)

    @cached_property
    def views(self) -> Views:
        """Normal equations, poses eliminated."""
        return reduce(self.stack, self.data, self.shared, offsets=self.root is not None)

    @cached_property
    def reduced(self) -> Reduced:
        """Normal equations of the lens alone."""
        return eliminate(self.views, self.root)

    @cached_property
    def offsets(self) -> Array:
        """How far points of the target are off at the reference, ``(n_target, 3)``, diagonals."""
        if self.root is None:
            return np.zeros_like(self.data.target)
        return np.asarray((self.root @ self.reduced.offset_step[:, -1]).reshape(-1, 3))

    @property
    def bow(self) -> Array:
        """Bow of the target at the reference, diagonals; empty where it has none."""
        return self.model.physical(self.x)[2]

    @cached_property
    def noise(self) -> Array:
        """Residuals at the reference less what the target's offsets explain, as of `stack`."""
        if self.root is None:
            return self.stack.residuals
        moved = np.einsum("vnai,vni->vna", self.stack.by_target, self.offsets[self.data.which])
        return np.asarray(self.stack.residuals - moved)

    @cached_property
    def response(self) -> Array:
        """How the poses follow the lens, ``(n_views, 6, dimension + 1)``."""
        return pose_response(self.views, self.reduced, self.root)

    def poses_at(self, x: Array) -> Poses:
        """Poses where the linear response puts them for lenses ``(..., dimension)``."""
        step = x - self.x
        moves = self.response[..., -1] - np.einsum("vpd,...d->...vp", self.response[..., :-1], step)
        return self.poses.moved(moves)

    def log_prob(self, x: Array) -> Array:
        """Log likelihood times prior at lenses ``(n_draws, dimension)``; -inf where impossible."""
        rows = max(1, AT_A_TIME // self.data.pixels.size)
        parts = [self._log_prob(x[i : i + rows]) for i in range(0, len(x), rows)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _log_prob(self, x: Array) -> Array:
        found, possible = self.log_likelihood(x)
        return np.where(possible, found + self.log_prior(x), -np.inf)

    def log_prior(self, x: Array) -> Array:
        """Log prior, the strengths integrated out, ``(n_draws,)``."""
        total = self.model.log_plain_prior(x)
        for group in self.model.groups:
            amplitudes = x[:, list(group.columns)] / group.unit
            low, high = np.log(group.bounds)
            strength = Strength((float(low), float(high)), len(group.columns))
            total = total + strength.log_density((amplitudes**2).sum(axis=1))
            total = total - len(group.columns) * np.log(group.unit)
        return np.asarray(total)

    def log_likelihood(self, x: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Log likelihood with poses, offsets and sigma integrated, and where it is possible."""
        with np.errstate(all="ignore"):
            poses = self.poses_at(x)
            misfit, possible = residuals(self.model, self.data, x, poses)
            misfit = np.where(possible[:, None, None, None], misfit, 0.0)
            squares = self._least_squares(misfit)
            log_det = self.reduced.log_det + self._log_det_change(x)
        fixed = constant(self.data, 0.0, self.shared.log_det)
        found = self.level.log_density(np.maximum(squares, 0.0), degrees(self.data))
        return found + fixed - log_det / 2, possible & np.isfinite(squares)

    def squares(self, x: Array) -> Array:
        """Smallest sum of squares over poses and offsets at lenses ``(n_draws, dimension)``."""
        rows = max(1, AT_A_TIME // self.data.pixels.size)
        parts = []
        for i in range(0, len(x), rows):
            part = x[i : i + rows]
            misfit, _ = residuals(self.model, self.data, part, self.poses_at(part))
            parts.append(self._least_squares(misfit))
        return np.concatenate(parts)

    def only(self, views: IntArray) -> Problem:
        """Give the same lens under the same error model for some of the views."""
        data, poses = self.data.only(views), self.poses.only(views)
        shared = self.shared.only(views, data.which.shape[1])
        return replace(self, data=data, poses=poses, shared=shared)

    def _least_squares(self, misfit: Array) -> Array:
        """Smallest sum of squares over poses near by, ``(n_draws,)``."""
        weighted = self.shared.apply(misfit)
        total = np.einsum("svna,svna->s", misfit, weighted)
        slope = np.einsum("svna,vnap->svp", weighted, self.stack.by_pose, optimize=True)
        if self.root is not None:
            offset = self._pulled(weighted) @ self.root  # L' G' R^-1 e
            solved = cho_solve(self._offset_factor, offset.T).T
            total = total - (offset * solved).sum(axis=1)
            slope = slope - np.einsum("vpq,sq->svp", self._coupling, solved, optimize=True)
        whitened = np.einsum("vij,svj->svi", self._pose_whiteners, slope, optimize=True)
        total = total - np.einsum("svi,svi->s", whitened, whitened)
        if self.root is not None:
            # H is its blocks less the coupling's low rank: the rest of H^-1 by Woodbury.
            rest = np.einsum("svi,viq->sq", whitened, self._white_coupling, optimize=True)
            total = total - (rest * cho_solve(self._coupled_factor, rest.T).T).sum(axis=1)
        return np.asarray(total)

    def _pulled(self, weighted: Array) -> Array:
        """G' R^-1 e: what pulls at the target's points, ``(n_draws, 3 n_target)``."""
        met = np.einsum("svna,vnai->svni", weighted, self.stack.by_target, optimize=True)
        pulled = np.zeros((len(weighted), len(self.data.target), 3))
        for view in range(self.data.n_views):
            seen = self.data.seen[view]
            pulled[:, self.data.which[view, seen]] += met[:, view, seen]
        return pulled.reshape(len(weighted), -1)

    @cached_property
    def _coupling(self) -> Array:
        """P' R^-1 G L, ``(n_views, 6, q)``."""
        assert self.root is not None
        return np.asarray(self.views.pose_offset @ self.root)

    @cached_property
    def _pose_whiteners(self) -> Array:
        """Inverse roots of the poses' blocks, ``(n_views, 6, 6)``."""
        return np.linalg.inv(np.linalg.cholesky(self.views.pose_precision))

    @cached_property
    def _white_coupling(self) -> Array:
        return np.asarray(self._pose_whiteners @ self._coupling)

    @cached_property
    def _coupled_factor(self) -> tuple[Array, bool]:
        """Factor of I + L' F L, poses eliminated."""
        assert self.root is not None
        inner = np.eye(self.root.shape[1]) + self.root.T @ self.views.inner @ self.root
        lower, _ = cho_factor(inner, lower=True)
        return np.asarray(lower), True

    @cached_property
    def _offset_factor(self) -> tuple[Array, bool]:
        """Factor of I + L' G' R^-1 G L, poses not eliminated."""
        assert self.root is not None
        flat = self._white_coupling.reshape(-1, self.root.shape[1])
        inner = np.eye(self.root.shape[1]) + self.root.T @ self.views.inner @ self.root
        lower, _ = cho_factor(inner + flat.T @ flat, lower=True)
        return np.asarray(lower), True

    def _log_det_change(self, x: Array) -> Array:
        """Change of the log determinant of the poses' precisions from the reference."""
        slope, bend = self._log_det_response
        u = solve_triangular(self.spread, (x - self.x).T, lower=True).T
        return np.asarray(u @ slope + u**2 @ bend)

    @cached_property
    def laplace(self) -> Laplace:
        """Posterior by linear algebra about the reference."""
        prior = strengths(self.model)
        log_det = self.shared.log_det
        return laplace(self.reduced, self.x, self.data, prior, log_det, self.level)

    @cached_property
    def spread(self) -> Array:
        """Lower root of the lens's posterior covariance."""
        return cholesky(self.laplace.covariance)

    @cached_property
    def _log_det_response(self) -> tuple[Array, Array]:
        """First and second order of that change in each direction, from steps of 1 sd."""
        d = self.model.dimension
        steps = self.spread.T  # rows: steps of x for u = 1
        around = np.concatenate([steps, -steps])
        values = (
            np.array([self.log_det_at(self.x + s) for s in around]) - self.views.log_det_poses.sum()
        )
        values = np.where(np.isfinite(values), values, 0.0)
        up, down = values[:d], values[d:]
        return (up - down) / 2, (up + down) / 2

    def log_det_at(self, x: Array) -> float:
        """Log determinant of the poses' precisions at one lens."""
        stack = stacked(self.model, self.data, x, self.poses_at(x))
        v, n = self.data.which.shape
        weighted = self.shared.apply(stack.by_pose.reshape(v, n, -1)).reshape(v, n, 2, 6)
        blocks = np.einsum("vnap,vnaq->vpq", stack.by_pose, weighted, optimize=True)
        return float(np.linalg.slogdet(blocks)[1].sum())
