"""Undistorted pixels, tables and fields of view, against OpenCV and by their own definition."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.undistortion import (
    IdealCamera,
    RealCamera,
    distort_pixels,
    ideal_camera,
    table,
    undistort_pixels,
)
from bayescal.errors import InputError

INTRINSICS = np.array([700.0, 690.0, 318.0, 242.0])
MATRIX = np.array([[700.0, 0, 318], [0, 690, 242], [0, 0, 1]])
WIDTH, HEIGHT = 640, 480
BARREL = [-0.28, 0.12, 8e-4, -5e-4, -0.02]
RATIONAL = [8.0, 3.0, 8e-4, -5e-4, 0.2, 8.4, 5.5, 1.0]


def real(name, k, intrinsics=INTRINSICS, **options):
    lens = lens_named(name, **options)
    return RealCamera(Camera(lens), np.array(intrinsics), np.array(k), WIDTH, HEIGHT)


KINDS = [("opencv5", BARREL), ("opencv8", RATIONAL)]
FISH = real("fisheye", [-0.02, 0.003, -0.0015, 0.0002], [300.0, 300.0, 318.0, 242.0], order=4)
planar = pytest.mark.parametrize(("name", "k"), KINDS, ids=[name for name, _ in KINDS])


def grid(step=40):
    rows, columns = np.mgrid[0:HEIGHT:step, 0:WIDTH:step]
    return np.column_stack([columns.ravel(), rows.ravel()]).astype(float)


@planar
def test_pixels_are_opencvs(name, k):
    camera = real(name, k)
    found, exists = undistort_pixels(camera, ideal_camera(camera), grid())
    # OpenCV iterates until its pixels are near enough, to rounding here (4.x: another name).
    solve = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 500, 1e-14)
    truth = solve(grid()[:, None], MATRIX, np.array(k), R=np.eye(3), P=MATRIX, criteria=stop)
    assert exists.all()
    np.testing.assert_allclose(found, truth[:, 0], rtol=0, atol=1e-9)


def test_pixels_of_a_fisheye_are_opencvs():
    matrix = np.array([[300.0, 0, 318], [0, 300, 242], [0, 0, 1]])
    found, exists = undistort_pixels(FISH, ideal_camera(FISH), grid())
    truth = cv2.fisheye.undistortPoints(
        grid()[:, None], matrix, FISH.k, R=np.eye(3), P=matrix,
        criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-15),
    )  # fmt: skip
    assert exists.all()
    np.testing.assert_allclose(found, truth[:, 0], rtol=1e-12, atol=1e-9)


@planar
@pytest.mark.parametrize("field", ["same", "inside", "full"])
def test_tables_are_opencvs(name, k, field):
    camera = real(name, k)
    ideal = ideal_camera(camera, field)
    made = table(camera, ideal)
    fx, fy, cx, cy = ideal.intrinsics
    new = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    r, c = cv2.initUndistortRectifyMap(
        MATRIX, np.array(k), np.eye(3), new, (WIDTH, HEIGHT), cv2.CV_32FC1
    )
    assert made.seen.all()
    # Both are single precision, of numbers up to 1024: 6e-5 is their last digit.
    np.testing.assert_allclose(made.r, r, rtol=0, atol=1.3e-4)
    np.testing.assert_allclose(made.c, c, rtol=0, atol=1.3e-4)


def test_a_table_says_what_each_pixel_says():
    """In double precision: each pixel of the ideal camera against its projection."""
    ideal = ideal_camera(FISH, 150.0)
    made = table(FISH, ideal)
    at, seen = distort_pixels(FISH, ideal, grid())
    rows, columns = grid()[:, 1].astype(int), grid()[:, 0].astype(int)
    np.testing.assert_array_equal(made.r[rows, columns], at[:, 0].astype(np.float32))
    np.testing.assert_array_equal(made.c[rows, columns], at[:, 1].astype(np.float32))
    np.testing.assert_array_equal(made.seen[rows, columns], seen)


@pytest.mark.parametrize(
    "camera", [*(real(name, k) for name, k in KINDS), FISH], ids=["opencv5", "opencv8", "fisheye"]
)
@pytest.mark.parametrize("field", ["same", "inside", 40.0])
def test_there_and_back(camera, field):
    ideal = ideal_camera(camera, field)
    found, exists = undistort_pixels(camera, ideal, grid())
    back, seen = distort_pixels(camera, ideal, found)
    assert exists.all()
    assert seen.all()
    np.testing.assert_allclose(back, grid(), rtol=0, atol=1e-9)


def edge_of(width, height):
    r, c = np.arange(width), np.arange(height)
    sides = [(r, 0 * r), (r, 0 * r + height - 1), (0 * c, c), (0 * c + width - 1, c)]
    return np.concatenate([np.column_stack(side) for side in sides]).astype(float)


@planar
def test_inside_leaves_no_pixel_without_an_image_and_full_loses_none(name, k):
    camera, edge = real(name, k), edge_of(WIDTH, HEIGHT)
    limits = np.array([WIDTH - 1, HEIGHT - 1])
    ideal = ideal_camera(camera, "inside")
    at, _ = distort_pixels(camera, ideal, edge)
    gaps = np.concatenate([at.min(axis=0), (limits - at).min(axis=0)])
    # Between the centres of two pixels of an edge it may bend out by a hundredth of a pixel.
    assert gaps.min() == pytest.approx(0, abs=0.01)
    assert ideal.intrinsics[0] / ideal.intrinsics[1] == pytest.approx(700 / 690)  # pixels' shape
    ideal = ideal_camera(camera, "full")
    at, _ = undistort_pixels(camera, ideal, edge)
    gaps = np.concatenate([at.min(axis=0), (limits - at).min(axis=0)])
    assert gaps.min() == pytest.approx(0, abs=1e-9)
    assert ideal.intrinsics[0] / ideal.intrinsics[1] == pytest.approx(700 / 690)


def test_a_field_in_degrees_is_what_the_ideal_camera_sees_from_left_to_right():
    ideal = ideal_camera(FISH, 120.0)
    left, right = ideal.rays(np.array([[0.0, 239.5], [WIDTH - 1.0, 239.5]]))
    cosine = left @ right / np.linalg.norm(left) / np.linalg.norm(right)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(120, abs=1e-9)
    np.testing.assert_allclose(ideal.rays(np.array([[319.5, 239.5]])), [[0, 0, 1]], atol=1e-15)


def test_no_pinhole_sees_ninety_degrees_aside():
    wide = real("fisheye", [-0.02, 0.003, -0.0015, 0.0002], [180.0, 180, 318, 242], order=4)
    for field in ("inside", "full"):
        with pytest.raises(
            InputError, match=r"90 degrees or more aside.* state a field in degrees"
        ):
            ideal_camera(wide, field)
    for field in (0.0, 180.0, float("nan")):
        with pytest.raises(InputError, match="use more than 0 and up to 175"):
            ideal_camera(wide, field)
    found, exists = undistort_pixels(wide, ideal_camera(wide, 120.0), np.array([[0.0, 242.0]]))
    assert not exists.any()
    assert np.isnan(found).all()


def test_beyond_the_fold_nothing_is_taken_from_the_photograph():
    """w (1 - w^2/3) turns back at 45 degrees: OpenCV's map comes back inside, this one says no."""
    camera = real("radial", [-1 / 3], [300.0, 300, 320, 240], order=1, tangential=False)
    ideal = IdealCamera(np.array([100.0, 100.0, 319.5, 239.5]), WIDTH, HEIGHT)
    made = table(camera, ideal)
    radius = np.hypot(*(np.indices((HEIGHT, WIDTH)) - [[[239.5]], [[319.5]]]))
    np.testing.assert_array_equal(made.seen, radius < 100)
    assert (made.r[~made.seen] == -1e6).all()
    assert (made.c[~made.seen] == -1e6).all()
