r"""A lens model's parameters: coordinates in which priors are stated in pixels.

Coordinates are ln(f / width), ln(fy / fx), the principal point (px), for each distortion
coefficient the displacement d_j (px) it makes at the image's corner radius R, and the bow of
a planar target (in its diagonals). With n the power of the radius that the displacement of
k_j grows with, k_j = d_j f^(n - 1) / R^n. Coefficients that give a lens its shape have bounds, not
amplitudes: uniform between finite ones, log-normal above 0, their coordinates standard normal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri

from bayescal.arrays import LOG_2PI, Array
from bayescal.cameras.lenses.lens import Lens

FOCAL_SD, ASPECT_SD, CENTRE_SD = 0.7, 0.05, 0.1
# Bounds of tau, the size of the displacements: fractions of the width; of the diagonal for bow.
WIDE, NARROW, BOW = (1e-3, 0.5), (1e-4, 0.05), (1e-4, 0.03)
SHAPE = "shape"
STRENGTHS = {"tangential": NARROW, "thin-prism": NARROW, "bow": BOW}


@dataclass(frozen=True)
class Group:
    """Coordinates that share a strength tau.

    Attributes
    ----------
    unit : float
        What tau is a fraction of: the image's width in px, or one diagonal.
    bounds : tuple of float
        Of tau.
    """

    name: str
    columns: tuple[int, ...]
    unit: float
    bounds: tuple[float, float]


@dataclass(frozen=True, eq=False)
class LensModel:
    """A lens with the switches that fix what else is free.

    Attributes
    ----------
    key : str
        As tables show it.
    size : tuple of float
        Width and height of the image, px.
    square : bool
        Whether fx = fy.
    centred : bool
        Whether the principal point stays at the middle of the image.
    bow : bool
        Whether the target may bow: z += b_x (1 - x^2) + b_y (1 - y^2), x and y scaled to -1..1.
    """

    key: str
    lens: Lens
    size: tuple[float, float]
    square: bool = False
    centred: bool = False
    bow: bool = False

    @cached_property
    def bowed(self) -> LensModel:
        """The same lens of a target that may bow: two coordinates more."""
        return replace(self, bow=True)

    @property
    def middle(self) -> Array:
        """Middle of the image, px."""
        return (np.array(self.size) - 1) / 2

    @property
    def radius(self) -> float:
        """Half the image's diagonal, px."""
        return math.hypot(*self.size) / 2

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the reported parameters."""
        bow = ("bow_x", "bow_y") if self.bow else ()
        focal = ("f",) if self.square else ("fx", "fy")
        centre = () if self.centred else ("cx", "cy")
        return (*focal, *centre, *self.lens.names, *bow)

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    @property
    def n_plain(self) -> int:
        """Coordinates without a strength, the first ones: a lens has its shape ones first."""
        return self._n_intrinsics + self.lens.groups.count(SHAPE)

    @property
    def _n_intrinsics(self) -> int:
        return (1 if self.square else 2) + (0 if self.centred else 2)

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """Groups of coordinates that share a tau."""
        of: dict[str, list[int]] = {}
        for j, name in enumerate(self.lens.groups):
            if name != SHAPE:
                of.setdefault(name, []).append(self._n_intrinsics + j)
        if self.bow:
            of["bow"] = [self.dimension - 2, self.dimension - 1]
        return tuple(
            Group(
                name,
                tuple(columns),
                1.0 if name == "bow" else self.size[0],
                STRENGTHS.get(name, WIDE),
            )
            for name, columns in of.items()
        )

    @cached_property
    def plain_prior(self) -> tuple[Array, Array]:
        """Mean and sd of the coordinates without a strength."""
        mean, sd = [0.0], [FOCAL_SD]
        if not self.square:
            mean, sd = [*mean, 0.0], [*sd, ASPECT_SD]
        if not self.centred:
            mean, sd = [*mean, *self.middle], [*sd, *[CENTRE_SD * self.size[0]] * 2]
        shapes = self.lens.groups.count(SHAPE)
        mean, sd = [*mean, *[0.0] * shapes], [*sd, *[1.0] * shapes]
        return np.array(mean), np.array(sd)

    def log_plain_prior(self, x: Array) -> Array:
        """Log prior density of those, ``(...,)``."""
        mean, sd = self.plain_prior
        z = (x[..., : len(mean)] - mean) / sd
        return np.asarray(-0.5 * (z**2 + LOG_2PI).sum(axis=-1) - np.log(sd).sum())

    @cached_property
    def _powers(self) -> Array:
        return np.array(self.lens.powers, dtype=np.float64)

    def physical(self, x: Array) -> tuple[Array, Array, Array]:
        """Intrinsics fx, fy, cx, cy, coefficients and bow at coordinates ``(..., dimension)``."""
        with np.errstate(over="ignore", invalid="ignore"):  # no lens sees points so far off
            return self._physical(x)

    def _physical(self, x: Array) -> tuple[Array, Array, Array]:
        fx = self.size[0] * np.exp(x[..., 0])
        fy = fx if self.square else fx * np.exp(x[..., 1])
        at = 1 if self.square else 2
        if self.centred:
            cx, cy = (np.full(fx.shape, m) for m in self.middle)
        else:
            cx, cy, at = x[..., at], x[..., at + 1], at + 2
        n = len(self.lens.names)
        k = x[..., at : at + n] * self._scale(fx)
        for j, bounds in self._shapes:
            k[..., j] = _shape(x[..., at + j], bounds)
        return np.stack([fx, fy, cx, cy], axis=-1), k, x[..., at + n :]

    @cached_property
    def _shapes(self) -> list[tuple[int, tuple[float, float]]]:
        """Coefficients of the lens's shape, with their bounds."""
        return [(j, self.lens.bounds[j]) for j, g in enumerate(self.lens.groups) if g == SHAPE]

    def coordinates(self, intrinsics: Array, k: Array, bow: Array | None = None) -> Array:
        """Coordinates of physical parameters; the inverse of `physical`."""
        fx, fy, cx, cy = np.moveaxis(intrinsics, -1, 0)
        parts = [np.log(fx / self.size[0])[..., None]]
        if not self.square:
            parts.append(np.log(fy / fx)[..., None])
        if not self.centred:
            parts.append(np.stack([cx, cy], axis=-1))
        amplitudes = k / self._scale(fx)
        for j, bounds in self._shapes:
            amplitudes[..., j] = _shape_coordinate(k[..., j], bounds)
        parts.append(amplitudes)
        if self.bow:
            parts.append(np.zeros((*fx.shape, 2)) if bow is None else bow)
        return np.concatenate(parts, axis=-1)

    def report(self, x: Array, diagonal: float) -> Array:
        """Give reported parameters at coordinates, ``(..., dimension)``; bow in the target's."""
        intrinsics, k, bow = self.physical(x)
        parts = [intrinsics[..., :1] if self.square else intrinsics[..., :2]]
        if not self.centred:
            parts.append(intrinsics[..., 2:])
        return np.concatenate([*parts, k, bow * diagonal], axis=-1)

    def _scale(self, fx: Array) -> Array:
        """Coefficient that displaces by 1 px at the corner, ``(..., n_coefficients)``."""
        power = self._powers
        return np.asarray(fx[..., None] ** (power - 1) / self.radius**power)

    def by_coordinate(self, x: Array, stretch: Array, weight: Array, by_k: Array) -> Array:
        """Chain rule: weighted derivatives by the coordinates, those of bow 0, ``(..., 2, d)``.

        Parameters
        ----------
        x : Array
            ``(dimension,)``.
        stretch : Array
            By the logs of fx (of r) and fy (of c), ``(..., 2)``.
        weight : Array
            By cx (of r) and cy (of c), ``(..., 2)``.
        by_k : Array
            ``(..., 2, n_coefficients)``.
        """
        (fx, *_), k, _ = self.physical(x)
        follows = k * (self._powers - 1)
        scale = self._scale(np.asarray(fx))
        for j, bounds in self._shapes:
            y = x[self._n_intrinsics + j]
            follows[j], scale[j] = 0.0, _shape_slope(y, bounds)
        out = np.zeros((*by_k.shape[:-1], self.dimension))
        out[..., 0] = stretch + by_k @ follows
        at = 1
        if not self.square:
            out[..., 1, 1], at = stretch[..., 1], 2
        if not self.centred:
            out[..., 0, at], out[..., 1, at + 1] = weight[..., 0], weight[..., 1]
        at = self._n_intrinsics
        np.multiply(by_k, scale, out=out[..., at : at + by_k.shape[-1]])
        return out


def _shape(y: Array, bounds: tuple[float, float]) -> Array:
    """Coefficient whose coordinate is standard normal."""
    low, high = bounds
    return np.asarray(low + np.exp(y) if math.isinf(high) else low + (high - low) * ndtr(y))


def _shape_coordinate(k: Array, bounds: tuple[float, float]) -> Array:
    low, high = bounds
    if math.isinf(high):
        return np.asarray(np.log(k - low))
    return np.asarray(ndtri(np.clip((k - low) / (high - low), 1e-12, 1 - 1e-12)))


def _shape_slope(y: float, bounds: tuple[float, float]) -> float:
    low, high = bounds
    with np.errstate(over="ignore"):
        if math.isinf(high):
            return float(np.exp(y))
        return float((high - low) * np.exp(-(y**2) / 2) / math.sqrt(2 * math.pi))
