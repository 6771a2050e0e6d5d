"""Polynomials 1 + k_1 t + k_2 t^2 + ... of many cameras at once."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array

FARTHEST = 1e-16  # 1/t: what lies beyond is as good as infinitely far
LARGEST = 1e30
_EPS = float(np.finfo(np.float64).eps)
_MOST_HALVINGS = 100  # geometric ones, of a bracket from 1e-16 to 1e100


def horner(k: Array, t: Array) -> Array:
    """1 + k_1 t + k_2 t^2 + ..., ``(..., n)`` of ``(..., m)`` and ``(..., n)``."""
    if not k.shape[-1]:
        return np.ones_like(t)
    total = k[..., -1, None] * t
    for j in reversed(range(k.shape[-1] - 1)):
        total = (total + k[..., j, None]) * t
    return np.asarray(total + 1)


def horner_slope(k: Array, t: Array) -> Array:
    """k_1 + 2 k_2 t + ..., the derivative of `horner` by t."""
    total = np.zeros_like(t)
    for j in reversed(range(k.shape[-1])):
        total = total * t + (j + 1) * k[..., j, None]
    return total


def with_one(k: Array) -> Array:
    """All coefficients from the constant on, ``(..., m + 1)`` of ``(..., m)``."""
    return np.concatenate([np.ones((*k.shape[:-1], 1)), k], axis=-1)


def product(one: Array, other: Array) -> Array:
    """Coefficients of the product of two, from the constant on."""
    out = np.zeros((*one.shape[:-1], one.shape[-1] + other.shape[-1] - 1))
    for j in range(other.shape[-1]):
        out[..., j : j + one.shape[-1]] += other[..., j, None] * one
    return out


def first_root(k: Array) -> Array:
    """Smallest t > 0 at which 1 + k_1 t + ... + k_m t^m is zero or touches it, ``(...)``.

    Infinite where there is none up to 1e16, 0 where a coefficient is nan or above 1e30. In
    s = 1/t the polynomial is monic, and its largest root is wanted. A double root comes out of the
    eigenvalues as a pair slightly complex or slightly apart, so they only say where to look: their
    real parts, and the points between, are gone through downwards for the first value that is
    negative or zero to rounding.
    """
    degree = k.shape[-1]
    if not degree:
        return np.full(k.shape[:-1], np.inf)
    bad = ~(np.abs(k) < LARGEST).all(axis=-1)
    k = np.where(bad[..., None], 0.0, k)
    companion = np.zeros((*k.shape, degree))
    companion[..., 0, :] = -k
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1
    found = np.maximum(np.sort(np.linalg.eigvals(companion).real)[..., ::-1], FARTHEST)
    last = np.full((*bad.shape, 1), FARTHEST)
    between = (found + np.append(found[..., 1:], last, axis=-1)) / 2
    places = np.stack([found, between], axis=-1).reshape(*bad.shape, 2 * degree)
    places = np.append(places, last, axis=-1)
    value, rounding = _monic(k[..., None, :], places)
    hit = value <= rounding
    at = hit.argmax(axis=-1)[..., None]
    low = np.take_along_axis(places, at, -1)[..., 0]
    # No root is as large (Fujiwara 1916).
    bound = 2 * (np.abs(k) ** (1 / np.arange(1, degree + 1))).max(axis=-1)
    above = np.take_along_axis(places, np.maximum(at - 1, 0), -1)[..., 0]
    high = np.where(at[..., 0] == 0, bound, above)
    crossed = np.take_along_axis(value < -rounding, at, -1)[..., 0]
    root = _bisected(k, low, np.where(crossed, high, low))
    return np.asarray(np.where(bad, 0.0, np.where(hit.any(axis=-1), 1 / root, np.inf)))


def _monic(k: Array, s: Array) -> tuple[Array, Array]:
    """s^m + k_1 s^(m-1) + ... and what rounding can make of it (Higham 2002, section 5.1)."""
    value, size = np.ones_like(s), np.ones_like(s)
    for j in range(k.shape[-1]):
        value, size = value * s + k[..., j], size * s + np.abs(k[..., j])
    return value, 16 * (k.shape[-1] + 1) * _EPS * size


def _bisected(k: Array, low: Array, high: Array) -> Array:
    """Roots between `low`, where a monic polynomial is negative, and `high`, ``(...)``."""
    for _ in range(_MOST_HALVINGS):
        if (high - low <= 2 * _EPS * high).all():
            break
        middle = np.sqrt(low * high)
        below = _monic(k, middle)[0] < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return high
