"""Polynomials 1 + k_1 t + k_2 t^2 + ... of many cameras at once."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array


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


def first_root(polynomial: Array) -> Array:
    """Smallest positive root t of 1 + a_1 t + ... + a_d t^d, ``(...)`` of a_1.. ``(..., d)``.

    Infinite where there is none. In 1/t the polynomial is monic, so its companion matrix exists
    whatever a_d is. A double root comes out as a pair slightly complex, and counts.
    """
    degree = polynomial.shape[-1]
    if not degree:
        return np.full(polynomial.shape[:-1], np.inf)
    companion = np.zeros((*polynomial.shape[:-1], degree, degree))
    companion[..., 0, :] = -polynomial
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1
    found = np.linalg.eigvals(companion)
    real = (found.real > 0) & (np.abs(found.imag) <= 1e-7 * np.abs(found.real))
    largest = np.where(real, found.real, 0).max(axis=-1)
    with np.errstate(divide="ignore"):
        return np.asarray(1 / largest)
