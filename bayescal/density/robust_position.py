r"""A linear family at a free camera position under a noise model without a closed form.

Nothing but tau can be integrated out: sampled are the position, and of each axis amplitudes,
sigma and what the noise has. A camera that moves along its axis takes the amplitudes with it;
so these are sampled as departures from a ridge estimate at the same position, its weights and
ridge fixed: a shift, whose volume is 1, after which they hardly depend on the position.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array, frozen, in_parts
from bayescal.density.drawn import DrawnAxis, LinearFamily
from bayescal.density.moving_axis import MovingAxis
from bayescal.density.plain_fits import CAUCHY, MAD
from bayescal.density.position_search import best_position, climb, linearised
from bayescal.density.robust_fits import LinearPixels, RobustFit, robust_fits
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.density.robust_pair import RobustPair, completed, taken_apart
from bayescal.prior.camera import PositionPrior

CHUNK = 400_000  # numbers held at once
FITS = 8  # robust fits whose modes are looked for
STEPS = 20  # of reweighting
RIDGE_TAU = 0.02  # strength that the ridge takes for an inferred tau
SETTLED = 1e-3  # prior sds that a reweighting moves the position


@dataclass(frozen=True, eq=False)
class Ridge:
    """A linear estimate of an axis's amplitudes at any design.

    Attributes
    ----------
    weights : Array
        Of the points, ``(n_points,)``, px^-2.
    precision : Array
        Of the prior, ``(size,)``, px^-2.
    mean : Array
        Of the prior, ``(size,)``, px.
    t : Array
        Pixels, ``(n_points,)``, px.
    """

    weights: Array
    precision: Array
    mean: Array
    t: Array

    def amplitudes(self, design: Array) -> Array:
        """Estimate from designs ``(m, n_points, size)``, ``(m, size)``, px."""
        weighted = design * self.weights[:, None]
        gram = weighted.swapaxes(1, 2) @ design + np.diag(self.precision)
        misfit = self.t - design @ self.mean
        slope = np.einsum("mnp,mn->mp", weighted, misfit)
        return np.asarray(self.mean + np.linalg.solve(gram, slope[:, :, None])[:, :, 0])


@dataclass(frozen=True, eq=False)
class Found:
    """Where a robust fit finds the camera, ``(3,)``, world units, and the ridge of each axis."""

    start: Array
    ridges: tuple[Ridge, Ridge]


@dataclass(frozen=True, eq=False)
class RobustFreePosition(LinearFamily):
    """Both axes at a camera position that is inferred, under any noise; a `SampledModel`.

    theta: the position in units of its prior's deviations from the start; then the coordinates
    of r and of c as in `RobustLinearModel`, the amplitudes as departures from the ridge
    estimate. Completed draws have ln tau of each axis at the end, where it is inferred.

    Attributes
    ----------
    axes : tuple of RobustLinearModel
        At the stated position: noise, priors and pixels stay as there.
    moving : tuple of MovingAxis
        The same axes as functions of the position.
    start : Array
        Where a robust fit finds the camera, ``(3,)``, world units.
    """

    axes: tuple[RobustLinearModel, RobustLinearModel]
    moving: tuple[MovingAxis, MovingAxis]
    prior: PositionPrior
    start: Array
    ridges: tuple[Ridge, Ridge]

    @classmethod
    def of(
        cls,
        axes: tuple[RobustLinearModel, RobustLinearModel],
        moving: tuple[MovingAxis, MovingAxis],
        prior: PositionPrior,
    ) -> RobustFreePosition:
        """Find where to start, and the weights that points have there."""
        found = robust_start(moving, prior)
        return cls(axes, moving, prior, found.start, found.ridges)

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        return 3 + sum(axis.dimension for axis in self.axes)

    @property
    def names(self) -> tuple[str, ...]:
        """Those of each axis, then the position."""
        return (*RobustPair(self.axes).names, "position_x", "position_y", "position_z")

    def position(self, theta: Array) -> Array:
        """Camera positions of sampled coordinates, ``(n_draws, 3)``, world units."""
        return self.start + theta[:, :3] * self.prior.sd

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior per unit of theta, ``(n_draws,)``, nat."""
        numbers = len(self.axes[0].t) * (max(axis.size for axis in self.axes) + 1)
        return np.concatenate([self._log_prob(part) for part in in_parts(theta, numbers, CHUNK)])

    def _log_prob(self, theta: Array) -> Array:
        possible = self.prior.possible(self.moving[0].world, self.position(theta))
        out = np.full(len(theta), -np.inf)
        inside = theta[possible]
        total = self.prior.log_density(self.position(inside)) + np.log(self.prior.sd).sum()
        for axis, (residuals, part) in zip(self.axes, self.located(inside), strict=True):
            total = total + axis.log_density(residuals, part).sum(axis=1) + axis.log_prior(part)
        out[possible] = np.where(np.isnan(total), -np.inf, total)
        return out

    def starts(self) -> Array:
        """Best starts of each axis at the robust position and at the stated one, and robust fits.

        Of the fits the most probable, at most `FITS`.
        """
        rows = []
        for position, most in ((self.start, 2), (self.prior.mean, 1)):
            u = (position - self.start) / self.prior.sd
            r, c = (self._axis_starts(i, position, most) for i in (0, 1))
            rows += [np.concatenate([u, first, second]) for first in r for second in c]
        fits = self._fits()
        likely = np.argsort(-self.log_prob(fits), kind="stable")[:FITS]
        return np.concatenate([rows, fits[likely]])

    def _fits(self) -> Array:
        """Robust fits of position and amplitudes together, in sampled coordinates."""
        step = 1e-30
        places = self.start + step * 1j * np.diag(self.prior.sd)
        count = len(self.axes[0].t)
        slopes = np.zeros((2, count, 3 + sum(axis.size for axis in self.axes)))
        residuals, deviations = np.empty((2, count)), np.ones((2, count))
        off, precision = [(self.start - self.prior.mean) / self.prior.sd], [np.ones(3)]
        at, column = [], 3
        for i, (axis, moving, ridge) in enumerate(
            zip(self.axes, self.moving, self.ridges, strict=True)
        ):
            moved = moving.design(places)
            b = ridge.amplitudes(moved[:1].real)[0]
            slopes[i, :, :3] = (moved.imag / step @ b).T
            slopes[i, :, column : column + axis.size] = moved[0].real
            residuals[i] = axis.t - moved[0].real @ b
            deviations[i] = 1.0 if axis.sd is None else axis.sd
            off.append(b - ridge.mean)
            precision.append(ridge.precision)
            at.append(b)
            column += axis.size
        each = np.concatenate(precision)
        r, c = self.axes
        pixels = LinearPixels(
            residuals, slopes, -each * np.concatenate(off), np.diag(each), deviations,
            (r.level, c.level),
        )  # fmt: skip
        fits = robust_fits(pixels, r.noise)
        return np.array([self._start(fit, np.concatenate(at)) for fit in fits])

    def _start(self, fit: RobustFit, at: Array) -> Array:
        """Give the sampled coordinates of a fit about amplitudes `at`."""
        u, b = fit.x[:3], at + fit.x[3:]
        parts = [u]
        for i, (axis, moving, ridge) in enumerate(
            zip(self.axes, self.moving, self.ridges, strict=True)
        ):
            own, b = b[: axis.size], b[axis.size :]
            with np.errstate(all="ignore"):  # where it has no image, nothing is found
                estimate = ridge.amplitudes(moving.design(self.position(u[None])))[0]
            scale = math.exp(float(fit.log_sigma[i]))
            parts.append(axis.start(own - estimate, scale, fit.eta[i]))
        return np.concatenate(parts)

    def _axis_starts(self, i: int, position: Array, most: int) -> Array:
        """Most probable starts of an axis at a position, in sampled coordinates."""
        axis = self.axes[i]
        design = self.moving[i].design(position[None])
        there = replace(axis, design=design[0])
        starts = there.starts()
        best = np.argsort(-there.log_prob(starts), kind="stable")[:most]
        chosen = starts[best]
        chosen[:, : axis.size] -= self.ridges[i].amplitudes(design)
        return chosen

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Append ln tau of each axis, drawn given its amplitudes, where it is inferred."""
        r, c = (part for _, part in self.located(theta))
        return completed(self.axes, theta, (r, c), rng)

    def report(self, full: Array) -> Array:
        """Monomial coefficients (px), sigma (px), tau, noise; position: ``(n_draws, n_names)``."""
        located = zip(self.axes, self.located(full), strict=True)
        columns = [axis.report(part) for axis, (_, part) in located]
        return np.concatenate([*columns, self.position(full)], axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c jointly, ``(n_draws, n_points)``."""
        located = zip(self.axes, self.located(full), strict=True)
        r, c = (axis.log_density(residuals, part) for axis, (residuals, part) in located)
        return np.asarray(r + c)

    def drawn(self, full: Array) -> tuple[DrawnAxis, DrawnAxis]:
        """Take r and c out of completed draws."""
        located = zip(self.axes, self.located(full), strict=True)
        r, c = (axis.drawn(part) for axis, (_, part) in located)
        return r, c

    def located(self, full: Array) -> list[tuple[Array, Array]]:
        """Residuals of each axis, ``(n_draws, n_points)``, px, and its own coordinates."""
        out = []
        apart = taken_apart(self.axes, full, 3)
        position = self.position(full)
        for axis, moving, ridge, part in zip(
            self.axes, self.moving, self.ridges, apart, strict=True
        ):
            design = moving.design(position)
            amplitudes = ridge.amplitudes(design) + part[:, : axis.size]
            residuals = axis.t - np.einsum("mnp,mp->mn", design, amplitudes)
            out.append((residuals, np.concatenate([amplitudes, part[:, axis.size :]], axis=1)))
        return out


def robust_start(axes: Sequence[MovingAxis], prior: PositionPrior) -> Found:
    """Find the camera by a robust fit, and the weights that points have there."""
    start, weighted = robust_position(axes, prior)
    r, c = (_ridge(axis) for axis in weighted)
    return Found(frozen(start), (r, c))


def robust_position(
    axes: Sequence[MovingAxis], prior: PositionPrior
) -> tuple[Array, list[MovingAxis]]:
    """Position that an M-estimate finds, and the axes as it weighs their points.

    Cauchy's weights (Holland & Welsch 1977) from the median residual of each axis, renewed
    until the position settles.

    Returns
    -------
    position : Array
        ``(3,)``, world units.
    weighted : list of MovingAxis
        With sigma known, 1, and each point's deviation the scale over the root of its weight.
    """
    position, weighted = best_position(axes, prior), list(axes)
    for _ in range(STEPS):
        weighted = [_reweighed(axis, position) for axis in axes]
        moved, _ = climb(weighted, prior, position, weigh=True)
        settled = np.abs((moved - position) / prior.sd).max() < SETTLED
        position = moved
        if settled:
            break
    return position, weighted


def _reweighed(axis: MovingAxis, position: Array) -> MovingAxis:
    """Give every point the deviation that its residual makes it worth."""
    e, _ = linearised(axis, position, slopes=False)
    for _ in range(STEPS):
        scale = max(float(np.median(np.abs(e))) / MAD, axis.noise.bounded(0.0, len(e)))
        root = 1 / np.sqrt(1 + (e / (CAUCHY * scale)) ** 2)
        own = 1.0 if axis.data.sd is None else axis.data.sd
        made = replace(axis, data=replace(axis.data, sd=own * scale / root))
        before, e = e, linearised(made, position, slopes=False)[0] * scale / root
        if np.abs(e - before).max() < SETTLED * scale:
            break
    return replace(made, noise=replace(axis.noise, source="known", value=1.0, bounds=None))


def _ridge(weighted: MovingAxis) -> Ridge:
    prior, sd = weighted.prior, weighted.data.sd
    assert sd is not None, "the weights are made so"
    tau = prior.tau if prior.tau is not None else RIDGE_TAU
    spread = prior.deviations(np.log([tau]))[0]
    return Ridge(frozen(sd**-2), frozen(spread**-2.0), prior.mean, weighted.data.t)
