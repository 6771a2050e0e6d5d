"""Lenses against those of other tools, and against their authors' closed forms.

Truths: the projections of OpenCV and COLMAP, and the rays of published formulas in 40 digits.
"""

from __future__ import annotations

import cv2
import numpy as np
import pycolmap
import pytest
from mpmath import mp

from bayescal.cameras.lenses.planar import Planar
from tests.helpers.lenses import CASES

MATRIX = np.array([[1400.0, 0, 955], [0, 1350, 540], [0, 0, 1]])


def pixels(case, rays):
    return case.lens.distort(rays, case.k) * [1400, 1350] + [955, 540]


def opencv_vector(lens, k):
    """Coefficients in OpenCV's places, zero where the lens has none."""
    order = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
    return np.array([dict(zip(lens.names, k, strict=True)).get(name, 0.0) for name in order])


def is_opencvs(lens):
    return isinstance(lens, Planar) and lens.numerator <= 3 and lens.step == 2


def some(chosen):
    kept = [case for case in CASES if chosen(case.lens)]
    return pytest.mark.parametrize("case", kept, ids=[case.label for case in kept])


@some(is_opencvs)
def test_projection_is_opencvs(case):
    rays = case.rays()
    k = opencv_vector(case.lens, case.k)
    truth, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), MATRIX, k)
    np.testing.assert_allclose(pixels(case, rays), truth[:, 0], rtol=0, atol=1e-9)


@some(lambda lens: lens.name == "fisheye" and lens.order <= 4)
def test_projection_is_that_of_opencvs_fisheye(case):
    rays = case.rays()
    rays = rays[rays[:, 2] > 0.05]
    k = np.append(case.k, np.zeros(4 - len(case.k)))
    truth, _ = cv2.fisheye.projectPoints(rays[:, None], np.zeros(3), np.zeros(3), MATRIX, k)
    np.testing.assert_allclose(pixels(case, rays), truth[:, 0], rtol=0, atol=1e-9)


def colmap_model(case):
    """COLMAP's name and the coefficients that it takes; None where it has no such model."""
    lens, k = case.lens, opencv_vector(case.lens, case.k)
    if lens.name in ("division", "eucm"):
        return lens.name.upper(), case.k
    if lens.name == "fisheye" and lens.order <= 4:
        return "OPENCV_FISHEYE", np.append(case.k, np.zeros(4 - lens.order))
    if is_opencvs(lens) and not lens.prism:
        return ("FULL_OPENCV", k[:8]) if k[4:].any() else ("OPENCV", k[:4])
    return None


@pytest.mark.parametrize(
    "case", [case for case in CASES if colmap_model(case)], ids=lambda case: case.label
)
def test_projection_is_colmaps(case):
    """COLMAP's pixel centres at 0.5 are a matter of the principal point, the same number here."""
    rays = case.rays()
    rays = rays[rays[:, 2] > 0.05]
    model, k = colmap_model(case)
    camera = pycolmap.Camera(
        model=model, width=1911, height=1081, params=[1400, 1350, 955, 540, *k]
    )
    truth = camera.img_from_cam(rays)
    np.testing.assert_allclose(pixels(case, rays), truth, rtol=0, atol=1e-9)


def ray_of_division(u, v, bend):
    return u, v, 1 + bend * (u**2 + v**2)


def ray_of_eucm(u, v, alpha, beta):
    """Khomutenko, Garcia & Martinet 2016, eq. 10."""
    square = u**2 + v**2
    root = mp.sqrt(1 - (2 * alpha - 1) * beta * square)
    return u, v, (1 - beta * alpha**2 * square) / (alpha * root + 1 - alpha)


def ray_of_double_sphere(u, v, xi, alpha):
    """Usenko, Demmel & Cremers 2018, eq. 46-50."""
    square = u**2 + v**2
    root = mp.sqrt(1 - (2 * alpha - 1) * square)
    depth = (1 - alpha**2 * square) / (alpha * root + 1 - alpha)
    scale = (depth * xi + mp.sqrt(depth**2 + (1 - xi**2) * square)) / (depth**2 + square)
    return scale * u, scale * v, scale * depth - xi


CLOSED = {
    "division": ray_of_division,
    "eucm": ray_of_eucm,
    "double-sphere": ray_of_double_sphere,
}


@some(lambda lens: lens.name in CLOSED)
def test_rays_are_those_of_the_authors_closed_form_past_ninety_degrees_too(case):
    rays = case.rays()
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    if case.angle > np.pi / 2:
        assert (unit[:, 2] < 0).any()
    plane = case.lens.distort(rays, case.k)
    with mp.workdps(40):
        for at, (u, v) in enumerate(plane):
            truth = CLOSED[case.lens.name](mp.mpf(u), mp.mpf(v), *(mp.mpf(x) for x in case.k))
            length = mp.sqrt(sum(x**2 for x in truth))
            np.testing.assert_allclose(unit[at], [float(x / length) for x in truth], atol=1e-13)


@some(lambda lens: lens.name == "fisheye")
def test_a_fisheye_is_its_polynomial_past_ninety_degrees_too(case):
    rays = case.rays()
    plane = case.lens.distort(rays, case.k)
    with mp.workdps(40):
        for (x, y, z), found in zip(rays, plane, strict=True):
            rho = mp.sqrt(mp.mpf(x) ** 2 + mp.mpf(y) ** 2)
            angle = mp.atan2(rho, z)
            gain = 1 + sum(mp.mpf(k) * angle ** (2 * j + 2) for j, k in enumerate(case.k))
            scale = angle * gain / rho if rho else 0
            np.testing.assert_allclose(found, [float(x * scale), float(y * scale)], atol=1e-14)
