r"""A pinhole under noise without a closed form.

Sampled are, after the geometry, of r and of c the probit of where ln sigma lies between its
bounds (where inferred) and the noise's eta, and last the probit of where ln tau does. With tau
integrated out the displacements' density is a spike on a plateau, which no few components
follow: at order 3 of the thesis data the evidence came out 0.6 nat too low, under Student-t
noise. Given tau they are nearly normal. So the geometry's coordinates are whitened by a Laplace
approximation *that tau changes*: with precision I at the frame's own tau_0 and A the slopes of
the displacements in units of the image's width, it is I + c A'A at another, c = tau^-2 -
tau_0^-2. The frame stands at the most probable of the robust fits, its points weighed as there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.pinhole import PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.fit import PinholeFit
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.laplace import Normal, laplace, likely_start, linear_pixels
from bayescal.density.pinholes.pinhole import FRAME_TAU, PinholeModel
from bayescal.density.robust_fits import RobustFit, robust_fits
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.prior.camera import PinholePrior
from bayescal.prior.probit import log_prior, log_value, probit_of

FITS = 8  # whose modes are looked for
LEAST = 1e-6  # weight of a point in the frame
KNOWN = NoiseLevel.known(1.0)
NARROWEST = 1e-6  # precision of the widest direction at the largest tau; rounding may take it


@dataclass(frozen=True, eq=False)
class Framed:
    """Where a robust pinhole is whitened, and the fits its modes are looked for from."""

    frame: Normal
    fits: tuple[RobustFit, ...]


@dataclass(frozen=True, eq=False)
class RobustPinhole(PinholeModel):
    """Sampled are geometry, sigma and shape of the noise of each axis, and tau.

    Completed draws have ln tau behind them.

    Attributes
    ----------
    fits : tuple of RobustFit
        Where modes are looked for, from the frame's mean in its whitened coordinates.
    """

    fits: tuple[RobustFit, ...]

    @classmethod
    def framed(
        cls,
        geometry: PinholeGeometry,
        prior: PinholePrior,
        data: JointData,
        fit: PinholeFit,
        noise: NoiseModel,
    ) -> Framed:
        """Find the robust fits, in the coordinates whitened about the most probable one."""
        frame = GaussianPinhole.of(geometry, prior, data, fit).frame
        at_zero = [
            RobustFit(np.zeros(geometry.dimension), np.log(0.7 * fit.sigma), np.stack([eta, eta]))
            for eta in noise.starts()
        ]
        found = robust_fits(linear_pixels(geometry, data, frame), noise)
        plain = cls(geometry, prior, data, fit, frame, noise, (*at_zero, *found))
        values = plain.log_prob(plain.starts())
        best = plain.fits[int(np.argmax(values))]
        moved = plain._weighed(best)
        likely = np.argsort(-values[len(at_zero) :], kind="stable")[:FITS]
        kept = [*at_zero, *(found[i] for i in likely)]
        fits = tuple(replace(f, x=moved.whitened(frame.at(f.x))) for f in kept)
        return Framed(moved, fits)

    def _weighed(self, fit: RobustFit) -> Normal:
        """Laplace approximation with each point weighed as a fit weighs it."""
        data, tau = self.data, self._frame_tau
        free = self.frame.at(fit.x)
        residuals, _ = self.residuals(self.geometry.full(free[None]))
        sd = []
        for i in (0, 1):
            level, eta = fit.log_sigma[i : i + 1], fit.eta[i : i + 1]
            weight = self.noise.weight(residuals[:, i], level, eta, data.sd[i])[0]
            sd.append(np.exp(level) * data.deviations[i] / np.sqrt(np.maximum(weight, LEAST)))
        weighed = JointData(data.pixels, (sd[0], sd[1]), (KNOWN, KNOWN))
        start = likely_start(self.geometry, self.prior, weighed, free, tau)
        return laplace(self.geometry, self.prior, weighed, start, tau)

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        noise = sum(self.data.inferred) + 2 * self.noise.dimension
        return self.geometry.dimension + noise + self.infers_tau

    def _log_density(self, theta: Array) -> Array:
        x, log_narrowing = self._moved(theta)
        coordinates = self.geometry.full(self.frame.at(x))
        residuals, possible = self.residuals(coordinates)
        log_tau = self._log_tau(theta) if self.infers_tau else None
        total = self.log_volume + log_narrowing
        total = total + self.prior.log_density(self.geometry, coordinates, log_tau)
        for i, (log_sigma, eta) in enumerate(self.levels(theta)):
            sd, residual = self.data.sd[i], residuals[:, i]
            density = self.noise.log_density(residual, log_sigma, eta, sd).sum(axis=1)
            total = total + density + self.noise.log_prior(eta)
        total = total + self._log_probit_prior(theta)
        return np.where(possible, total, -np.inf)

    def starts(self) -> Array:
        """Give the fits in sampled coordinates, tau that of the frame."""
        return np.array([self._start(fit) for fit in self.fits])

    def _start(self, fit: RobustFit) -> Array:
        parts = [fit.x]
        for i, level in enumerate(self.data.levels):
            if level.bounds is not None:
                parts.append(np.array([level.probit(math.exp(float(fit.log_sigma[i])))]))
            parts.append(fit.eta[i])
        if self.infers_tau:
            parts.append(np.array([probit_of(math.log(self._frame_tau), self._tau_bounds)]))
        return np.concatenate(parts)

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:  # noqa: ARG002
        """Append ln tau; nothing was integrated out."""
        return np.column_stack([theta, self._log_tau(theta)]) if self.infers_tau else theta

    def coordinates(self, full: Array) -> Array:
        """All coordinates of the geometry at draws, ``(n_draws, 10 + order)``."""
        x, _ = self._moved(full[:, : self.dimension])
        return self.geometry.full(self.frame.at(x))

    def levels(self, full: Array) -> list[tuple[Array, Array]]:
        """Ln sigma ``(n_draws,)`` and eta ``(n_draws, noise.dimension)`` of r and of c."""
        at, q, out = self.geometry.dimension, self.noise.dimension, []
        for level in self.data.levels:
            if level.value is None:
                log_sigma, at = level.log_sigma(full[:, at]), at + 1
            else:
                log_sigma = np.full(len(full), np.log(level.value))
            out.append((log_sigma, full[:, at : at + q]))
            at += q
        return out

    def _log_probit_prior(self, theta: Array) -> Array:
        """Log prior of the inferred sigmas and tau per unit of their probits, ``(n_draws,)``."""
        at, total = self.geometry.dimension, np.zeros(len(theta))
        for level in self.data.levels:
            if level.value is None:
                total += level.log_probit_prior(theta[:, at])
                at += 1
            at += self.noise.dimension
        return total + log_prior(theta[:, at]) if self.infers_tau else total

    @property
    def _frame_tau(self) -> float:
        return FRAME_TAU if self.prior.tau is None else self.prior.tau

    @property
    def _tau_bounds(self) -> tuple[float, float]:
        return self.prior.strength(self.geometry.order).log_bounds

    def _log_tau(self, theta: Array) -> Array:
        return log_value(theta[:, self.dimension - 1], self._tau_bounds)

    @cached_property
    def _distortion(self) -> tuple[Array, Array, Array]:
        """Eigenvalues and vectors of A'A, and A'a along these; a: displacements of the mean."""
        rows = slice(self.geometry.dimension - self.geometry.order, self.geometry.dimension)
        slopes = self.frame.root[rows] / self.prior.width
        values, vectors = np.linalg.eigh(slopes.T @ slopes)
        return values, vectors, vectors.T @ (slopes.T @ self.frame.mean[rows]) / self.prior.width

    def _moved(self, theta: Array) -> tuple[Array, Array]:
        """Coordinates of the frame at sampled ones, and the log volume of the former per latter.

        The precision 1 + c values of each direction lies between 0 and 1 at a tau above the
        frame's: the prior is a part of the frame's precision.
        """
        u = theta[:, : self.geometry.dimension]
        if not self.infers_tau:
            return u, np.zeros(len(theta))
        values, vectors, pull = self._distortion
        c = (np.exp(-2 * self._log_tau(theta)) - self._frame_tau**-2)[:, None]
        precision = np.maximum(1 + c * values, NARROWEST)
        along = (u @ vectors) / np.sqrt(precision) - c * pull / precision
        return along @ vectors.T, -np.log(precision).sum(axis=1) / 2
