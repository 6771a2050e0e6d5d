r"""Lenses that move points of the undistorted plane: radial, tangential, thin-prism terms.

With a = x/z, b = y/z, w^2 = a^2 + b^2 and t = w^2 (t = w for the thesis's plain powers)

    g = (1 + k1 t + k2 t^2 + ...) / (1 + k4 t + k5 t^2 + ...),
    u = a g + 2 p1 a b + p2 (w^2 + 2 a^2) + s1 w^2 + s2 w^4,
    v = b g + p1 (w^2 + 2 b^2) + 2 p2 a b + s3 w^2 + s4 w^4:

Brown 1966 (Photogrammetric Engineering 32, 444), in the form and order of OpenCV. Only points in
front of the camera are seen, as far out as w g grows and before its pole.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.lenses.inverse import invert
from bayescal.cameras.lenses.lens import RESIDUAL, Derivatives, Undistorted, columns
from bayescal.cameras.lenses.polynomial import first_root, horner, horner_slope, product, with_one
from bayescal.cameras.lenses.terms import prism_terms, radial_terms, tangential_terms

_MOST_STEPS, _MOST_HALVINGS = 40, 12


@dataclass(frozen=True)
class Planar:
    """A lens of the undistorted plane.

    Attributes
    ----------
    numerator, denominator : int
        Number of radial coefficients above and below the line.
    tangential, prism : bool
        Whether p1, p2 and s1 .. s4 are among the coefficients.
    step : int
        Power of the radius in t: 2, or 1 for the thesis's powers.
    """

    name: str
    numerator: int
    denominator: int = 0
    tangential: bool = False
    prism: bool = False
    step: int = 2

    @cached_property
    def _kinds(self) -> tuple[tuple[str, str, int], ...]:
        """Name, group and power of each coefficient, in OpenCV's order."""
        total = self.numerator + self.denominator
        # k4 is the first below the line, however many stand above it, as in OpenCV.
        first = 4 if self.denominator else self.numerator + 1
        labels = [*range(1, self.numerator + 1), *range(first, first + self.denominator)]
        degrees = [*range(1, self.numerator + 1), *range(1, self.denominator + 1)]
        radial = [(f"k{labels[j]}", "radial", 1 + self.step * degrees[j]) for j in range(total)]
        tangential = [(name, "tangential", 2) for name in ("p1", "p2")] * self.tangential
        powers = zip(("s1", "s2", "s3", "s4"), (2, 4, 2, 4), strict=True)
        prism = [(name, "thin-prism", power) for name, power in powers] * self.prism
        before = min(2, self.numerator)
        return (*radial[:before], *tangential, *radial[before:], *prism)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the coefficients."""
        return tuple(kind[0] for kind in self._kinds)

    @property
    def groups(self) -> tuple[str, ...]:
        """Of each coefficient."""
        return tuple(kind[1] for kind in self._kinds)

    @cached_property
    def powers(self) -> tuple[int, ...]:
        """Power of the radius with which each displacement grows."""
        return tuple(kind[2] for kind in self._kinds)

    @property
    def start(self) -> tuple[float, ...]:
        """No distortion."""
        return (0.0,) * len(self._kinds)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """None."""
        return ((-np.inf, np.inf),) * len(self._kinds)

    @cached_property
    def _at(self) -> dict[str, list[int]]:
        """Places of each group's coefficients."""
        groups = ("radial", "tangential", "thin-prism")
        return {g: [j for j, kind in enumerate(self._kinds) if kind[1] == g] for g in groups}

    def _radial(self, k: Array) -> tuple[Array, Array]:
        """Coefficients above and below the line, ``(..., numerator)``, ``(..., denominator)``."""
        radial = k[..., self._at["radial"]]
        return radial[..., : self.numerator], radial[..., self.numerator :]

    def distort(self, rays: Array, k: Array) -> Array:
        """Plane coordinates, ``(..., n, 2)``."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            a, b = rays[..., 0] / rays[..., 2], rays[..., 1] / rays[..., 2]
            square = a**2 + b**2
            above, below = self._radial(k)
            t = square if self.step == 2 else np.sqrt(square)
            gain = horner(above, t)
            if self.denominator:
                gain = gain / horner(below, t)
            u, v = a * gain, b * gain
            if self.tangential:
                p1, p2 = _each(k, self._at["tangential"])
                cross = 2 * a * b
                u = u + p1 * cross + p2 * (square + 2 * a**2)
                v = v + p1 * (square + 2 * b**2) + p2 * cross
            if self.prism:
                s1, s2, s3, s4 = _each(k, self._at["thin-prism"])
                u, v = u + square * (s1 + s2 * square), v + square * (s3 + s4 * square)
            return columns(u, v)

    def jacobian(self, rays: Array, k: Array) -> Derivatives:
        """Plane coordinates with derivatives by ray and by coefficient."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            inverse = 1 / rays[..., 2]
            a, b = rays[..., 0] * inverse, rays[..., 1] * inverse
            plane, by_plane, by_coefficient = self._plane_jacobian(a, b, k)
            by_ray = np.empty((*by_plane.shape[:-1], 3))
            by_ray[..., :2] = by_plane * inverse[..., None, None]
            by_ray[..., 2] = -(by_ray[..., 0] * a[..., None] + by_ray[..., 1] * b[..., None])
        return Derivatives(plane, by_ray, by_coefficient)

    def _plane_jacobian(self, a: Array, b: Array, k: Array) -> tuple[Array, Array, Array]:
        """Plane coordinates, derivatives by a and b, ``(..., n, 2, 2)``, and by coefficients."""
        parts = {"radial": radial_terms(a, b, *self._radial(k), self.step)}
        if self.tangential:
            parts["tangential"] = tangential_terms(a, b, *_each(k, self._at["tangential"]))
        if self.prism:
            parts["thin-prism"] = prism_terms(a, b, *_each(k, self._at["thin-prism"]))
        shape = np.broadcast_shapes(a.shape, (*k.shape[:-1], 1))
        by_plane, by_k = np.empty((*shape, 2, 2)), np.empty((*shape, 2, k.shape[-1]))
        for i in (0, 1):
            for j in (0, 1):
                by_plane[..., i, j] = sum(part.by_plane[i][j] for part in parts.values())
        for group, part in parts.items():
            for column, (by_u, by_v) in zip(self._at[group], part.by_coefficient, strict=True):
                by_k[..., 0, column], by_k[..., 1, column] = by_u, by_v
        u, v = (np.asarray(sum(part.plane[i] for part in parts.values())) for i in (0, 1))
        return columns(u, v), by_plane, by_k

    def _bars(self, k: Array) -> list[Array]:
        """Polynomials in t, without their constant 1, whose first root ends the inverse.

        The numerator of the slope of w g, (N + w N') D - N w D', and D itself.
        """
        above, below = self._radial(k)
        rise = 1 + self.step * np.arange(1, self.numerator + 1)
        if not self.denominator:
            return [above * rise]
        up, down = with_one(above), with_one(below)
        with np.errstate(invalid="ignore", over="ignore"):
            slope = product(with_one(above * rise), down) - product(
                up, down * self.step * np.arange(self.denominator + 1)
            )
        return [slope[..., 1:], below]

    def _edge(self, k: Array) -> Array:
        """Radius w of the undistorted plane up to which w g grows, ``(...)``; inf if always."""
        first = np.min([first_root(bar) for bar in self._bars(k)], axis=0)
        return np.asarray(first ** (1 / self.step))

    def limit(self, k: Array) -> Array:
        """Angle up to which the radius in the image grows, ``(...)``, rad; at most pi/2."""
        return np.asarray(np.arctan(self._edge(k)))

    def seen(self, rays: Array, k: Array) -> NDArray[np.bool_]:
        """Whether rays are in front of the camera and inside `limit`, ``(..., n)``."""
        depth = rays[..., 2]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            square = (rays[..., 0] ** 2 + rays[..., 1] ** 2) / depth**2
            square = np.where(depth > 0, square, np.inf)
            # Most cameras fold far outside: there the terms that lower a bar sum to less than 1.
            farthest = np.where(square < np.inf, square, 0).max(axis=-1, initial=0.0)
            farthest = farthest if self.step == 2 else np.sqrt(farthest)
            bars = [horner(np.minimum(bar, 0), farthest[..., None]) for bar in self._bars(k)]
        shape = np.broadcast_shapes(square.shape[:-1], k.shape[:-1])
        near = np.all([bar[..., 0] > 0 for bar in bars], axis=0) & np.isfinite(k).all(axis=-1)
        near = np.broadcast_to(near, shape)
        edge = np.full(shape, np.inf)
        if not near.all():
            edge[~near] = self._edge(np.broadcast_to(k, (*shape, k.shape[-1]))[~near])
        return np.asarray(square < edge[..., None] ** 2)

    def undistort(self, plane: Array, k: Array) -> Undistorted:
        """Rays of plane coordinates: the radial part in a bracket, the rest by Newton's method."""
        u, v = plane[..., 0], plane[..., 1]
        above, below = self._radial(k)
        edge = self._edge(k)[..., None]

        def curve(w: Array) -> tuple[Array, Array]:
            t = w**self.step
            over = 1 / horner(below, t)
            gain = horner(above, t) * over
            rise = (horner_slope(above, t) - gain * horner_slope(below, t)) * over
            return w * gain, gain + self.step * t * rise

        radius = np.hypot(u, v)
        shape = np.broadcast_shapes(radius.shape, edge.shape)
        radius, edge = np.broadcast_to(radius, shape), np.broadcast_to(edge, shape)
        w = invert(curve, radius, edge)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scale = np.where(radius == 0, 1, w / np.where(radius == 0, 1, radius))
            a, b = u * scale, v * scale
            if self.tangential or self.prism:
                a, b = self._newton(a, b, plane, k)
            rays = columns(a, b, np.ones_like(a))
            rays = rays / np.sqrt((rays**2).sum(axis=-1, keepdims=True))
            miss = np.abs(self.distort(rays, k) - plane).max(axis=-1)
            allowed = RESIDUAL * np.maximum(1, np.abs(plane).max(axis=-1))
            found = (miss <= allowed) & (np.hypot(a, b) < edge)
        return Undistorted(np.where(found[..., None], rays, np.nan), np.asarray(found))

    def _newton(self, a: Array, b: Array, plane: Array, k: Array) -> tuple[Array, Array]:
        """Newton's steps in two dimensions, each halved until the residual falls."""
        at, slopes, _ = self._plane_jacobian(a, b, k)
        for _ in range(_MOST_STEPS):
            miss = at - plane
            size = np.abs(miss).max(axis=-1)
            rest = size > RESIDUAL / 20 * np.maximum(1, np.abs(plane).max(axis=-1))
            if not rest.any():
                break
            (u_a, u_b), (v_a, v_b) = ((slopes[..., i, 0], slopes[..., i, 1]) for i in (0, 1))
            determinant = u_a * v_b - u_b * v_a
            step_a = (v_b * miss[..., 0] - u_b * miss[..., 1]) / determinant
            step_b = (u_a * miss[..., 1] - v_a * miss[..., 0]) / determinant
            share = np.where(rest, 1.0, 0.0)
            for _ in range(_MOST_HALVINGS):
                tried = columns(a - share * step_a, b - share * step_b, np.ones_like(a))
                now = np.abs(self.distort(tried, k) - plane).max(axis=-1)
                worse = (share > 0) & ~(now < size)
                if not worse.any():
                    break
                share = np.where(worse, share / 2, share)
            share = np.where(worse, 0.0, share)
            if not share.any():
                break
            a, b = a - share * step_a, b - share * step_b
            at, slopes, _ = self._plane_jacobian(a, b, k)
        return a, b


def _each(k: Array, at: list[int]) -> list[Array]:
    """Coefficients in places `at`, each ``(..., 1)`` to meet the points."""
    return [k[..., j, None] for j in at]
