"""One model of a calibrated camera: draws of its parameters, and the mapping they make.

A member maps parameters ``(..., d)`` and world points to pixels and back, in the frame in which it
was fitted; it holds no points. Everything that predicts, locates or draws maps asks only what
`Member` lists, so that a new kind of mapping is one module.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, IntArray
from bayescal.prediction.calibrated.noise import NewNoise

KEPT = 1000  # draws of each model: sds to 2 %
BoolArray = NDArray[np.bool_]


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


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the data alone say of a member's parameters: those of maximum likelihood.

    No prior draws them anywhere, so that estimates of one camera differ by noise alone.

    Attributes
    ----------
    value : Array
        ``(d,)``.
    root : Array
        Root of the sampling covariance at the estimated noise, ``(d, q)``.
    levels : tuple
        Columns of the root that share a noise level, one after the other: how many, and the
        degrees of freedom of its estimate, inf where it is known.
    """

    value: Array
    root: Array
    levels: tuple[tuple[int, float], ...]

    def parameters(self, rng: np.random.Generator) -> Parameters:
        """Give the posterior under a flat prior: Student's t about the value."""
        moves = np.zeros((KEPT, len(self.value)))
        at = 0
        for columns, dof in self.levels:
            wide = np.sqrt(dof / rng.chisquare(dof, KEPT)) if np.isfinite(dof) else np.ones(KEPT)
            normal = rng.standard_normal((KEPT, columns))
            moves += wide[:, None] * normal @ self.root[:, at : at + columns].T
            at += columns
        return Parameters.of_draws(self.value + moves)


@dataclass(frozen=True, eq=False)
class Moments:
    """Mean and deviation of one model's mapping, ``(n, 2)``, px, and which points it sees."""

    mean: Array
    sd: Array
    seen: BoolArray


@dataclass(frozen=True, eq=False)
class Rays:
    """Lines of sight.

    Attributes
    ----------
    origin : Array
        Of each draw, ``(m, 3)``.
    direction : Array
        Unit vectors away from the camera, ``(m, n, 3)``.
    found : ndarray of bool
        ``(m, n)``.
    """

    origin: Array
    direction: Array
    found: BoolArray


@dataclass(frozen=True, eq=False)
class Solutions:
    """Where the mean of a member solves pixels.

    Attributes
    ----------
    scaled : Array or None
        Scaled regressors of a polynomial's solution, ``(n, 2)``; None of a lens.
    count : Array
        Number of solutions inside the calibrated domain or a little beyond, ``(n,)``.
    inside : ndarray of bool
        Whether the first of them is inside, ``(n,)``.
    """

    scaled: Array | None
    count: IntArray
    inside: BoolArray


@dataclass(frozen=True, eq=False)
class Ahead:
    """What a member's mean sees straight ahead, at x/z = y/z = 0.

    Attributes
    ----------
    pixel : Array
        ``(2,)``, px.
    slopes : Array
        Of r by x/z and of c by y/z, ``(2,)``, px.
    calibrated : bool
        Whether the mapping holds there.
    """

    pixel: Array
    slopes: Array
    calibrated: bool


class Member(Protocol):
    """A model of the camera with its posterior.

    Parameters theta are ``(m, d)``; points ``(n, 3)`` or ``(m, n, 3)``, of the world, or where the
    member has no place in it, in the camera's frame; pixels are as the member counts them, px.
    """

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def parameters(self) -> Parameters: ...  # noqa: D102
    @property
    def noise(self) -> NewNoise: ...  # noqa: D102
    @property
    def estimate(self) -> Estimate | None:
        """What the data alone say; None where only draws of the posterior are at hand."""

    @property
    def hull(self) -> Array: ...  # noqa: D102
    @property
    def posed(self) -> bool:
        """Whether it has a place in the world."""

    @property
    def n_free(self) -> int:
        """How many parameters move predictions: a turn that poses absorb is none."""

    @property
    def linear(self) -> Callable[[Array], Moments] | None:
        """Moments at points ``(n, 3)`` where pixels are linear in the parameters; else None."""

    @property
    def ahead(self) -> Ahead:
        """What it sees straight ahead."""

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels r, c ``(m, n, 2)`` of points, and which are seen ``(m, n)``."""

    def project_with_slopes(self, theta: Array, world: Array) -> tuple[Array, Array, BoolArray]:
        """Pixels, their derivatives by points ``(m, n, 3)``, ``(m, n, 2, 3)``, which are seen."""

    def covered(self, world: Array) -> BoolArray:
        """Whether points lie where points were calibrated with, ``(n,)``."""

    def solutions(self, pixels: Array) -> Solutions:
        """Solve pixels ``(n, 2)`` by the mean where points were calibrated with."""

    def continued(self, pixels: Array) -> Solutions:
        """Solve pixels ``(n, 2)`` by the mean, beyond what was calibrated as far as it goes on."""

    def rays(self, theta: Array, pixels: Array, start: Array | None) -> Rays:
        """Lines of sight of pixels ``(m, n, 2)`` or ``(1, n, 2)``, from `Solutions.scaled` on."""

    def directions(self, pixels: Array) -> Array:
        """Directions in the camera's frame of pixels ``(n, 2)`` by the mean; nan where none."""

    def of_directions(self, directions: Array) -> tuple[Array, BoolArray]:
        """Pixels ``(n, 2)`` of directions in the camera's frame by the mean, and which are seen."""

    def aligned(self, rays: Array, pixels: Array) -> Member:
        """Turn each draw to see rays ``(n, 3)`` closest to pixels, where no place fixes it."""

    def by_data(self, rng: np.random.Generator) -> Member:
        """Put draws under a flat prior in place of the posterior's, where there is an estimate."""

    def in_own_frame(self) -> Member:
        """Give it the frame of its own axis, as solvePnP has it, where no place fixes another."""

    def plain(self) -> dict[str, Any]:
        """All that it is made of beside name, parameters, noise and hull, as JSON has it."""
