"""Poses and cameras: against scipy's rotations, OpenCV and central differences."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bayescal.cameras import pose
from bayescal.cameras.camera import Camera, to_camera
from bayescal.cameras.lenses import lens_named

VECTORS = np.array(
    [[0, 0, 0], [1e-9, 0, 0], [0.02, -0.03, 0.05], [0.6, -0.8, 0.3], [2.0, 2.0, -1.0], [0, 3.1, 0]]
)
K = np.array([-0.28, 0.12, 8e-4, -5e-4, -0.02])
INTRINSICS = np.array([1400.0, 1350.0, 955.0, 540.0])
ROTATION, TRANSLATION = np.array([0.3, -0.2, 0.1]), np.array([-80.0, -60.0, 900.0])
WORLD = np.column_stack([*np.random.default_rng(0).uniform(0, 200, (2, 50)), np.zeros(50)])


def test_rotations_are_scipys_and_back():
    matrices = pose.rotations(VECTORS.reshape(2, 3, 3))
    truth = Rotation.from_rotvec(VECTORS).as_matrix().reshape(2, 3, 3, 3)
    np.testing.assert_allclose(matrices, truth, atol=1e-14)
    np.testing.assert_allclose(pose.rotation_vectors(matrices).reshape(-1, 3), VECTORS, atol=1e-12)


@pytest.mark.parametrize("vector", VECTORS)
def test_left_jacobian_is_what_a_small_change_of_the_vector_turns(vector):
    h = 1e-6
    for j in range(3):
        up, down = (pose.rotations(vector + s * h * np.eye(3)[j]) for s in (1, -1))
        turn = pose.rotation_vectors(up @ down.T) / (2 * h)
        np.testing.assert_allclose(turn, pose.left_jacobian(vector)[:, j], atol=1e-9)


def test_left_jacobian_does_not_jump_where_its_series_ends():
    axis = np.array([0.6, 0.0, 0.8])
    below, above = (pose.left_jacobian(axis * (0.1 + s * 1e-12)) for s in (-1, 1))
    np.testing.assert_allclose(below, above, atol=1e-12)


def test_pixels_are_opencvs():
    matrix = np.array([[1400.0, 0, 955], [0, 1350, 540], [0, 0, 1]])
    truth, slopes = cv2.projectPoints(WORLD, ROTATION, TRANSLATION, matrix, K)
    camera = Camera(lens_named("opencv5"))
    found = camera.project_with_jacobian(INTRINSICS, K, ROTATION, TRANSLATION, WORLD)
    np.testing.assert_allclose(found.pixels, truth[:, 0], rtol=0, atol=1e-9)
    pixels, seen = camera.project(INTRINSICS, K, ROTATION, TRANSLATION, WORLD)
    np.testing.assert_allclose(pixels, found.pixels, rtol=0, atol=1e-10)
    assert seen.all()
    # OpenCV's columns: rotation vector, translation, fx, fy, cx, cy, coefficients.
    slopes = slopes.reshape(len(WORLD), 2, -1)
    by_vector = found.by_pose[..., :3] @ pose.left_jacobian(ROTATION)
    np.testing.assert_allclose(by_vector, slopes[..., :3], rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(found.by_pose[..., 3:], slopes[..., 3:6], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.by_intrinsics, slopes[..., 6:10], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.by_coefficients, slopes[..., 10:], rtol=1e-9, atol=1e-9)


def turned(step):
    """Rotation vector of a small turn after the first rotation."""
    matrix = pose.rotations(step) @ pose.rotations(ROTATION)
    return pose.rotation_vectors(matrix)


def test_derivatives_by_pose_are_those_of_a_left_perturbation():
    camera = Camera(lens_named("opencv5"))
    found = camera.project_with_jacobian(INTRINSICS, K, ROTATION, TRANSLATION, WORLD)
    for j in range(3):
        h = 1e-6 * np.eye(3)[j]
        ends = [
            camera.project(INTRINSICS, K, turned(s * h), TRANSLATION, WORLD)[0] for s in (1, -1)
        ]
        # Rounding of pixels of 1e3 over the step.
        np.testing.assert_allclose(found.by_pose[..., j], (ends[0] - ends[1]) / 2e-6, atol=1e-5)
        h = 1e-3 * np.eye(3)[j]
        ends = [
            camera.project(INTRINSICS, K, ROTATION, TRANSLATION, WORLD + s * h)[0] for s in (1, -1)
        ]
        np.testing.assert_allclose(found.by_world[..., j], (ends[0] - ends[1]) / 2e-3, atol=1e-7)


def test_many_views_at_once_are_those_one_by_one():
    camera, rng = Camera(lens_named("opencv5")), np.random.default_rng(2)
    intrinsics = INTRINSICS + rng.normal(0, 5, (4, 1, 4))  # 4 draws of 3 views
    k = K * rng.uniform(0.9, 1.1, (4, 1, 5))
    rotation = ROTATION + rng.normal(0, 0.1, (4, 3, 3))
    translation = TRANSLATION + rng.normal(0, 10, (4, 3, 3))
    together = camera.project_with_jacobian(intrinsics, k, rotation, translation, WORLD)
    for i, j in np.ndindex(4, 3):
        one = camera.project_with_jacobian(
            intrinsics[i, 0], k[i, 0], rotation[i, j], translation[i, j], WORLD
        )
        for part in vars(one):
            np.testing.assert_allclose(
                getattr(together, part)[i, j], getattr(one, part), rtol=1e-10, atol=1e-10
            )


def test_rays_at_pixels_lead_back_to_the_points():
    camera = Camera(lens_named("opencv5"))
    pixels, _ = camera.project(INTRINSICS, K, ROTATION, TRANSLATION, WORLD)
    rays = camera.rays(INTRINSICS, K, pixels)
    assert rays.found.all()
    points = to_camera(ROTATION, TRANSLATION, WORLD)
    reached = rays.rays * np.linalg.norm(points, axis=1, keepdims=True)
    np.testing.assert_allclose(reached, points, atol=1e-9)
