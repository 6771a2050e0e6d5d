"""Radial lens distortion, and its inverse where there is one (thesis eq. 3-5).

A point of the image plane at distance w from the centre moves along its radius to

    w_dist = w f(w),   w^2 = u^2 + v^2,

- ``"all"``: f(w) = 1 + k_1 w + k_2 w^2 + ..., the thesis's powers of the radius (also
  Hartley & Zisserman 2004, section 7.4). Odd powers leave a kink at the centre.
- ``"even"``: f(w) = 1 + k_1 w^2 + k_2 w^4 + ..., the usual ones: Zhang 2000 (IEEE PAMI
  22, 1330) and OpenCV, and Brown 1971 (Photogrammetric Engineering 37, 855), who takes
  the measured point to the corrected one with them.

k_1 < 0 is barrel distortion. k_j has the unit of u and v to the power -j ("all") or -2j
("even"); u and v are those of `bayescal.cameras.geometry`, from the centre of distortion.

Where some k_j < 0 the distorted radius may stop growing at some w and turn back: from there
on two points share one image, and there is no inverse. `invertible_radius` is that w.
"""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from scipy.optimize import brentq

from bayescal.arrays import Array, ArrayLike
from bayescal.cameras.checks import bounded, finite_table, finite_vector
from bayescal.errors import InputError
from bayescal.points.correspondences import LARGEST

Powers: TypeAlias = Literal["all", "even"]

_STEPS = {"all": 1, "even": 2}
_EPS = float(np.finfo(np.float64).eps)
_TINY = float(np.finfo(np.float64).tiny)
_LOG_LARGEST = math.log(np.finfo(np.float64).max)
# Bisection alone needs about 60 + log2(bound / root) steps: this many for any two doubles.
# Newton's method seldom takes more than 10.
_MOST_HALVINGS = 2200


def distort(image: ArrayLike, coefficients: ArrayLike, powers: Powers = "all") -> Array:
    """Distorted image points: u_dist = u f(w), v_dist = v f(w), w^2 = u^2 + v^2.

    Thesis eq. 3-5. Beyond `invertible_radius` this is still what the polynomial
    gives, but `undistort` can't give it back.

    Parameters
    ----------
    image : array_like
        u, v on the image plane, from the centre of distortion, ``(n, 2)``.
    coefficients : array_like
        k_1, k_2, ..., ``(m,)``; none for no distortion.
    powers : {"all", "even"}, optional
        Powers of w in f: w, w^2, w^3, ... or w^2, w^4, w^6, ...

    Returns
    -------
    Array
        u_dist, v_dist, ``(n, 2)``, in the unit of `image`.

    Raises
    ------
    InputError
        Where a shape, a number or the name of the powers can't be used, or naming
        the first point whose image overflows.
    """
    uv = finite_table(image, 2, "image")
    k, step = _polynomial(coefficients, powers)
    with np.errstate(over="ignore", invalid="ignore"):
        return bounded(uv * _ascending(k, np.hypot(uv[:, 0], uv[:, 1]), step)[:, None])


def undistort(image: ArrayLike, coefficients: ArrayLike, powers: Powers = "all") -> Array:
    """Image points of distorted ones: the inverse of `distort` up to `invertible_radius`.

    The root of w f(w) = w_dist on the branch that starts at the centre, by Newton's
    method inside a bracket (Press et al. 2007, section 9.4).

    Parameters
    ----------
    image : array_like
        u_dist, v_dist from the centre of distortion, ``(n, 2)``.
    coefficients, powers
        As for `distort`.

    Returns
    -------
    Array
        u, v, ``(n, 2)``, in the unit of `image`.

    Raises
    ------
    InputError
        Where a shape, a number or the name of the powers can't be used, or naming
        the first point that lies beyond what the invertible radius is mapped to.

    Notes
    -----
    `distort` of the result is `image` to rounding. The result itself has a relative error
    of about eps f(w) / slope(w): rounding over most of the branch, but 1e-8 at its end, where
    the slope is zero (1e-5 where it only touches zero).
    """
    uv = finite_table(image, 2, "image")
    k, step = _polynomial(coefficients, powers)
    limit = invertible_radius(coefficients, powers)
    distorted = np.hypot(uv[:, 0], uv[:, 1])
    if math.isfinite(limit):
        with np.errstate(over="ignore"):
            reach = limit * _ascending(k, limit, step)
            slack = limit * _rounding(k, limit, step)
        beyond = np.flatnonzero(distorted > reach + slack)
        if beyond.size:
            first = int(beyond[0])
            raise InputError(
                f"point {first + 1}: its distorted radius {distorted[first]:.9g} is beyond "
                f"{reach:.9g}, where the distortion polynomial stops being invertible (at radius "
                f"{limit:.9g}); remove the point or use other coefficients"
            )
        distorted = np.minimum(distorted, reach)
    radius = _invert(distorted, k, step, limit)
    bounded(radius[:, None])
    return uv / _ascending(k, radius, step)[:, None]


def invertible_radius(coefficients: ArrayLike, powers: Powers = "all") -> float:
    """Radius up to which the distortion can be undone; infinite where it always can.

    The smallest w > 0 at which the slope of w f(w) is zero. That is where the
    polynomial turns back; should it only level off there and rise again, the inverse
    has an infinite slope and rounding can't tell the two apart, so that counts too.

    Parameters
    ----------
    coefficients, powers
        As for `distort`.

    Returns
    -------
    float
        The undistorted radius, in the unit of u and v; ``inf`` where the slope is
        positive everywhere (below 1e100, the largest coordinate accepted).

    Raises
    ------
    InputError
        Where the coefficients or the name of the powers can't be used.
    """
    k, step = _polynomial(coefficients, powers)
    # The slope's coefficients of t^j, t = w ("all") or w^2 ("even"), are those of s^(m-j)
    # in s = 1/t: a monic polynomial, whose largest positive root is wanted.
    root = _largest_root(np.trim_zeros(_slope(k, step), "b"), LARGEST**-step)
    return math.inf if root is None else (1 / root) ** (1 / step)


def _largest_root(a: Array, least: float) -> float | None:
    """Largest root above `least` of a monic polynomial, leading coefficient first.

    A double root comes out of the eigenvalues as a pair slightly complex or slightly
    apart, so they only say where to look: their real parts, and the points between, are
    gone through downwards for the first value that is negative or zero to rounding.
    """
    j = np.arange(1, len(a))
    # No root is as large (Fujiwara 1916).
    bound = 2 * float(np.max(np.abs(a[1:]) ** (1 / j), initial=0.0))
    if len(a) * math.log(max(bound, 1.0)) > _LOG_LARGEST:
        raise InputError("coefficients are too large for their number; use another unit of u and v")
    found = np.roots(a).real
    found = np.sort(found[found > least])[::-1]
    between = (found + np.append(found[1:], least)) / 2
    above = bound
    for s in [*np.column_stack([found, between]).ravel().tolist(), least]:
        value = float(np.polyval(a, s))
        if abs(value) <= _rounding(a[::-1], s, 1):
            return float(s)
        if value < 0:
            return float(
                brentq(
                    lambda x: float(np.polyval(a, x)),
                    s,
                    above,
                    xtol=_TINY,
                    rtol=4 * _EPS,
                    maxiter=_MOST_HALVINGS,
                )
            )
        above = s
    return None


def _invert(distorted: Array, k: Array, step: int, limit: float) -> Array:
    """Roots w of w f(w) = `distorted` in [0, limit], where w f(w) grows, ``(n,)``."""
    slope = _slope(k, step)
    low = np.zeros_like(distorted)
    high = np.full_like(distorted, limit) if math.isfinite(limit) else distorted.copy()
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        if not math.isfinite(limit):
            while (
                short := np.isfinite(high) & (high * _ascending(k, high, step) < distorted)
            ).any():
                high[short] *= 2
        w, moved = np.minimum(distorted, high), high - low
        done = distorted == 0
        for _ in range(_MOST_HALVINGS):
            if done.all():
                break
            value = w * _ascending(k, w, step) - distorted
            low, high = np.where(value < 0, w, low), np.where(value < 0, high, w)
            newton = w - value / _ascending(slope, w, step)
            # Bisect where Newton's step leaves the bracket or does not halve the last one.
            trusted = (newton >= low) & (newton <= high) & (np.abs(newton - w) <= moved / 2)
            new = np.where(done, w, np.where(trusted, newton, low + (high - low) / 2))
            moved = np.abs(new - w)
            w = new
            done |= moved <= 2 * _EPS * w
    return w


def _polynomial(coefficients: ArrayLike, powers: str) -> tuple[Array, int]:
    """Coefficients of f from the constant on, ``(m + 1,)``, and the step of its powers."""
    if powers not in _STEPS:
        raise InputError(f"powers must be all or even, not {powers!r}")
    k = finite_vector(coefficients, None, "coefficients")
    return np.concatenate([[1.0], k]), _STEPS[powers]


def _slope(k: Array, step: int) -> Array:
    """Coefficients of d(w f(w))/dw, in the same powers as f's."""
    return k * (1 + step * np.arange(len(k)))


def _ascending(k: Array, w: Array | float, step: int) -> Array:
    """Sum of k_j w^(step j)."""
    return np.asarray(np.polynomial.polynomial.polyval(w**step, k), dtype=np.float64)


def _rounding(k: Array, w: float, step: int) -> float:
    """Bound what rounding can make of a sum of k_j w^(step j), its coefficients' included.

    Horner's rule errs by up to 2m eps times the sum of the terms' sizes (Higham 2002,
    section 5.1); eigenvalues give roots at which the sum is a few times that.
    """
    return 16 * len(k) * _EPS * float(_ascending(np.abs(k), w, step))
