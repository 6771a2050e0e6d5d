r"""A linear family whose camera position is not known: coefficients eliminated exactly.

At a given position every coefficient, sigma and tau integrates out in closed form, axis by
axis (`bayescal.linear.evidence`); what is left to sample are the position's three numbers.
The basis keeps the domain of the stated position, so that the prior of the amplitudes, which
is stated in px at the edges of the domain, means the same wherever the camera is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bayescal.arrays import Array, IntArray, in_parts
from bayescal.density.drawn import DrawnAxis, LinearFamily
from bayescal.density.moving_axis import MovingAxis, Rows
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.prior.camera import PositionPrior

CHUNK = 4_000_000  # numbers held at once


@dataclass(frozen=True, eq=False)
class FreePositionModel(LinearFamily):
    """Both axes of a linear family at a camera position that is inferred.

    Attributes
    ----------
    axes : tuple of MovingAxis
        Of r and of c.
    start : Array
        Where the likelihood is highest, ``(3,)``, world units.
    """

    axes: tuple[MovingAxis, MovingAxis]
    prior: PositionPrior
    start: Array

    def without(self, point: int | IntArray) -> FreePositionModel:
        """Give the same model of the other points, its basis and priors kept."""
        r, c = self.axes
        return replace(self, axes=(r.without(point), c.without(point)))

    @property
    def dimension(self) -> int:
        """Three: the position in units of its prior's deviations from the start."""
        return 3

    @property
    def names(self) -> tuple[str, ...]:
        """Coefficients, sigma and tau of each axis, then the position."""
        out: list[str] = []
        for axis in self.axes:
            suffixes = axis.data.monomials(axis.order).suffixes
            out += [f"{axis.data.symbol}_{powers}" for powers in suffixes]
            out += [f"{axis.noise.parameter}_{axis.data.axis}"] * (axis.noise.value is None)
            out += [f"tau_{axis.data.axis}"] * axis.prior.infers_tau
        return (*out, "position_x", "position_y", "position_z")

    @cached_property
    def _offsets(self) -> tuple[Array, Array]:
        r, c = self.axes
        return r.offsets(self.start), c.offsets(self.start)

    def position(self, theta: Array) -> Array:
        """Camera positions of sampled coordinates, ``(n_draws, 3)``, world units."""
        return self.start + theta[:, :3] * self.prior.sd

    def log_prob(self, theta: Array) -> Array:
        """Log evidence of both axes at a position, times its prior, ``(n_draws,)``."""
        position = self.position(theta)
        out = np.full(len(theta), -np.inf)
        inside = np.flatnonzero(self.prior.possible(self.axes[0].world, position))
        for part in self._in_chunks(inside):
            out[part] = self.prior.log_density(position[part]) + np.log(self.prior.sd).sum()
            for axis, offsets in zip(self.axes, self._offsets, strict=True):
                out[part] += axis.log_evidence(position[part], offsets)
        return np.where(np.isfinite(out), out, -np.inf)

    def _in_chunks(self, rows: Rows) -> list[Rows]:
        """Split rows of draws so that their design matrices fit into memory."""
        return in_parts(rows, len(self.axes[0].world) * (self.axes[0].size + 1), CHUNK)

    def starts(self) -> Array:
        """Give the likelihood's maximum and the stated position, ``(2, 3)``."""
        return np.stack([np.zeros(3), (self.prior.mean - self.start) / self.prior.sd])

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw coefficients, sigma and tau of both axes given the position."""
        columns = [theta]
        for axis, offsets in zip(self.axes, self._offsets, strict=True):
            amplitudes, log_sigma, log_tau = axis.draw(rng, self.position(theta), offsets)
            columns += [amplitudes, log_sigma[:, None], log_tau[:, None]]
        return np.concatenate(columns, axis=1)

    def report(self, full: Array) -> Array:
        """Monomial coefficients (px), sigma (px), tau and position, ``(n_draws, n_names)``."""
        columns = []
        for axis, (amplitudes, log_sigma, log_tau) in zip(self.axes, self.parts(full), strict=True):
            columns.append(amplitudes @ axis.framed.monomials(axis.order).lead(axis.order).T)
            if axis.noise.value is None:
                columns.append(np.exp(log_sigma)[:, None])
            if axis.prior.infers_tau:
                columns.append(np.exp(log_tau)[:, None])
        return np.concatenate([*columns, self.position(full)], axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c jointly, ``(n_draws, n_points)``."""
        position, total = self.position(full), np.zeros(1)
        for axis, (amplitudes, log_sigma, _) in zip(self.axes, self.parts(full), strict=True):
            total = total + axis.log_likelihood(position, amplitudes, log_sigma)
        return np.asarray(total)

    def log_left_out(self, full: Array) -> Array:
        """Log density of each point given all others and the draw, ``(n_draws, n_points)``.

        With the coefficients integrated out it varies far less among the draws than the
        likelihood: weights for a point left out are those of position, sigma and tau alone.
        """
        position, parts = self.position(full), self.parts(full)
        out = np.zeros((len(full), len(self.axes[0].world)))
        for part in self._in_chunks(np.arange(len(full))):
            for axis, (_, log_sigma, log_tau) in zip(self.axes, parts, strict=True):
                out[part] += axis.log_left_out(position[part], log_sigma[part], log_tau[part])
        return out

    def drawn(self, full: Array) -> tuple[DrawnAxis, DrawnAxis]:
        """Take r and c out of completed draws."""
        none = np.empty((len(full), 0))
        r, c = (
            DrawnAxis(amplitudes, log_sigma, none, GAUSSIAN, axis.data.sd)
            for axis, (amplitudes, log_sigma, _) in zip(self.axes, self.parts(full), strict=True)
        )
        return r, c

    def parts(self, full: Array) -> list[tuple[Array, Array, Array]]:
        """Amplitudes, ln sigma and ln tau of r, and of c."""
        out, at = [], 3
        for axis in self.axes:
            p = axis.size
            out.append((full[:, at : at + p], full[:, at + p], full[:, at + p + 1]))
            at += p + 2
        return out
