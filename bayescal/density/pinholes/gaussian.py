"""A pinhole with Gaussian noise: both sigmas and tau are integrated out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.cameras.pinhole import POSE, PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.fit import PinholeFit
from bayescal.density.pinholes.laplace import Normal, laplace, likely_start
from bayescal.density.pinholes.pinhole import FRAME_TAU, PinholeModel
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.prior.camera import PinholePrior
from bayescal.prior.strength import Strength


@dataclass(frozen=True, eq=False)
class GaussianPinhole(PinholeModel):
    """Sampled are the whitened coordinates of the geometry alone.

    Completed draws have ln sigma of r and of c, where inferred, and ln tau behind them.
    """

    @classmethod
    def of(
        cls, geometry: PinholeGeometry, prior: PinholePrior, data: JointData, fit: PinholeFit
    ) -> GaussianPinhole:
        """Whiten about the most probable parameters."""
        frame = cls.frame_of(geometry, prior, data, fit)
        return cls(geometry, prior, data, fit, frame, GAUSSIAN)

    @staticmethod
    def frame_of(
        geometry: PinholeGeometry, prior: PinholePrior, data: JointData, fit: PinholeFit
    ) -> Normal:
        """Find the most probable parameters at the prior's strength, or at a middling one."""
        tau = prior.tau if prior.tau is not None else FRAME_TAU
        start = likely_start(geometry, prior, data, fit.free, tau)
        return laplace(geometry, prior, data, start, tau)

    def without(self, point: int | IntArray) -> GaussianPinhole:
        """Give the same model of the other points, its priors kept."""
        geometry, data = self.geometry, self.data
        theta = geometry.full(self.fit.free[None])
        rest = replace(geometry, world=np.delete(geometry.world, point, axis=0))
        # The anchor belongs to the points' centroid, which moves.
        free = rest.free(rest.to_anchor(theta, geometry.position(theta)))[0]
        sd = tuple(None if s is None else np.delete(s, point) for s in data.sd)
        others = JointData(np.delete(data.pixels, point, axis=1), (sd[0], sd[1]), data.levels)
        return GaussianPinhole.of(rest, self.prior, others, replace(self.fit, free=free))

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        return self.geometry.dimension

    def _log_density(self, theta: Array) -> Array:
        coordinates = self.coordinates(theta)
        residuals, possible = self.residuals(coordinates)
        total = self.log_volume + self.prior.log_density(self.geometry, coordinates)
        for i in (0, 1):
            total = total + self.log_marginal(i, self.rss(residuals, i))
        return np.where(possible, total, -np.inf)

    def starts(self) -> Array:
        """Where the frame is centred."""
        return np.zeros((1, self.dimension))

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw the sigmas and tau given the rest; logs, in further columns."""
        return np.concatenate([self._complete(part, rng) for part in self.in_parts(theta)])

    def _complete(self, theta: Array, rng: np.random.Generator) -> Array:
        coordinates = self.coordinates(theta)
        residuals, _ = self.residuals(coordinates)
        columns = [theta]
        for i, level in enumerate(self.data.levels):
            if level.bounds is not None:
                rss = self.rss(residuals, i)
                columns.append(Strength(level.log_bounds, self.data.n).draw(rss, rng))
        if self.infers_tau:
            q = ((coordinates[:, POSE:] / self.prior.width) ** 2).sum(axis=1)
            columns.append(self.prior.strength(self.geometry.order).draw(q, rng))
        return np.column_stack(columns)

    def coordinates(self, full: Array) -> Array:
        """All coordinates of the geometry at draws, ``(n_draws, 10 + order)``."""
        return self.geometry.full(self.frame.at(full[:, : self.geometry.dimension]))

    def levels(self, full: Array) -> list[tuple[Array, Array]]:
        """Ln sigma of r and of c, ``(n_draws,)``; there is no eta."""
        at, none, out = self.dimension, np.empty((len(full), 0)), []
        for level in self.data.levels:
            known = np.full(len(full), 0.0 if level.value is None else np.log(level.value))
            out.append((full[:, at] if level.value is None else known, none))
            at += level.value is None
        return out

    def rss(self, residuals: Array, axis: int) -> Array:
        """Weighted sum of squares of an axis, ``(n_draws,)``."""
        return np.asarray(((residuals[:, axis] / self.data.deviations[axis]) ** 2).sum(axis=1))

    def log_marginal(self, axis: int, rss: Array) -> Array:
        """Log likelihood of an axis, sigma integrated out where it is inferred, ``(n_draws,)``."""
        level, n = self.data.levels[axis], self.data.n
        if level.value is None:
            averaged = Strength(level.log_bounds, n).log_density(rss)
            return np.asarray(averaged - self._log_sd[axis])
        constant = -n / 2 * LOG_2PI - n * np.log(level.value) - self._log_sd[axis]
        return np.asarray(constant - rss / level.value**2 / 2)

    @cached_property
    def _log_sd(self) -> Array:
        return np.asarray(np.log(self.data.deviations).sum(axis=1))
