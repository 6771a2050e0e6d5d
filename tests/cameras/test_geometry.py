"""The pinhole chain step by step: truths worked by hand, inverses, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bayescal.cameras.geometry import (
    back_project,
    camera_centre,
    camera_to_world,
    from_pixels,
    project,
    rotation_matrix,
    to_pixels,
    world_to_camera,
)
from bayescal.errors import InputError

EPS = np.finfo(float).eps

# Thousandths: sums of numbers near the smallest double are rounded to its multiples.
coordinate = st.integers(-(10**7), 10**7).map(lambda n: n / 1000)
depth = st.floats(1e-3, 1e4) | st.floats(-1e4, -1e-3)
vector = arrays(float, 3, elements=coordinate)
rotation = arrays(float, 3, elements=st.floats(-10, 10))
planar = arrays(float, st.tuples(st.integers(0, 8), st.just(2)), elements=coordinate)
spatial = arrays(float, st.tuples(st.integers(0, 8), st.just(3)), elements=coordinate)
focal = st.floats(1e-3, 1e3)
pixel_size = st.tuples(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))

# A quarter turn about y: x -> -z, z -> x.
QUARTER = (0.0, math.pi / 2, 0.0)


def size(points):
    return np.abs(points).max(initial=0.0)


class TestPerspective:
    def test_by_hand(self):
        # u = 8 * 3 / 4 and v = 8 * 2 / 4; behind the camera the image is inverted.
        points = [[3.0, 2.0, 4.0], [3.0, 2.0, -4.0]]
        assert project(points, 8.0).tolist() == [[6.0, 4.0], [-6.0, -4.0]]

    def test_unit_focal_length_gives_the_regressors(self):
        assert project([[3.0, -2.0, 4.0]]).tolist() == [[0.75, -0.5]]

    @given(planar, st.data(), focal)
    def test_back_projection_is_the_inverse(self, image, data, focal_length):
        z = data.draw(arrays(float, len(image), elements=depth))
        points = back_project(image, z, focal_length)
        # A product and a quotient on the way there, the same on the way back.
        back = project(points, focal_length)
        np.testing.assert_allclose(back, image, rtol=4 * EPS, atol=1e-300)
        again = back_project(back, z, focal_length)
        np.testing.assert_allclose(again, points, rtol=8 * EPS, atol=1e-300)

    def test_one_depth_serves_all(self):
        points = back_project([[1.0, 2.0], [3.0, 4.0]], 6.0, 2.0)
        assert points.tolist() == [[3.0, 6.0, 6.0], [9.0, 12.0, 6.0]]

    @given(spatial.filter(len), st.floats(1e-3, 1e3))
    def test_points_of_a_ray_share_an_image(self, points, stretch):
        points[:, 2] = np.abs(points[:, 2]) + 1
        np.testing.assert_allclose(
            project(stretch * points), project(points), rtol=4 * EPS, atol=1e-300
        )

    def test_refuses_the_first_point_in_the_cameras_plane(self):
        points = [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]]
        with pytest.raises(InputError, match=r"^point 2: is in the camera's plane"):
            project(points)

    def test_refuses_points_behind_only_where_asked(self):
        points = [[1.0, 1.0, 1.0], [1.0, 1.0, -2.0]]
        assert project(points).shape == (2, 2)
        with pytest.raises(InputError, match=r"^point 2: is not in front .*z is -2"):
            project(points, in_front=True)
        with pytest.raises(InputError, match=r"^point 1: is in the camera's plane"):
            project([[1.0, 1.0, 0.0]], in_front=True)

    def test_refuses_an_image_that_overflows(self):
        with pytest.raises(InputError, match=r"^point 1: its image is above"):
            project([[1.0, 1.0, 1e-320]])

    @pytest.mark.parametrize("value", [0.0, math.nan, math.inf])
    def test_refuses_a_depth_that_is_none(self, value):
        with pytest.raises(InputError, match=r"^point 2: depth is"):
            back_project([[1.0, 1.0], [1.0, 1.0]], [1.0, value])

    def test_refuses_depths_of_another_number(self):
        with pytest.raises(InputError, match=r"depth must have shape \(2,\)"):
            back_project([[1.0, 1.0], [1.0, 1.0]], [1.0, 1.0, 1.0])

    @pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
    def test_refuses_a_focal_length_that_is_none(self, value):
        with pytest.raises(InputError, match="focal length must be a positive"):
            project([[1.0, 1.0, 1.0]], value)
        with pytest.raises(InputError, match="focal length must be a positive"):
            back_project([[1.0, 1.0]], 1.0, value)


class TestPixels:
    def test_by_hand(self):
        # 6 mm at 4 um per px is 1500 px, -4 mm at 8 um is -500 px.
        pixels = to_pixels([[6.0, -4.0]], (960.0, 540.0), (0.004, 0.008))
        np.testing.assert_allclose(pixels, [[2460.0, 40.0]], rtol=4 * EPS)
        image = from_pixels([[2460.0, 40.0]], (960.0, 540.0), (0.004, 0.008))
        np.testing.assert_allclose(image, [[6.0, -4.0]], rtol=4 * EPS)

    def test_the_principal_point_is_the_image_planes_origin(self):
        assert to_pixels([[0.0, 0.0]], (960.0, 540.0), (0.004, 0.008)).tolist() == [[960.0, 540.0]]

    @given(planar, arrays(float, 2, elements=coordinate), pixel_size)
    def test_round_trip(self, image, centre, sizes):
        back = from_pixels(to_pixels(image, centre, sizes), centre, sizes)
        # The sum with the centre rounds at the size of the larger of the two.
        lost = 4 * EPS * (size(image) + np.max(sizes) * size(centre))
        np.testing.assert_allclose(back, image, rtol=0, atol=lost)

    @pytest.mark.parametrize("sizes", [(0.0, 1.0), (1.0, -1.0), (1.0, math.nan), (1.0,)])
    def test_refuses_a_pixel_size_that_is_none(self, sizes):
        with pytest.raises(InputError, match="pixel size"):
            to_pixels([[1.0, 1.0]], (0.0, 0.0), sizes)
        with pytest.raises(InputError, match="pixel size"):
            from_pixels([[1.0, 1.0]], (0.0, 0.0), sizes)

    def test_refuses_an_image_that_overflows(self):
        with pytest.raises(InputError, match=r"^point 1: its image is above"):
            to_pixels([[1e99, 1.0]], (0.0, 0.0), (1e-300, 1.0))


class TestFrames:
    def test_by_hand(self):
        # R takes (1, 2, 3) to (3, 2, -1); T adds 5 to z.
        camera = world_to_camera([[1.0, 2.0, 3.0]], QUARTER, (0.0, 0.0, 5.0))
        np.testing.assert_allclose(camera, [[3.0, 2.0, 4.0]], rtol=8 * EPS)

    @given(spatial, rotation, vector)
    def test_round_trip(self, points, turn, translation):
        camera = world_to_camera(points, turn, translation)
        back = camera_to_world(camera, turn, translation)
        lost = 32 * EPS * (size(points) + size(translation))
        np.testing.assert_allclose(back, points, rtol=0, atol=lost)

    @given(rotation)
    def test_rotations_are_orthogonal_and_keep_the_hand(self, turn):
        matrix = rotation_matrix(turn)
        np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), rtol=0, atol=16 * EPS)
        assert np.linalg.det(matrix) == pytest.approx(1.0, abs=16 * EPS)

    @given(rotation)
    def test_rotation_is_rodrigues_formula(self, turn):
        angle = math.hypot(*turn)
        axis = turn / angle if angle > 0 else np.zeros(3)
        cross = np.cross(axis, np.eye(3)).T  # cross @ p is axis x p
        formula = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        np.testing.assert_allclose(rotation_matrix(turn), formula, rtol=0, atol=32 * EPS)

    def test_columns_of_the_rotation_are_the_worlds_axes(self):
        # Eq. 20 with T = 0 and p_w = (1, 0, 0), which the thesis calls the first row.
        x_axis = world_to_camera([[1.0, 0.0, 0.0]], QUARTER, (0.0, 0.0, 0.0))[0]
        matrix = rotation_matrix(QUARTER)
        np.testing.assert_allclose(x_axis, matrix[:, 0], rtol=0, atol=EPS)
        assert not np.allclose(x_axis, matrix[0])

    @given(rotation, vector)
    def test_the_worlds_origin_lands_on_the_translation(self, turn, translation):
        origin = world_to_camera(np.zeros((1, 3)), turn, translation)[0]  # eq. 26-27
        assert origin.tolist() == translation.tolist()

    @given(rotation, vector)
    def test_the_camera_centre_lands_on_the_origin(self, turn, translation):
        centre = camera_centre(turn, translation)
        camera = world_to_camera(centre[None], turn, translation)
        np.testing.assert_allclose(camera, np.zeros((1, 3)), atol=32 * EPS * size(translation))

    def test_without_rotation_the_camera_position_is_subtracted(self):
        position = np.array([330.0, 57.0, 0.0])
        camera = world_to_camera([[340.0, 60.0, 300.0]], (0.0, 0.0, 0.0), -position)
        assert camera.tolist() == [[10.0, 3.0, 300.0]]
        assert camera_centre((0.0, 0.0, 0.0), -position).tolist() == position.tolist()

    def test_equations_23_to_25_are_not_equation_20(self):
        points, translation = np.array([[1.0, 2.0, 3.0]]), np.array([1.0, 0.0, 5.0])
        camera = world_to_camera(points, QUARTER, translation)
        matrix = rotation_matrix(QUARTER)
        for rows in (matrix, matrix.T):
            assert np.abs((points + translation) @ rows.T - camera).max() > 1

    @pytest.mark.parametrize("convert", [world_to_camera, camera_to_world])
    def test_refuses_what_is_not_a_pose(self, convert):
        points = [[1.0, 2.0, 3.0]]
        with pytest.raises(InputError, match=r"rotation vector must have shape \(3,\)"):
            convert(points, np.eye(3), (0.0, 0.0, 0.0))
        with pytest.raises(InputError, match="rotation vector holds a number that is NaN"):
            convert(points, (0.0, math.nan, 0.0), (0.0, 0.0, 0.0))
        with pytest.raises(InputError, match=r"translation must have shape \(3,\)"):
            convert(points, QUARTER, (0.0, 0.0))


@pytest.mark.parametrize(
    ("function", "columns"),
    [
        (project, 3),
        (lambda p: back_project(p, 1.0), 2),
        (lambda p: to_pixels(p, (0.0, 0.0)), 2),
        (lambda p: from_pixels(p, (0.0, 0.0)), 2),
        (lambda p: world_to_camera(p, QUARTER, (0.0, 0.0, 0.0)), 3),
        (lambda p: camera_to_world(p, QUARTER, (0.0, 0.0, 0.0)), 3),
    ],
)
class TestEveryStep:
    def test_takes_no_points(self, function, columns):
        assert len(function(np.empty((0, columns)))) == 0

    @pytest.mark.parametrize("shape", [(5,), (2, 5), (2, 1), (2, 2, 2)])
    def test_refuses_another_shape(self, function, columns, shape):
        with pytest.raises(InputError, match=rf"must have shape \(n, {columns}\)"):
            function(np.ones(shape))

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e200])
    def test_refuses_a_number_that_is_none(self, function, columns, value):
        points = np.ones((3, columns))
        points[1, 0] = value
        with pytest.raises(InputError, match="point 2: holds a number that is NaN"):
            function(points)

    def test_leaves_its_points_alone(self, function, columns):
        points = np.full((2, columns), 2.0)
        points.setflags(write=False)
        function(points)
        assert (points == 2.0).all()
