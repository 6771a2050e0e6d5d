r"""The pinhole camera as one matrix, P = K [R T] (thesis eq. 1).

The conventions are those of `bayescal.cameras.geometry`, whose steps P does at once.

Eq. 15, which goes from the camera's frame to the pixel in one matrix, is misprinted.
By eq. 13-14 it is K / z,

    [r]   [lambda/z     0      u0/z ] [x]
    [c] = [    0     lambda/z  v0/z ] [y],
    [1]   [    0        0      1/z  ] [z]

since the last row must give z/z = 1; lambda/z, as printed, gives lambda, and then
(r, c) divided by lambda. Eq. 10 has the same slip. Eq. 2, which the text calls the
distortion polynomial, is missing from the thesis.
"""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array, ArrayLike
from bayescal.cameras.checks import bounded, finite_table, finite_vector, pixel_sizes, positive
from bayescal.cameras.geometry import rotation_matrix
from bayescal.errors import InputError

# A dot product of four terms errs by less than 4 eps times the sum of their sizes (Higham
# 2002, section 3.1), and its factors are rounded too; a depth below this is zero to rounding.
_DOT_ERROR = 16 * np.finfo(np.float64).eps


def intrinsic_matrix(
    focal_length: float, centre: ArrayLike, pixel_size: ArrayLike = (1.0, 1.0)
) -> Array:
    """Intrinsic matrix K = [[lambda/s_x, 0, u0], [0, lambda/s_y, v0], [0, 0, 1]].

    Thesis eq. 1, where f = lambda/s_x = lambda/s_y, with the pixel sizes of
    eq. 16-17; Hartley & Zisserman 2004, section 6.1. K / z is the matrix that eq. 15
    misprints (see the module's description).

    Parameters
    ----------
    focal_length : float
        lambda > 0; with the default pixel size, f in px.
    centre : array_like
        u0, v0: the principal point, ``(2,)``, px.
    pixel_size : array_like, optional
        s_x, s_y > 0, ``(2,)``, unit of `focal_length` per px.

    Returns
    -------
    Array
        K, ``(3, 3)``, px (the last row has no unit).

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    k = np.eye(3)
    k[[0, 1], [0, 1]] = positive(focal_length, "focal length") / pixel_sizes(pixel_size)
    k[:2, 2] = finite_vector(centre, 2, "centre")
    return k


def projection_matrix(intrinsic: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Projection matrix P = K [R T].

    Thesis eq. 1; Hartley & Zisserman 2004, section 6.1.

    Parameters
    ----------
    intrinsic : array_like
        K, ``(3, 3)``, from `intrinsic_matrix`.
    rotation, translation : array_like
        Rotation vector of R, ``(3,)``, rad, and T, ``(3,)``, world units.

    Returns
    -------
    Array
        P, ``(3, 4)``.

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    k = finite_table(intrinsic, 3, "intrinsic matrix")
    if len(k) != 3:
        raise InputError(f"intrinsic matrix must have shape (3, 3), not {k.shape}")
    pose = np.column_stack(
        [rotation_matrix(rotation), finite_vector(translation, 3, "translation")]
    )
    return k @ pose


def homogeneous(points: ArrayLike) -> Array:
    """Homogeneous coordinates x, y, z, 1 of points, ``(n, 4)`` from ``(n, 3)``.

    Raises
    ------
    InputError
        Where the shape or a number can't be used.
    """
    p = finite_table(points, 3, "points")
    return np.column_stack([p, np.ones(len(p))])


def project_homogeneous(projection: ArrayLike, points: ArrayLike) -> Array:
    """Pixels of homogeneous world points: d [r, c, 1]' = P [x, y, z, 1]'.

    Thesis eq. 1, which calls the pixel (u, v). d is the depth z_c where P is
    K [R T] and the fourth coordinate is 1. Points behind the camera are projected
    like any others; points at infinity (fourth coordinate 0) have vanishing points.

    Parameters
    ----------
    projection : array_like
        P, ``(3, 4)``.
    points : array_like
        Homogeneous world points, ``(n, 4)`` (`homogeneous`).

    Returns
    -------
    Array
        r, c, ``(n, 2)``, px.

    Raises
    ------
    InputError
        Where a shape or a number can't be used, or naming the first point whose d
        is zero to rounding.
    """
    matrix = finite_table(projection, 4, "projection matrix")
    if len(matrix) != 3:
        raise InputError(f"projection matrix must have shape (3, 4), not {matrix.shape}")
    h = finite_table(points, 4, "points")
    scaled = h @ matrix.T
    depth = scaled[:, 2]
    flat = np.flatnonzero(np.abs(depth) <= _DOT_ERROR * (np.abs(h) @ np.abs(matrix[2])))
    if flat.size:
        raise InputError(
            f"point {int(flat[0]) + 1}: is in the camera's plane (d is 0), and has no image; "
            "remove it"
        )
    return bounded(scaled[:, :2] / depth[:, None])
