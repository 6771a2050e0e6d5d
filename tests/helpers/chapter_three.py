"""The thesis's chapter 3, equation by equation: the oracle of the product's camera.

x points right, y up, z forward, r to the right and c upwards; every array holds points in rows. The
slips of eq. 10, 15 and 23-25 are what tests/cameras/test_chapter_three.py shows them to be.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

STEP = {"all": 1, "even": 2}


def rotation_matrix(vector):
    """R of a rotation vector, by scipy."""
    return Rotation.from_rotvec(vector).as_matrix()


def world_to_camera(points, rotation, translation):
    """Eq. 20-22: p_c = R p_w + T."""
    return np.asarray(points) @ rotation_matrix(rotation).T + translation


def project(points, focal_length=1.0):
    """Eq. 6-8: u = lambda x / z, v = lambda y / z."""
    points = np.asarray(points, dtype=float)
    return focal_length * points[:, :2] / points[:, 2:]


def distort(image, coefficients, powers="all"):
    """Eq. 3-5: u (1 + k_1 w + k_2 w^2 + ...), or in even powers of w as they are usual."""
    radius = np.hypot(image[:, 0], image[:, 1])
    terms = [k * radius ** (STEP[powers] * (j + 1)) for j, k in enumerate(coefficients)]
    return image * (1 + sum(terms, np.zeros_like(radius)))[:, None]


def to_pixels(image, centre, pixel_size=(1.0, 1.0)):
    """Eq. 16-17: r = u0 + u / s_x, c = v0 + v / s_y."""
    return np.asarray(centre) + image / np.asarray(pixel_size)


def intrinsic_matrix(focal_length, centre, pixel_size=(1.0, 1.0)):
    """K of eq. 1 with the pixel sizes of eq. 16-17."""
    out = np.eye(3)
    out[[0, 1], [0, 1]] = focal_length / np.asarray(pixel_size)
    out[:2, 2] = centre
    return out


def projection_matrix(intrinsic, rotation, translation):
    """Eq. 1: P = K [R T]."""
    return intrinsic @ np.column_stack([rotation_matrix(rotation), translation])
