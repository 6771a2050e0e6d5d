"""A member whose mapping is a pair of polynomials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.prediction.calibrated.members import (
    Ahead,
    BoolArray,
    Estimate,
    Member,
    Moments,
    Parameters,
    Rays,
    Solutions,
)
from bayescal.prediction.calibrated.noise import NewNoise
from bayescal.prediction.calibrated.polynomial_inverse import continued, monotone, newton, solved
from bayescal.prediction.calibrated.polynomial_map import PolynomialMap


@dataclass(frozen=True, eq=False)
class PolynomialMember(PolynomialMap):
    """r and c as polynomials of x/z and y/z, about a camera position.

    Parameters: the Legendre amplitudes of r, those of c (px), then the camera position where it
    is not exact (world units).

    Attributes
    ----------
    position : Array or None
        Camera position where it is exact, ``(3,)``.
    side : float
        1 or -1: the sign of z less the camera's, of points in front of it.
    """

    position: Array | None
    side: float
    name: str
    parameters: Parameters
    noise: NewNoise
    estimate: Estimate | None = None

    @property
    def posed(self) -> bool:
        """It has a place in the world."""
        return True

    @property
    def n_free(self) -> int:
        """Every parameter moves predictions."""
        return len(self._mean[0])

    @property
    def _mean(self) -> Array:
        return self.parameters.mean[None]

    @property
    def linear(self) -> Callable[[Array], Moments] | None:
        """Exact moments where the position is."""
        return None if self.position is None else self._exact

    def _exact(self, world: Array) -> Moments:
        scaled, front = self._placed(self._mean, world)
        mean = self.at_scaled(self._mean, scaled)[0]
        variance, at = np.empty_like(mean), 0
        for axis in (0, 1):
            p = self.columns(axis)
            spread = self.design(scaled[0], axis) @ self.parameters.root[at : at + p]
            variance[:, axis] = np.einsum("nj,nj->n", spread, spread)
            at += p
        return Moments(mean, np.sqrt(variance), front[0])

    def positions(self, theta: Array) -> Array:
        """Camera positions, ``(m, 3)``, world units."""
        if self.position is not None:
            return np.broadcast_to(self.position, (len(theta), 3))
        return theta[:, -3:]

    def _placed(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Scaled regressors, ``(m, n, 2)``, and which points are in front; m is 1 where exact."""
        places = self.positions(theta if self.position is None else theta[:1])
        away = world - places[:, None, :]
        front = away[..., 2] * self.side > 0
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scaled = self.scaled(away[..., :2] / away[..., 2:])
        return np.where(front[..., None], scaled, 0.0), front

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels of world points, and which are in front of the camera."""
        scaled, front = self._placed(theta, world)
        pixels = self.at_scaled(theta, scaled)
        return pixels, np.broadcast_to(front, pixels.shape[:2])

    def project_with_slopes(self, theta: Array, world: Array) -> tuple[Array, Array, BoolArray]:
        """Pixels, their derivatives by points, and which are in front."""
        scaled, front = self._placed(theta, world)
        pixels, slope = self.with_slopes(theta, scaled)
        away = np.where(front[..., None], world - self.positions(theta)[:, None, :], 1.0)
        x, y, z = np.moveaxis(away, -1, 0)
        zero = np.zeros_like(z)
        ratios = [[1 / z, zero, -x / z**2], [zero, 1 / z, -y / z**2]]
        by_point = np.stack(
            [
                np.stack(row, axis=-1) / domain.half_range
                for row, domain in zip(ratios, self.domains, strict=True)
            ],
            axis=-2,
        )
        return pixels, slope @ by_point, front

    def covered(self, world: Array) -> BoolArray:
        """Whether points lie in the calibrated domain: of each ratio, of both where bivariate."""
        scaled, front = self._placed(self._mean, world)
        return np.asarray(front[0] & self.in_domain(scaled[0]))

    def solutions(self, pixels: Array) -> Solutions:
        """Solve pixels in the calibrated domain."""
        scaled, count = solved(self, self._mean, pixels)
        return Solutions(scaled, count, self.in_domain(scaled))

    def continued(self, pixels: Array) -> Solutions:
        """Solve pixels on the monotone branch of the calibrated domain, and beyond it."""
        scaled, found = continued(self, self._mean, pixels)
        return Solutions(scaled, found.astype(np.intp), self.in_domain(scaled))

    def rays(self, theta: Array, pixels: Array, start: Array | None) -> Rays:
        """Lines of sight that follow the mean's solution."""
        assert start is not None, "draws follow the mean's solution"
        shape = (len(theta), pixels.shape[1], 2)
        scaled, found = newton(
            self, theta, np.broadcast_to(pixels, shape), np.broadcast_to(start, shape)
        )
        ahead = _with_depth(self.ratios(scaled)) * self.side
        unit = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
        return Rays(np.array(self.positions(theta)), unit, found)

    @property
    def ahead(self) -> Ahead:
        """The tangent at x/z = y/z = 0."""
        value, slope = self.with_slopes(self._mean, self.scaled(np.zeros((1, 1, 2))))
        half = np.array([d.half_range for d in self.domains])
        straight = self.positions(self._mean) + np.array([0.0, 0.0, self.side])
        slopes = np.diagonal(slope[0, 0]) / half
        return Ahead(value[0, 0], slopes, bool(self.covered(straight)[0]))

    def directions(self, pixels: Array) -> Array:
        """Directions x/z, y/z, 1 of pixels, by the branch of the calibrated domain."""
        scaled, found = continued(self, self._mean, pixels)
        directions = _with_depth(self.ratios(scaled))
        directions[~found] = np.nan
        return directions

    def of_directions(self, directions: Array) -> tuple[Array, BoolArray]:
        """Pixels of directions, and whether the mapping turns nowhere before them."""
        scaled = self.scaled(directions[:, :2] / directions[:, 2:])
        return self.at_scaled(self._mean, scaled[None])[0], monotone(self, self._mean, scaled)

    def by_data(self, rng: np.random.Generator) -> Member:
        """Take what the data alone say, where it is known."""
        if self.estimate is None:
            return self
        return replace(self, parameters=self.estimate.parameters(rng))

    def aligned(self, rays: Array, pixels: Array) -> Member:  # noqa: ARG002
        """Leave it: its place is known."""
        return self

    def in_own_frame(self) -> Member:
        """Leave it: its place is known."""
        return self

    def plain(self) -> dict[str, Any]:
        """Orders, domains and place."""
        return {
            "orders": self.orders,
            "domains": [[d.lower, d.upper] for d in self.domains],
            "bivariate": self.bivariate,
            "position": None if self.position is None else self.position.tolist(),
            "side": self.side,
        }


def _with_depth(ratios: Array) -> Array:
    """x/z, y/z, 1, ``(..., 3)``."""
    return np.concatenate([ratios, np.ones_like(ratios[..., :1])], axis=-1)
