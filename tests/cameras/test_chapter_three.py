"""The thesis's chapter 3 by hand, its slips, and the product's camera against it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bayescal.cameras.camera import Camera
from bayescal.cameras.frames import Frame
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotation_vectors
from tests.helpers.chapter_three import (
    STEP,
    distort,
    intrinsic_matrix,
    project,
    projection_matrix,
    rotation_matrix,
    to_pixels,
    world_to_camera,
)

EPS = np.finfo(float).eps
# lambda = 8 mm, pixels of 4 um by 8 um: 2000 px and 1000 px.
FOCAL, CENTRE, SIZES = 8.0, (960.0, 540.0), (0.004, 0.008)
# A quarter turn about y: x -> -z, z -> x.
QUARTER, AWAY = np.array([0.0, math.pi / 2, 0.0]), np.array([0.0, 0.0, 5.0])
P = np.array([[-960.0, 0, 2000, 4800], [-540, 1000, 0, 2700], [-1, 0, 0, 5]])
INTRINSICS = np.array([2000.0, 1000.0, *CENTRE])


def test_the_chain_by_hand():
    # (1, 2, 3) is (3, 2, 4) to the camera: u = 6 and v = 4 mm, 960 + 1500 and 540 + 500 px.
    camera = world_to_camera([[1.0, 2.0, 3.0]], QUARTER, AWAY)
    np.testing.assert_allclose(camera, [[3.0, 2.0, 4.0]], rtol=8 * EPS)
    image = project(camera, FOCAL)
    np.testing.assert_allclose(image, [[6.0, 4.0]], rtol=8 * EPS)
    np.testing.assert_allclose(to_pixels(image, CENTRE, SIZES), [[2460, 1040]], rtol=8 * EPS)
    # (0.3, 0.4) is 0.5 from the centre: 1 + 0.2 * 0.5 + 0.4 * 0.25, and 1 + 0.05 + 0.025.
    point = np.array([[0.3, 0.4]])
    np.testing.assert_allclose(distort(point, [0.2, 0.4]), 1.2 * point, rtol=4 * EPS)
    np.testing.assert_allclose(distort(point, [0.2, 0.4], "even"), 1.075 * point, rtol=4 * EPS)


def test_equation_1_is_the_chain():
    matrix = projection_matrix(intrinsic_matrix(FOCAL, CENTRE, SIZES), QUARTER, AWAY)
    np.testing.assert_allclose(matrix, P, rtol=0, atol=4 * EPS * 4800)
    scaled = matrix @ [1.0, 2.0, 3.0, 1.0]
    np.testing.assert_allclose(scaled[:2] / scaled[2], [2460, 1040], rtol=8 * EPS)


def test_equation_15_needs_one_over_z():
    focal, z = 8.0, 4.0
    camera = np.array([3.0, 2.0, z])
    pixel = to_pixels(project([camera], focal), CENTRE)[0]  # eq. 13-14
    mended = intrinsic_matrix(focal, CENTRE) / z
    np.testing.assert_allclose(mended @ camera, [*pixel, 1.0], rtol=4 * EPS)
    printed = mended.copy()
    printed[2, 2] = focal / z
    assert (printed @ camera)[2] == focal
    # Nor does it hold up to a factor.
    assert np.abs((printed @ camera)[:2] / focal - pixel).min() > 100


def test_equations_23_to_25_are_not_equation_20():
    points, translation = np.array([[1.0, 2.0, 3.0]]), np.array([1.0, 0.0, 5.0])
    camera, matrix = world_to_camera(points, QUARTER, translation), rotation_matrix(QUARTER)
    for rows in (matrix, matrix.T):
        assert np.abs((points + translation) @ rows.T - camera).max() > 1


def test_columns_of_the_rotation_are_the_worlds_axes():
    """Eq. 20 with T = 0 and p_w = (1, 0, 0), which the thesis calls the first row."""
    x_axis = world_to_camera([[1.0, 0.0, 0.0]], QUARTER, np.zeros(3))[0]
    matrix = rotation_matrix(QUARTER)
    np.testing.assert_allclose(x_axis, matrix[:, 0], rtol=0, atol=EPS)
    assert not np.allclose(x_axis, matrix[0])


WORLD = np.random.default_rng(0).uniform([-200, -200, 700], [200, 200, 1100], (60, 3))
TURN, SHIFT = np.array([0.2, -0.1, 0.05]), np.array([40.0, -30.0, 120.0])


@pytest.mark.parametrize("powers", ["all", "even"])
@pytest.mark.parametrize("k", [[], [-0.1], [-0.2, 0.15]])
def test_the_camera_is_the_chain(powers, k):
    lens = lens_named("radial", order=len(k), tangential=False, step=STEP[powers])
    found, seen = Camera(lens).project(INTRINSICS, np.array(k), TURN, SHIFT, WORLD)
    # The camera's plane has unit focal length: the image plane's unit is lambda.
    image = distort(project(world_to_camera(WORLD, TURN, SHIFT)), k, powers)
    truth = to_pixels(FOCAL * image, CENTRE, SIZES)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-9)
    assert seen.all()


def test_without_distortion_the_camera_is_equation_1():
    lens = lens_named("radial", order=0, tangential=False)
    found, _ = Camera(lens).project(INTRINSICS, np.zeros(0), TURN, SHIFT, WORLD)
    matrix = projection_matrix(intrinsic_matrix(FOCAL, CENTRE, SIZES), TURN, SHIFT)
    scaled = np.column_stack([WORLD, np.ones(60)]) @ matrix.T
    np.testing.assert_allclose(found, scaled[:, :2] / scaled[:, 2:], rtol=0, atol=1e-9)


@pytest.mark.parametrize("height", [None, 1080.0])
def test_the_frame_with_y_up_is_opencvs_seen_in_a_mirror(height):
    frame, lens = Frame(height), lens_named("radial", order=1, tangential=False)
    k, matrix = np.array([-0.1]), rotation_matrix(TURN)
    position = -matrix.T @ SHIFT
    there = to_pixels(
        FOCAL * distort(project(world_to_camera(WORLD, TURN, SHIFT)), k, "even"), CENTRE, SIZES
    )
    turned, translation = frame.pose(matrix, position)
    centre = frame.pixels(np.array(CENTRE))
    intrinsics = np.array([2000.0, 1000.0, *centre])
    found, _ = Camera(lens).project(
        intrinsics, k, rotation_vectors(turned), translation, frame.points(WORLD)
    )
    np.testing.assert_allclose(found, frame.pixels(there), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(frame.points(frame.points(WORLD)), WORLD)
    assert (found[:, 1] == there[:, 1]).any() == (height is None)
