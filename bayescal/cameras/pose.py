r"""Rotations as vectors and matrices, many at once, and how a small turn moves a point.

A rotation vector v is an axis times an angle (Rodrigues): R = exp([v]x), with [v]x p = v x p. A
pose takes world points to the camera's frame, p = R X + t. Derivatives by a pose are those by a
*left* perturbation, on the camera's side: p = exp([d]x) R X + t + e at d = e = 0, where

    dp/dd = -[R X]x,    dp/de = I.

d has no singular angle, and the uniform distribution over rotations has density 1/(8 pi^2) per
unit of d at d = 0. By the rotation vector itself they are dp/dv = -[R X]x J(v), J the
`left_jacobian` (Sola, Deray & Atchuthan 2018, arXiv:1812.01537, eq. 144-145).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bayescal.arrays import Array

_SMALL = 0.1  # rad: below it a series of five terms is exact to rounding


def rotations(vectors: Array) -> Array:
    """Rotation matrices of rotation vectors, ``(..., 3, 3)`` from ``(..., 3)``; complex too."""
    square = (vectors**2).sum(axis=-1)[..., None, None]
    angle = np.sqrt(square)
    some = np.where(square == 0, 1, angle)
    first = np.where(square == 0, 1, np.sin(angle) / some)  # sin(a) / a
    half = np.where(square == 0, 1, np.sin(angle / 2) / (some / 2))
    cross = cross_matrices(vectors)
    rotated = np.eye(3) + first * cross + half**2 / 2 * (cross @ cross)
    return np.asarray(rotated)


def rotation_vectors(matrices: Array) -> Array:
    """Rotation vectors of rotation matrices, ``(..., 3)`` from ``(..., 3, 3)``, rad, up to pi."""
    flat = Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_rotvec()
    return np.asarray(flat, dtype=np.float64).reshape(matrices.shape[:-1])


def cross_matrices(vectors: Array) -> Array:
    """Matrices [v]x of vectors, ``(..., 3, 3)`` from ``(..., 3)``: [v]x p = v x p."""
    out = np.zeros((*vectors.shape, 3), dtype=vectors.dtype)
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = x, y, z
    out[..., 1, 2], out[..., 2, 0], out[..., 0, 1] = -x, -y, -z
    return out


def left_jacobian(vectors: Array) -> Array:
    """J(v), ``(..., 3, 3)``: exp([v + e]x) = exp([J(v) e]x) exp([v]x) for a small e."""
    square = (vectors**2).sum(axis=-1)[..., None, None]
    angle = np.sqrt(square)
    some = np.where(angle < _SMALL, 1, angle)
    half = np.where(square == 0, 1, np.sin(angle / 2) / np.where(square == 0, 1, angle / 2))
    series = (1 - square / 20 * (1 - square / 42 * (1 - square / 72 * (1 - square / 110)))) / 6
    third = np.where(angle < _SMALL, series, (some - np.sin(some)) / some**3)
    cross = cross_matrices(vectors)
    return np.asarray(np.eye(3) + half**2 / 2 * cross + third * (cross @ cross))
