"""Pinhole geometry step by step: frames, perspective, pixels (thesis, chapter 3).

The thesis's conventions hold throughout:

- x points right, y up, z forward: a *left-handed* frame, in which a positive
  rotation follows the left-hand rule. OpenCV's and mrcal's is right-handed, y down;
  negating y of both the world and the camera turns the one into the other.
- r grows to the right and c upwards. Pixel centres are at integers: an image runs
  from r = -1/2 to width - 1/2, and with c = height - row from c = 1/2 to height + 1/2.

The chain is world -> camera (`world_to_camera`, eq. 20), camera -> image plane
(`project`, eq. 8), image plane -> pixel (`to_pixels`, eq. 16-17); lens distortion
(`bayescal.cameras.distortion`) acts on the image plane, and without it the chain is
one matrix (`bayescal.cameras.projection`). lambda, s_x, s_y and the image plane share
a unit, mm say; s_x and s_y are that unit per px.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bayescal.arrays import Array, ArrayLike
from bayescal.cameras.checks import bounded, finite_table, finite_vector, pixel_sizes, positive
from bayescal.errors import InputError
from bayescal.points.correspondences import LARGEST


def project(points: ArrayLike, focal_length: float = 1.0, *, in_front: bool = False) -> Array:
    """Perspective projection: u = lambda x / z, v = lambda y / z.

    Thesis eq. 6-8; Hartley & Zisserman 2004, section 6.1.

    Parameters
    ----------
    points : array_like
        x, y, z in the camera's frame, ``(n, 3)``, any one unit.
    focal_length : float, optional
        lambda > 0, in the unit u and v are wanted in; 1 gives the dimensionless
        x/z and y/z.
    in_front : bool, optional
        Refuse points behind the camera too; the equations alone accept them.

    Returns
    -------
    Array
        u, v on the image plane, ``(n, 2)``, in the unit of `focal_length`.

    Raises
    ------
    InputError
        Where the shape or a number can't be used, or naming the first point
        that has z = 0 (with `in_front`, z <= 0) or lies so close to it that u or
        v overflows.
    """
    p = finite_table(points, 3, "points")
    focal = positive(focal_length, "focal length")
    z = p[:, 2]
    behind = np.flatnonzero(z <= 0) if in_front else np.flatnonzero(z == 0)
    if behind.size:
        first = int(behind[0])
        what = "is not in front of the camera" if z[first] else "is in the camera's plane"
        raise InputError(
            f"point {first + 1}: {what} (z is {z[first]:g}), and has no image; remove it"
        )
    with np.errstate(over="ignore"):
        return bounded(focal * p[:, :2] / z[:, None])


def back_project(image: ArrayLike, depth: ArrayLike | float, focal_length: float = 1.0) -> Array:
    """Points of the camera's frame that have given images and depths: x = u z / lambda.

    Inverse of `project` (thesis eq. 8).

    Parameters
    ----------
    image : array_like
        u, v on the image plane, ``(n, 2)``, in the unit of `focal_length`.
    depth : array_like or float
        z of each point, ``(n,)``, or one for all, not zero.
    focal_length : float, optional
        lambda > 0.

    Returns
    -------
    Array
        x, y, z in the camera's frame, ``(n, 3)``, in the unit of `depth`.

    Raises
    ------
    InputError
        Where a shape or a number can't be used, or naming the first depth of zero.
    """
    uv = finite_table(image, 2, "image")
    focal = positive(focal_length, "focal length")
    z = np.asarray(depth, dtype=np.float64)
    if z.shape not in ((), (len(uv),)):
        raise InputError(f"depth must have shape ({len(uv)},) like image, not {z.shape}")
    z = np.broadcast_to(z, (len(uv),))
    bad = np.flatnonzero(~(np.abs(z) < LARGEST) | (z == 0))
    if bad.size:
        first = int(bad[0])
        raise InputError(f"point {first + 1}: depth is {z[first]:g}; it must be finite, not zero")
    return np.column_stack([uv * z[:, None] / focal, z])


def to_pixels(image: ArrayLike, centre: ArrayLike, pixel_size: ArrayLike = (1.0, 1.0)) -> Array:
    """Pixel coordinates of the image plane: r = u0 + u / s_x, c = v0 + v / s_y.

    Thesis eq. 16-17 (eq. 11-12 with square pixels of size 1).

    Parameters
    ----------
    image : array_like
        u, v on the image plane, ``(n, 2)``.
    centre : array_like
        u0, v0: the principal point, ``(2,)``, px.
    pixel_size : array_like, optional
        s_x, s_y > 0: width and height of a pixel, ``(2,)``, unit of u and v per px.

    Returns
    -------
    Array
        r, c, ``(n, 2)``, px.

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    uv = finite_table(image, 2, "image")
    with np.errstate(over="ignore"):
        return bounded(finite_vector(centre, 2, "centre") + uv / pixel_sizes(pixel_size))


def from_pixels(pixels: ArrayLike, centre: ArrayLike, pixel_size: ArrayLike = (1.0, 1.0)) -> Array:
    """Image plane of pixel coordinates: u = s_x (r - u0), v = s_y (c - v0).

    Thesis eq. 18-19; inverse of `to_pixels`, with the same parameters.

    Returns
    -------
    Array
        u, v on the image plane, ``(n, 2)``, in the unit of `pixel_size` times px.

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    rc = finite_table(pixels, 2, "pixels")
    return pixel_sizes(pixel_size) * (rc - finite_vector(centre, 2, "centre"))


def rotation_matrix(rotation: ArrayLike) -> Array:
    """Rotation matrix R of a rotation vector, ``(3, 3)`` (Rodrigues' formula, by scipy).

    R takes world directions to the camera's frame. Its *columns* are the world's
    axes seen from the camera; the thesis's remark below eq. 27 says rows.

    Parameters
    ----------
    rotation : array_like
        Axis times angle, ``(3,)``, rad; OpenCV's ``rvec``. Of a matrix it is
        ``scipy.spatial.transform.Rotation.from_matrix(R).as_rotvec()``.

    Raises
    ------
    InputError
        Where it is not three finite numbers.
    """
    vector = finite_vector(rotation, 3, "rotation vector")
    return np.asarray(Rotation.from_rotvec(vector).as_matrix(), dtype=np.float64)


def world_to_camera(points: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Points in the camera's frame: p_c = R p_w + T.

    Thesis eq. 20-22; Hartley & Zisserman 2004, section 6.1. Eq. 23-25 write
    R_i' (p_w + T), which rotates T too and is at odds with eq. 20 (and with
    eq. 26-27, where the world's origin lands on T), whether R_i is a row or a
    column of R. Eq. 20 is what is done here.

    Parameters
    ----------
    points : array_like
        World points, ``(n, 3)``, world units.
    rotation : array_like
        Rotation vector of R, ``(3,)``, rad (`rotation_matrix`).
    translation : array_like
        T: the world's origin in the camera's frame, ``(3,)``, world units; not the
        camera's position, which is `camera_centre`.

    Returns
    -------
    Array
        Points in the camera's frame, ``(n, 3)``, world units.

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    p = finite_table(points, 3, "points")
    return p @ rotation_matrix(rotation).T + finite_vector(translation, 3, "translation")


def camera_to_world(points: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> Array:
    """World points of points in the camera's frame: p_w = R' (p_c - T).

    Inverse of `world_to_camera` (thesis eq. 20), with the same parameters, shapes,
    units and errors.
    """
    p = finite_table(points, 3, "points")
    return (p - finite_vector(translation, 3, "translation")) @ rotation_matrix(rotation)


def camera_centre(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Position of the camera in the world, -R' T, ``(3,)``, world units.

    Where eq. 20 of the thesis gives p_c = 0 (Hartley & Zisserman 2004, section 6.1).

    Raises
    ------
    InputError
        Where a shape or a number can't be used.
    """
    return -finite_vector(translation, 3, "translation") @ rotation_matrix(rotation)
