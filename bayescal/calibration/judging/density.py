r"""The density that is sampled: p(data | lens) p(lens), poses, offsets, sigma and tau integrated.

At a lens x the poses start where the linear response about a reference puts them, and one
Newton step with the reference's precision H gives the smallest sum of squares,

    S(x) = e' C^-1 e - g' H^-1 g,    g = P' C^-1 e,

C the covariance of all noise over sigma^2: the error is of fourth order in the distance. Where
that step takes much of the squares, poses are moved by it and more steps follow. The log
determinant of the poses' blocks is evaluated at x, the coupling by the offsets at the reference.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array, IntArray, in_parts
from bayescal.calibration.fitting.reduction import Reduced, Views, eliminate, pose_response, reduce
from bayescal.calibration.fitting.stacking import Poses, Stacked, pose_slopes, residuals, stacked
from bayescal.calibration.judging.by_views import ByViews
from bayescal.calibration.judging.laplace import (
    ENOUGH,
    INFERRED,
    Forms,
    Laplace,
    Level,
    constant,
    degrees,
    laplace,
)
from bayescal.calibration.judging.taking import Taking
from bayescal.calibration.model.error_model import Shared
from bayescal.calibration.model.lens_model import LensModel
from bayescal.calibration.model.observations import Observations
from bayescal.calibration.model.strengths import COARSE, Strengths, strengths
from bayescal.inference.t_mixture import cholesky
from bayescal.prior.strength import Strength

AT_A_TIME = 50_000  # numbers of residuals
EXTRAPOLATED = 6.0  # deviations up to which a log determinant is, from steps of one
MUCH, MORE_STEPS = 0.5, 4  # share of squares that poses' first step may take; steps after it


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
    offered : Strengths or None
        Combinations of strengths; None for the usual ones.
    """

    model: LensModel
    data: Observations
    x: Array
    poses: Poses
    shared: Shared
    root: Array | None
    level: Level = INFERRED
    offered: Strengths | None = None

    @property
    def problem(self) -> Problem:
        """Itself, as an expansion's is what it expands."""
        return self

    @cached_property
    def stack(self) -> Stacked:
        """Residuals and derivatives at the reference."""
        return stacked(self.model, self.data, self.x, self.poses)

    def under(self, shared: Shared, root: Array | None) -> Problem:
        """Give the same lens and poses under another error model."""
        found = replace(self, shared=shared, root=root)
        found.__dict__["stack"] = self.stack  # residuals and derivatives know no error model
        return found

    @cached_property
    def views(self) -> Views:
        """Normal equations, poses eliminated."""
        return reduce(self.stack, self.data, self.shared, offsets=self.root is not None)

    @cached_property
    def reduced(self) -> Reduced:
        """Normal equations of the lens alone."""
        return eliminate(self.views.sums, self.root)

    @cached_property
    def taking(self) -> Taking:
        """What poses and offsets take of residuals."""
        return Taking(self.data, self.stack, self.shared, self.views, self.root)

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

    def moved(self, step: Array | float) -> Problem:
        """Linearise about another lens, ``(dimension,)``, the poses where they follow it."""
        x = self.x + step
        return replace(self, x=x, poses=self.poses_at(x))

    def log_prob(self, x: Array) -> Array:
        """Log likelihood times prior at lenses ``(n_draws, dimension)``; -inf where impossible."""
        return self.log_likelihood(x) + self.log_prior(x)

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

    def log_likelihood(self, x: Array) -> Array:
        """Log likelihood with poses, offsets and sigma integrated; -inf where impossible."""
        u = solve_triangular(self.spread, (x - self.x).T, lower=True).T
        return self.likelihood_of(self.squares(x), at_steps(u, self._log_det_response))

    def likelihood_of(self, squares: Array, log_det_change: Array) -> Array:
        """Log likelihood of smallest sums of squares, ``(n_draws,)``.

        Parameters
        ----------
        log_det_change : Array
            Of the poses' precisions from the reference, ``(n_draws,)``.
        """
        possible = np.isfinite(squares)
        found = self.level.log_density(np.where(possible, squares, 1.0), degrees(self.data))
        return np.where(possible, found + self.form.constant - log_det_change / 2, -np.inf)

    def squares(self, x: Array) -> Array:
        """Smallest sum of squares over poses and offsets at lenses ``(n_draws, dimension)``.

        Infinite where a point can't be seen.
        """
        parts = in_parts(x, self.data.pixels.size, AT_A_TIME)
        return np.concatenate([self._squares(part) for part in parts]) if parts else np.empty(0)

    def _squares(self, x: Array) -> Array:
        poses = self.poses_at(x)
        total, moves = self._profiled(x, poses)
        for _ in range(MORE_STEPS):
            at = np.flatnonzero(~np.isnan(moves[:, 0, 0]))
            if not len(at):
                break
            moved = Poses(poses.rotation[at], poses.translation[at]).moved(moves[at])
            poses.rotation[at], poses.translation[at] = moved.rotation, moved.translation
            total[at], moves[at] = self._profiled(x[at], moved)
        return total

    def _profiled(self, x: Array, poses: Poses) -> tuple[Array, Array]:
        """Give sums of squares one step of the poses on, and that step where it takes much.

        Infinite where a point can't be seen; steps ``(n_draws, n_views, 6)``, NaN where small. A
        sum of which a step takes much is given as it is before the step.
        """
        with np.errstate(all="ignore"):
            misfit, possible = residuals(self.model, self.data, x, poses)
            if not possible.all():
                misfit = np.where(possible[:, None, None, None], misfit, 0.0)
            arranged, weighted, taken = self.taking.of(misfit)
            whole = np.einsum("vasn,vasn->s", arranged, weighted)
            by_pose = taken[:, : 6 * self.data.n_views]
            much = np.einsum("si,si->s", by_pose, by_pose) > MUCH * whole
            total = np.where(much, whole, whole - np.einsum("si,si->s", taken, taken))
            possible &= np.isfinite(total)
            steps = by_pose.reshape(len(x), -1, 6)[..., None, :] @ self.taking.pose_whiteners
        moves = np.where((much & possible)[:, None, None], steps[..., 0, :], np.nan)
        return np.where(possible, np.maximum(total, 0.0), np.inf), moves

    def only(self, views: IntArray) -> Problem:
        """Give the same lens under the same error model for some of the views."""
        data, poses = self.data.only(views), self.poses.only(views)
        shared = self.shared.only(views, self.data.places_of(views))
        return replace(self, data=data, poses=poses, shared=shared)

    def between(self, views: slice) -> Problem:
        """Give neighbouring views of it, their poses following the lens as they do in all."""
        data, poses = self.data.between(views), self.poses.between(views)
        found = replace(self, data=data, poses=poses, shared=self.shared.between(views))
        found.__dict__["response"] = self.response[views]
        return found

    @cached_property
    def form(self) -> Forms:
        """What the lens alone leaves of the data."""
        log_dets = (np.array([each.log_det]) for each in (self.reduced, self.shared))
        nu, fixed = np.array([degrees(self.data)]), constant(self.data, *log_dets)
        return Forms.of(self.reduced.gram[None], nu, fixed)

    @cached_property
    def likely_strengths(self) -> Strengths:
        """Combinations of strengths that matter, of few: enough to find modes by."""
        prior = strengths(self.model, COARSE)
        return prior.only(self.laplace_over(prior).likely(ENOUGH))

    @cached_property
    def laplace(self) -> Laplace:
        """Posterior by linear algebra about the reference."""
        return self.laplace_over(self.offered or strengths(self.model))

    def laplace_over(self, prior: Strengths) -> Laplace:
        """Give it with other combinations of strengths."""
        return laplace(self.form, self.x, prior, self.level)[0]

    @cached_property
    def spread(self) -> Array:
        """Lower root of the lens's posterior covariance."""
        return cholesky(self.laplace.covariance)

    @cached_property
    def _log_det_response(self) -> tuple[Array, Array]:
        """First and second order of that change in each direction, from steps of 1 sd."""
        return both_sides(self.log_det_of(self.slopes))

    @cached_property
    def slopes(self) -> ByViews:
        """By the poses a step up and down each axis, as of `pose_slopes`, ``(2 d, ...)``."""
        x = self.x + np.concatenate([self.spread.T, -self.spread.T])

        def make(views: slice) -> Array:
            part = self.between(views)
            return pose_slopes(part.model, part.data, x, part.poses_at(x))

        numbers = len(x) * 12 * self.data.which.shape[1]
        return ByViews(make, self.data.n_views, numbers)

    def log_det_of(self, slopes: Iterable[tuple[slice, Array]]) -> Array:
        """Log determinant of the poses' precisions less that at the reference, ``(n_draws,)``."""
        n, total = self.data.which.shape[1], -self.views.log_det_poses.sum()
        for views, some in slopes:
            v = some.shape[1]
            rows = some.reshape(-1, v, n, 12)
            weighted = self.shared.between(views).apply(rows).reshape(-1, v, 2 * n, 6)
            blocks = rows.reshape(-1, v, 2 * n, 6).swapaxes(2, 3) @ weighted
            total = total + np.linalg.slogdet(blocks)[1].sum(axis=1)
        return np.where(np.isfinite(total), total, 0.0)


def both_sides(values: Array) -> tuple[Array, Array]:
    """First and second order of what is 0 at the middle, from steps up along each axis and down."""
    up, down = np.split(values, 2)
    return (up - down) / 2, (up + down) / 2


def at_steps(u: Array, orders: tuple[Array, Array]) -> Array:
    """Sum first and second order at steps ``(n, d)``, ``(n,)``; no further than is extrapolated.

    Along a ridge draws are tens of deviations away, where a parabola is of no use.
    """
    u = np.clip(u, -EXTRAPOLATED, EXTRAPOLATED)
    first, second = orders
    return np.asarray(u @ first + u**2 @ second)
