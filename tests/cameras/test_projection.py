"""P = K [R T] against the chain it stands for, and against numbers worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bayescal.cameras.geometry import camera_centre, project, to_pixels, world_to_camera
from bayescal.cameras.projection import (
    homogeneous,
    intrinsic_matrix,
    project_homogeneous,
    projection_matrix,
)
from bayescal.errors import InputError

EPS = np.finfo(float).eps

# lambda = 8 mm, pixels of 4 um by 8 um: 2000 px and 1000 px.
FOCAL, CENTRE, SIZES = 8.0, (960.0, 540.0), (0.004, 0.008)
# A quarter turn about y: x -> -z, z -> x.
QUARTER, AWAY = (0.0, math.pi / 2, 0.0), (0.0, 0.0, 5.0)
P = np.array(
    [
        [-960.0, 0.0, 2000.0, 4800.0],
        [-540.0, 1000.0, 0.0, 2700.0],
        [-1.0, 0.0, 0.0, 5.0],
    ]
)

# Thousandths: sums of numbers near the smallest double are rounded to its multiples.
coordinate = st.integers(-(10**6), 10**6).map(lambda n: n / 1000)
spatial = arrays(float, st.tuples(st.integers(1, 8), st.just(3)), elements=coordinate)
vector = arrays(float, 3, elements=coordinate)
rotation = arrays(float, 3, elements=st.floats(-10, 10))


def step_by_step(points, turn, translation):
    image = project(world_to_camera(points, turn, translation), FOCAL)
    return to_pixels(image, CENTRE, SIZES)


class TestMatrices:
    def test_intrinsics_by_hand(self):
        k = intrinsic_matrix(FOCAL, CENTRE, SIZES)
        expected = [[2000.0, 0.0, 960.0], [0.0, 1000.0, 540.0], [0.0, 0.0, 1.0]]
        np.testing.assert_allclose(k, expected, rtol=2 * EPS)

    def test_projection_by_hand(self):
        p = projection_matrix(intrinsic_matrix(FOCAL, CENTRE, SIZES), QUARTER, AWAY)
        np.testing.assert_allclose(p, P, rtol=0, atol=4 * EPS * 4800)

    def test_equation_15_needs_one_over_z(self):
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

    @pytest.mark.parametrize("shape", [(2, 3), (4, 3), (3, 4), (3,)])
    def test_refuses_an_intrinsic_matrix_of_another_shape(self, shape):
        with pytest.raises(InputError, match="intrinsic matrix must have shape"):
            projection_matrix(np.ones(shape), QUARTER, AWAY)

    def test_refuses_intrinsics_that_are_none(self):
        with pytest.raises(InputError, match="focal length must be a positive"):
            intrinsic_matrix(0.0, CENTRE)
        with pytest.raises(InputError, match="pixel size must be two positive"):
            intrinsic_matrix(1.0, CENTRE, (1.0, 0.0))
        with pytest.raises(InputError, match=r"centre must have shape \(2,\)"):
            intrinsic_matrix(1.0, (1.0, 2.0, 3.0))


class TestProjection:
    def test_by_hand(self):
        # (1, 2, 3) is (3, 2, 4) to the camera: 960 + 1500 and 540 + 500 px.
        pixels = project_homogeneous(P, [[1.0, 2.0, 3.0, 1.0]])
        assert pixels.tolist() == [[2460.0, 1040.0]]
        chain = step_by_step([[1.0, 2.0, 3.0]], QUARTER, AWAY)
        np.testing.assert_allclose(chain, pixels, rtol=8 * EPS)

    @given(spatial, rotation, vector)
    def test_is_the_chain_of_steps(self, points, turn, translation):
        camera = world_to_camera(points, turn, translation)
        assume((np.abs(camera[:, 2]) > 1e-3).all())
        p = projection_matrix(intrinsic_matrix(FOCAL, CENTRE, SIZES), turn, translation)
        pixels = project_homogeneous(p, homogeneous(points))
        # Each coordinate of the camera's frame rounds at the size of what is summed, up to
        # 16 eps of it; the pixel is a ratio of two such sums.
        reach = np.abs(points).sum(axis=1) + np.abs(translation).sum()
        relative = 16 * EPS * reach / np.abs(camera[:, 2])
        lost = relative[:, None] * (np.abs(pixels) + 4000)
        assert (np.abs(pixels - step_by_step(points, turn, translation)) <= lost).all()

    @given(spatial, st.floats(1e-3, 1e3), st.sampled_from([-1.0, 1.0]))
    def test_the_scale_of_homogeneous_points_cancels(self, points, factor, sign):
        points[:, 0] = -np.abs(points[:, 0])  # d is at least 5
        scaled = sign * factor * homogeneous(points)
        np.testing.assert_allclose(
            project_homogeneous(P, scaled),
            project_homogeneous(P, homogeneous(points)),
            rtol=0,
            atol=64 * EPS * 3e6,
        )

    def test_points_at_infinity_have_vanishing_points(self):
        # The world's -x runs along the optical axis, and meets the image at its centre.
        assert project_homogeneous(P, [[-1.0, 0.0, 0.0, 0.0]]).tolist() == [[960.0, 540.0]]
        far = project_homogeneous(P, [[-1e12, 0.0, 0.0, 1.0]])
        np.testing.assert_allclose(far, [[960.0, 540.0]], rtol=1e-11)

    def test_transposing_the_rotation_would_show(self):
        wrong = projection_matrix(intrinsic_matrix(FOCAL, CENTRE, SIZES), -np.array(QUARTER), AWAY)
        pixels = project_homogeneous(wrong, [[1.0, 2.0, 3.0, 1.0]])
        assert np.abs(pixels - [[2460.0, 1040.0]]).max() > 100

    @given(rotation, vector)
    def test_refuses_the_camera_centre(self, turn, translation):
        p = projection_matrix(np.eye(3), turn, translation)
        centre = homogeneous(camera_centre(turn, translation)[None])
        points = np.vstack([homogeneous(rotated_forward(turn, translation)), centre])
        with pytest.raises(InputError, match=r"^point 2: is in the camera's plane"):
            project_homogeneous(p, points)

    def test_refuses_a_matrix_of_another_shape(self):
        with pytest.raises(InputError, match=r"projection matrix must have shape \(3, 4\)"):
            project_homogeneous(np.ones((2, 4)), [[1.0, 2.0, 3.0, 1.0]])
        with pytest.raises(InputError, match="projection matrix must have shape"):
            project_homogeneous(np.eye(3), [[1.0, 2.0, 3.0, 1.0]])

    def test_refuses_points_that_are_not_homogeneous(self):
        with pytest.raises(InputError, match=r"points must have shape \(n, 4\)"):
            project_homogeneous(P, [[1.0, 2.0, 3.0]])


def rotated_forward(turn, translation):
    """A world point 1000 in front of the camera."""
    forward = world_to_camera([[0.0, 0.0, 1000.0]], -turn, (0.0, 0.0, 0.0))
    return camera_centre(turn, translation) + forward
