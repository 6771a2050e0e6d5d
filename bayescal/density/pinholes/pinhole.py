"""The pinhole as a likelihood model of both axes' pixels: what any noise has in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, in_parts
from bayescal.cameras.pinhole import PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.fit import PinholeFit
from bayescal.density.pinholes.laplace import Normal
from bayescal.noise.model import NoiseModel
from bayescal.points.setup import AXES
from bayescal.prior.camera import PinholePrior

# tau about which the sampled coordinates are whitened where it is inferred.
FRAME_TAU = 0.02
# Pixel values held at once: all at once costs many points memory, and time with it.
CHUNK = 400_000


@dataclass(frozen=True, eq=False)
class PinholeModel(ABC):
    """A pinhole of one order: r and c jointly, one noise level each; a `SampledModel`.

    Sampled coordinates begin with the free ones of the geometry, whitened by a Laplace
    approximation. Completed ones end with ln tau, where it is inferred.

    Attributes
    ----------
    fit : PinholeFit
        Maximum likelihood under Gaussian noise.
    frame : Normal
        Whitens: free = mean + root x.
    noise : NoiseModel
        Shape of the noise, of each axis on its own.
    """

    geometry: PinholeGeometry
    prior: PinholePrior
    data: JointData
    fit: PinholeFit
    frame: Normal
    noise: NoiseModel

    @property
    def infers_tau(self) -> bool:
        """Whether the distortion's strength is drawn."""
        return self.geometry.order > 0 and self.prior.tau is None

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Number of sampled coordinates."""

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
        with np.errstate(all="ignore"):
            values = np.concatenate([self._log_density(part) for part in self.in_parts(theta)])
        return np.where(np.isfinite(values), values, -np.inf)

    def in_parts(self, draws: Array) -> list[Array]:
        """Split draws so that the pixels of each part fit into memory."""
        return in_parts(draws, 2 * self.data.n, CHUNK)

    @abstractmethod
    def _log_density(self, theta: Array) -> Array:
        """Log density of sampled coordinates, ``(n_draws,)``; anything but finite where none is."""

    @abstractmethod
    def starts(self) -> Array:
        """Places to search for modes from, ``(n_starts, dimension)``."""

    @abstractmethod
    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Append what was integrated out, drawn, and ln tau, ``(n_draws, n_full)``."""

    @abstractmethod
    def coordinates(self, full: Array) -> Array:
        """All coordinates of the geometry at completed draws, ``(n_draws, 10 + order)``."""

    @abstractmethod
    def levels(self, full: Array) -> list[tuple[Array, Array]]:
        """Ln sigma ``(n_draws,)`` and eta ``(n_draws, noise.dimension)`` of r and of c."""

    def report(self, full: Array) -> Array:
        """Parameters in px, degrees and world units, ``(n_draws, n_names)``."""
        geometry, theta = self.geometry, self.coordinates(full)
        columns = [np.exp(theta[:, :2]), theta[:, 2:4], np.degrees(theta[:, 4:7])]
        if geometry.fixed is None:
            columns.append(geometry.position(theta))
        columns.append(geometry.coefficients(theta))
        for (log_sigma, eta), level in zip(self.levels(full), self.data.levels, strict=True):
            if level.value is None:
                columns.append(np.exp(log_sigma)[:, None])
            columns.append(self.noise.report(eta))
        if self.infers_tau:
            columns.append(np.exp(full[:, -1:]))
        return np.concatenate(columns, axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c jointly, ``(n_draws, n_points)``."""
        return np.concatenate([self._log_likelihood(part) for part in self.in_parts(full)])

    def _log_likelihood(self, full: Array) -> Array:
        residuals, _ = self.residuals(self.coordinates(full))
        total = np.zeros(residuals[:, 0].shape)
        for i, (log_sigma, eta) in enumerate(self.levels(full)):
            total += self.noise.log_density(residuals[:, i], log_sigma, eta, self.data.sd[i])
        return total

    def residuals(self, theta: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Measured less predicted pixels, and which draws see all points.

        Parameters
        ----------
        theta : Array
            All coordinates of the geometry, ``(n_draws, 10 + order)``.

        Returns
        -------
        residuals : Array
            ``(n_draws, 2, n_points)``, px; 0 where a point is not seen.
        possible : ndarray of bool
            ``(n_draws,)``.
        """
        pixels, depth = self.geometry.project(theta)
        residuals = self.data.pixels - pixels
        seen = (depth > 0).all(axis=1) & np.isfinite(residuals).all(axis=(1, 2))
        possible: NDArray[np.bool_] = np.asarray(seen)
        return np.where(possible[:, None, None], residuals, 0.0), possible

    @cached_property
    def log_volume(self) -> float:
        """Log volume of the free coordinates per unit of the frame's."""
        return float(np.log(np.diag(self.frame.root)).sum())
