"""One model of a calibrated camera: draws of its parameters, and the mapping they make.

A member maps parameters ``(..., d)`` and world points to pixels, in the frame in which it was
fitted; it holds no points. Everything that predicts, locates or draws maps needs no more than this.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.lenses import Lens, lens_named
from bayescal.polynomials.basis import Domain, legendre_design
from bayescal.polynomials.plane import plane_columns, powers
from bayescal.prediction.calibrated.hull import within
from bayescal.prediction.calibrated.noise import NewNoise

KEPT = 1000  # draws of each model: sds to 2 %
BoolArray = NDArray[np.bool_]
EDGE = 1e-9  # of the domain: rounding at its ends


@dataclass(frozen=True, eq=False)
class Parameters:
    """The posterior of a member's parameters.

    Attributes
    ----------
    mean : Array
        ``(d,)``.
    root : Array
        Root of the covariance, ``(d, d)``: columns are one-sd steps.
    draws : Array
        ``(n_draws, d)``.
    exact : bool
        Whether mean and root come from a closed form rather than from the draws.
    """

    mean: Array
    root: Array
    draws: Array
    exact: bool

    @classmethod
    def of_draws(cls, draws: Array) -> Parameters:
        """Take mean and covariance from draws."""
        covariance = np.atleast_2d(np.cov(draws, rowvar=False))
        values, vectors = np.linalg.eigh(covariance)
        return cls(draws.mean(axis=0), vectors * np.sqrt(np.maximum(values, 0)), draws, False)

    @cached_property
    def steps(self) -> Array:
        """The mean, then one sd up and one down along each column, ``(1 + 2 d, d)``."""
        return np.concatenate([self.mean[None], self.mean + self.root.T, self.mean - self.root.T])


class Member(Protocol):
    """A model of the camera with its posterior."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def parameters(self) -> Parameters: ...  # noqa: D102
    @property
    def noise(self) -> NewNoise: ...  # noqa: D102

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels r, c ``(m, n, 2)`` of points, and which are seen ``(m, n)``.

        Parameters
        ----------
        theta : Array
            ``(m, d)``.
        world : Array
            ``(n, 3)`` or ``(m, n, 3)``; where the lens has no pose, in the camera's frame.
        """

    def covered(self, world: Array) -> BoolArray:
        """Whether points lie where points were calibrated with, ``(n,)``."""


@dataclass(frozen=True, eq=False)
class PolynomialMember:
    """r and c as polynomials of x/z and y/z, about a camera position.

    Parameters: the Legendre amplitudes of r, those of c (px), then the camera position where it
    is not exact (world units).

    Attributes
    ----------
    name : str
    orders : tuple of int
        Of r and of c.
    domains : tuple of Domain
        Of x/z and of y/z.
    bivariate : bool
        Whether each is a polynomial of both.
    hull : Array
        Corners of the calibration points' hull in the scaled regressors, ``(m, 2)``.
    position : Array or None
        Camera position where it is exact, ``(3,)``.
    side : float
        1 or -1: the sign of z less the camera's, of points in front of it.
    parameters : Parameters
    noise : NewNoise
    """

    name: str
    orders: tuple[int, int]
    domains: tuple[Domain, Domain]
    bivariate: bool
    hull: Array
    position: Array | None
    side: float
    parameters: Parameters
    noise: NewNoise

    def columns(self, axis: int) -> int:
        """Count the amplitudes of r (0) or c (1)."""
        k = self.orders[axis]
        return plane_columns(k) if self.bivariate else k + 1

    @property
    def linear(self) -> bool:
        """Whether pixels are linear in the parameters."""
        return self.position is not None

    def positions(self, theta: Array) -> Array:
        """Camera positions, ``(m, 3)``, world units."""
        if self.position is not None:
            return np.broadcast_to(self.position, (len(theta), 3))
        return theta[:, -3:]

    def amplitudes(self, theta: Array) -> tuple[Array, Array]:
        """Amplitudes of r and of c, ``(m, p)`` each."""
        first, second = self.columns(0), self.columns(1)
        return theta[:, :first], theta[:, first : first + second]

    def scaled(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Scaled regressors, ``(m, n, 2)``, and which points are in front; m is 1 where exact."""
        places = self.positions(theta[:1] if self.linear else theta)
        away = world - places[:, None, :]
        front = away[..., 2] * self.side > 0
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ratios = away[..., :2] / away[..., 2:]
        s = [domain.scale(ratios[..., i]) for i, domain in enumerate(self.domains)]
        return np.where(front[..., None], np.stack(s, axis=-1), 0.0), front

    def design(self, scaled: Array, axis: int) -> Array:
        """Design of r (0) or c (1) at scaled regressors ``(..., 2)``, ``(..., p)``."""
        k = self.orders[axis]
        if not self.bivariate:
            return legendre_design(scaled[..., axis], k)
        # The first power is of the axis's own regressor.
        first, second = np.array(powers(k)).T
        own, other = (legendre_design(scaled[..., i], k) for i in (axis, 1 - axis))
        return np.asarray(own[..., first] * other[..., second])

    def at_scaled(self, theta: Array, scaled: Array) -> Array:
        """Pixels at scaled regressors ``(m, n, 2)`` or ``(1, n, 2)``, ``(m, n, 2)``."""
        out = []
        for axis, b in enumerate(self.amplitudes(theta)):
            design = self.design(scaled, axis)
            if len(design) == 1:
                out.append(b @ design[0].T)
            else:
                out.append(np.einsum("mnp,mp->mn", design, b))
        return np.stack(out, axis=-1)

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels of world points, and which are in front of the camera."""
        scaled, front = self.scaled(theta, world)
        pixels = self.at_scaled(theta, scaled)
        return pixels, np.broadcast_to(front, pixels.shape[:2])

    def covered(self, world: Array) -> BoolArray:
        """Whether points lie in the calibrated domain: of each ratio, of both where bivariate."""
        scaled, front = self.scaled(self.parameters.mean[None], world)
        return np.asarray(front[0] & self.in_domain(scaled[0]))

    def in_domain(self, scaled: Array) -> BoolArray:
        """Whether scaled regressors ``(..., 2)`` lie in the calibrated domain, ``(...)``."""
        if self.bivariate:
            return within(self.hull, scaled)
        low, high = self.box
        return np.asarray(((scaled >= low) & (scaled <= high)).all(axis=-1))

    @property
    def box(self) -> tuple[Array, Array]:
        """Ends of the calibrated domain of both scaled regressors, ``(2,)`` each."""
        low, high = self.hull.min(axis=0), self.hull.max(axis=0)
        slack = EDGE * (high - low)
        return low - slack, high + slack


@dataclass(frozen=True, eq=False)
class LensMember:
    """A lens, with a pose where it has one.

    Parameters: ln fx, ln fy; cx, cy (px); the lens's coefficients; then the pose: a turn from
    `turn` on the camera's side (rad), the undistorted pixel of `anchor` (px), ln of its depth over
    fx. The data fix these to about a pixel each whatever the focal length is. A lens of many views
    has of these the turn that their poses absorb (`bayescal.prediction.calibrated.alignment`).

    Attributes
    ----------
    name : str
    lens_name : str
    lens_options : dict
        As `bayescal.cameras.lenses.lens_named` takes them.
    turn : Array or None
        Rotation matrix of the pose's mean, ``(3, 3)``; None where parameters hold no turn.
    anchor : Array or None
        A world point among those calibrated with, ``(3,)``; None without a place in the world.
    hull : Array
        Corners of the calibration pixels' hull, ``(m, 2)``, px.
    parameters : Parameters
    noise : NewNoise
    """

    name: str
    lens_name: str
    lens_options: dict[str, int | bool]
    turn: Array | None
    anchor: Array | None
    hull: Array
    parameters: Parameters
    noise: NewNoise

    @cached_property
    def lens(self) -> Lens:
        """The lens itself."""
        return lens_named(self.lens_name, **self.lens_options)

    @property
    def posed(self) -> bool:
        """Whether it has a place in the world; else points are in the camera's frame."""
        return self.anchor is not None

    @property
    def n_lens(self) -> int:
        """Number of parameters before the pose."""
        return 4 + len(self.lens.names)

    def intrinsics(self, theta: Array) -> tuple[Array, Array]:
        """Intrinsics fx, fy, cx, cy ``(m, 4)``, px, and coefficients ``(m, K)``."""
        focal = np.exp(theta[:, :2])
        return np.concatenate([focal, theta[:, 2:4]], axis=1), theta[:, 4 : self.n_lens]

    def pose(self, theta: Array) -> tuple[Array, Array]:
        """Rotation matrices ``(m, 3, 3)`` and translations ``(m, 3)``: p = R X + t."""
        from bayescal.cameras.pose import rotations

        at = self.n_lens
        if self.turn is None:
            return np.broadcast_to(np.eye(3), (len(theta), 3, 3)), np.zeros((len(theta), 3))
        matrix = rotations(theta[:, at : at + 3]) @ self.turn
        if self.anchor is None:
            return matrix, np.zeros((len(theta), 3))
        focal = np.exp(theta[:, :2])
        depth = np.exp(theta[:, 0] + theta[:, at + 5])
        sides = (theta[:, at + 3 : at + 5] - theta[:, 2:4]) / focal * depth[:, None]
        return matrix, np.column_stack([sides, depth]) - matrix @ self.anchor

    def rays(self, theta: Array, world: Array) -> Array:
        """World points ``(n, 3)`` or ``(m, n, 3)`` in the camera's frame, ``(m, n, 3)``."""
        matrix, t = self.pose(theta)
        return np.asarray(world @ np.swapaxes(matrix, 1, 2) + t[:, None, :])

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels of points, and which the lens sees."""
        rays = self.rays(theta, world)
        intrinsics, k = self.intrinsics(theta)
        with np.errstate(all="ignore"):
            plane = self.lens.distort(rays, k)
            pixels = intrinsics[:, None, 2:] + intrinsics[:, None, :2] * plane
            seen = self.lens.seen(rays, k) & np.isfinite(pixels).all(axis=-1)
        return np.where(seen[..., None], pixels, 0.0), seen

    def covered(self, world: Array) -> BoolArray:
        """Whether points appear inside the hull of the calibration pixels."""
        pixels, seen = self.project(self.parameters.mean[None], world)
        return np.asarray(seen[0] & within(self.hull, pixels[0]))
