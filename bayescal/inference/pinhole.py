"""The pinhole as a likelihood model of both axes' pixels, for the general sampler."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.inference.pinhole_fit import LOG_2PI, JointData, PinholeFit
from bayescal.inference.pinhole_laplace import Normal, laplace, likely_start, linear_pixels
from bayescal.inference.robust_fits import robust_fits
from bayescal.models.camera_prior import PinholePrior
from bayescal.models.noise.gaussian import Gaussian
from bayescal.models.noise.model import NoiseModel
from bayescal.models.pinhole import POSE, PinholeGeometry
from bayescal.models.strength import Strength
from bayescal.points.setup import AXES

# tau about which the sampled coordinates are whitened where it is inferred.
FRAME_TAU = 0.02
# Robust fits whose modes are looked for.
FITS = 8
# Pixel values held at once: all at once costs many points memory, and time with it.
CHUNK = 400_000


@dataclass(frozen=True, eq=False)
class PinholeModel:
    """A pinhole of one order: r and c jointly, one noise level each.

    With Gaussian noise both sigmas, where inferred, are integrated out of `log_prob`, and tau
    is under any noise; `complete` draws them. Sampled coordinates: the free ones of the
    geometry, whitened by a Laplace approximation; with other noise then the probit of where ln
    sigma (where inferred) lies between its bounds and eta of r, and of c.

    Attributes
    ----------
    geometry : PinholeGeometry
    prior : PinholePrior
    data : JointData
    fit : PinholeFit
        Where the search for modes starts.
    frame : Normal
        Whitens: free = mean + root u.
    noise : NoiseModel
        Shape of the noise, of each axis on its own.
    """

    geometry: PinholeGeometry
    prior: PinholePrior
    data: JointData
    fit: PinholeFit
    frame: Normal
    noise: NoiseModel = field(default_factory=Gaussian)

    @classmethod
    def of(
        cls,
        geometry: PinholeGeometry,
        prior: PinholePrior,
        data: JointData,
        fit: PinholeFit,
        noise: NoiseModel | None = None,
    ) -> PinholeModel:
        """Whiten about the most probable parameters at the prior's strength, or a middling one."""
        tau = prior.tau if prior.tau is not None else FRAME_TAU
        start = likely_start(geometry, prior, data, fit.free, tau)
        frame = laplace(geometry, prior, data, start, tau)
        return cls(geometry, prior, data, fit, frame, noise if noise is not None else Gaussian())

    def without(self, point: int) -> PinholeModel:
        """Give the same model of the other points, its priors kept."""
        geometry, data = self.geometry, self.data
        theta = geometry.full(self.fit.free[None])
        rest = replace(geometry, world=np.delete(geometry.world, point, axis=0))
        # The anchor belongs to the points' centroid, which moves.
        free = rest.free(rest.to_anchor(theta, geometry.position(theta)))[0]
        sd = tuple(None if s is None else np.delete(s, point) for s in data.sd)
        others = JointData(np.delete(data.pixels, point, axis=1), (sd[0], sd[1]), data.levels)
        fit = replace(self.fit, free=free)
        return PinholeModel.of(rest, self.prior, others, fit, self.noise)

    def free(self, theta: Array) -> Array:
        """Free coordinates of sampled (or completed) ones, ``(n_draws, geometry.dimension)``."""
        return self.frame.mean + theta[:, : self.geometry.dimension] @ self.frame.root.T

    @property
    def gaussian(self) -> bool:
        """Whether sigma has a closed form."""
        return self.noise.name == "gaussian"

    @property
    def infers_tau(self) -> bool:
        """Whether the distortion's strength is drawn."""
        return self.geometry.order > 0 and self.prior.tau is None

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        if self.gaussian:
            return self.geometry.dimension
        return self.geometry.dimension + sum(self.data.inferred) + 2 * self.noise.dimension

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the reported parameters."""
        out = ["focal_r", "focal_c", "centre_r", "centre_c"]
        out += ["rotation_x", "rotation_y", "rotation_z"]
        if self.geometry.fixed is None:
            out += ["position_x", "position_y", "position_z"]
        out += [f"k_{j + 1}" for j in range(self.geometry.order)]
        for axis, level in zip(AXES, self.data.levels, strict=True):
            out += [f"{level.parameter}_{axis}"] * (level.value is None)
            out += [f"{name}_{axis}" for name in self.noise.parameters]
        return (*out, *(("tau",) * self.infers_tau))

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior, ``(n_draws,)``, what has a closed form integrated out."""
        step = max(1, CHUNK // (2 * self.data.n))
        parts = [theta[i : i + step] for i in range(0, len(theta), step)]
        return np.concatenate([self._log_prob(part) for part in parts])

    def _log_prob(self, theta: Array) -> Array:
        with np.errstate(all="ignore"):
            full = self.geometry.full(self.free(theta))
            residuals, possible = self._residuals(full)
            total = self._log_frame + self.prior.log_density(self.geometry, full)
            if self.gaussian:
                for i in range(2):
                    total = total + self._log_marginal(i, self._rss(residuals, i))
            else:
                for i, (log_sigma, eta) in enumerate(self._noise(theta)):
                    sd, residual = self.data.sd[i], residuals[:, i]
                    density = self.noise.log_density(residual, log_sigma, eta, sd).sum(axis=1)
                    total = total + density + self.noise.log_prior(eta)
                total = total + self._log_probit_prior(theta)
        return np.asarray(np.where(possible & np.isfinite(total), total, -np.inf))

    def starts(self) -> Array:
        """Where the frame is centred; under other noise with each of its starts, and robust fits.

        Of the fits the most probable, at most `FITS`.
        """
        free = np.zeros(self.geometry.dimension)
        if self.gaussian:
            return free[None]
        log_sigma = np.log(0.7 * self.fit.sigma)
        plain = [self._start(free, log_sigma, (eta, eta)) for eta in self.noise.starts()]
        fits = robust_fits(linear_pixels(self.geometry, self.data, self.frame), self.noise)
        found = np.array([self._start(fit.x, fit.log_sigma, fit.eta) for fit in fits])
        likely = np.argsort(-self.log_prob(found), kind="stable")[:FITS]
        return np.concatenate([plain, found[likely]])

    def _start(self, u: Array, log_sigma: Array, eta: Sequence[Array] | Array) -> Array:
        parts = [u]
        for level, s, e in zip(self.data.levels, log_sigma.tolist(), eta, strict=True):
            if level.bounds is not None:
                parts.append(np.array([level.probit(math.exp(s), 0.001)]))
            parts.append(e)
        return np.concatenate(parts)

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw the sigmas (Gaussian noise) and tau given the rest; logs, in further columns."""
        full = self.geometry.full(self.free(theta))
        columns = [theta]
        if self.gaussian:
            residuals, _ = self._residuals(full)
            for i, level in enumerate(self.data.levels):
                if level.bounds is not None:
                    rss = self._rss(residuals, i)
                    columns.append(Strength(level.log_bounds, self.data.n).draw(rss, rng))
        if self.infers_tau:
            q = ((full[:, POSE:] / self.prior.width) ** 2).sum(axis=1)
            columns.append(self.prior.strength(self.geometry.order).draw(q, rng))
        return np.column_stack(columns)

    def report(self, full: Array) -> Array:
        """Parameters in px, degrees and world units, ``(n_draws, n_names)``."""
        geometry = self.geometry
        theta = geometry.full(self.free(full))
        columns = [np.exp(theta[:, :2]), theta[:, 2:4], np.degrees(theta[:, 4:7])]
        if geometry.fixed is None:
            columns.append(geometry.position(theta))
        columns.append(geometry.coefficients(theta))
        for (log_sigma, eta), level in zip(self._noise(full), self.data.levels, strict=True):
            if level.value is None:
                columns.append(np.exp(log_sigma)[:, None])
            columns.append(self.noise.report(eta))
        if self.infers_tau:
            columns.append(np.exp(full[:, -1:]))
        return np.concatenate(columns, axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c together, ``(n_draws, n_points)``."""
        theta = self.geometry.full(self.free(full))
        residuals, _ = self._residuals(theta)
        total = np.zeros(residuals[:, 0].shape)
        for i, (log_sigma, eta) in enumerate(self._noise(full)):
            total += self.noise.log_density(residuals[:, i], log_sigma, eta, self.data.sd[i])
        return total

    def bad_probability(self, full: Array) -> Array | None:
        """Probability that each pixel value is bad, ``(2, n_points)``, averaged over draws."""
        theta = self.geometry.full(self.free(full))
        residuals, _ = self._residuals(theta)
        out = []
        for i, (log_sigma, eta) in enumerate(self._noise(full)):
            found = self.noise.bad_probability(residuals[:, i], log_sigma, eta, self.data.sd[i])
            if found is None:
                return None
            out.append(found.mean(axis=0))
        return np.stack(out)

    def _residuals(self, full: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Measured less predicted, ``(n_draws, 2, n_points)``, and which draws see all points."""
        pixels, depth = self.geometry.project(full)
        residuals = self.data.pixels - pixels
        seen = (depth > 0).all(axis=1) & np.isfinite(residuals).all(axis=(1, 2))
        possible: NDArray[np.bool_] = np.asarray(seen)
        return np.where(possible[:, None, None], residuals, 0.0), possible

    def _rss(self, residuals: Array, axis: int) -> Array:
        return np.asarray(((residuals[:, axis] / self.data.deviations[axis]) ** 2).sum(axis=1))

    def _log_marginal(self, axis: int, rss: Array) -> Array:
        """Gaussian log likelihood of an axis, sigma integrated out where it is inferred."""
        level, n = self.data.levels[axis], self.data.n
        if level.value is None:
            averaged = Strength(level.log_bounds, n).log_density(rss)
            return np.asarray(averaged - self._log_sd[axis])
        constant = -n / 2 * LOG_2PI - n * np.log(level.value) - self._log_sd[axis]
        return np.asarray(constant - rss / level.value**2 / 2)

    @cached_property
    def _log_frame(self) -> float:
        """Log volume of the free coordinates per unit of the sampled ones."""
        return float(np.log(np.diag(self.frame.root)).sum())

    @cached_property
    def _log_sd(self) -> Array:
        return np.asarray(np.log(self.data.deviations).sum(axis=1))

    def _noise(self, columns: Array) -> list[tuple[Array, Array]]:
        """Give ln sigma and eta of each axis."""
        at, q, out = self.geometry.dimension, self.noise.dimension, []
        for level in self.data.levels:
            if level.value is None:
                log_sigma = columns[:, at]  # as `complete` draws it, else a probit
                if not self.gaussian:
                    log_sigma = level.log_sigma(log_sigma)
                at += 1
            else:
                log_sigma = np.full(len(columns), np.log(level.value))
            out.append((log_sigma, columns[:, at : at + q]))
            at += q
        return out

    def _log_probit_prior(self, theta: Array) -> Array:
        """Log prior of the inferred sigmas per unit of their probits, ``(n_draws,)``."""
        at, total = self.geometry.dimension, np.zeros(len(theta))
        for level in self.data.levels:
            if level.value is None:
                total += level.log_probit_prior(theta[:, at])
                at += 1
            at += self.noise.dimension
        return total
