"""Undistortion by calibrated cameras against OpenCV, straight lines, and its own inverse."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import bayescal as bc
from bayescal.errors import InputError
from bayescal.prediction.calibrated.lens_member import LensMember
from tests.helpers.cameras import turned_points
from tests.helpers.cases import camera_points

BENT = (960.0, 700.0, 40.0)


@pytest.fixture(scope="module")
def cameras(lens_comparison) -> dict[str, bc.CalibratedCamera]:
    points = camera_points(60, BENT, noise=0.1)
    flipped = turned_points(0.3)
    return {
        "lens": bc.camera(lens_comparison),
        "separable": bc.camera(bc.fit(points, 2, 1, ess=100)),
        "bivariate": bc.camera(bc.fit_family(points, "bivariate", (2,))),
        "pinhole": bc.camera(bc.fit_family(flipped, "pinhole", (1,), ess=100)),
        "thesis": bc.camera(bc.fit(bc.thesis(), 4, 1, ess=100)),
    }


def test_a_lens_is_undistorted_as_opencv_does(cameras):
    """Truth: cv2.undistortPoints by the mean lens; 1e-9 px."""
    camera = cameras["lens"]
    member = camera.chosen
    assert isinstance(member, LensMember)
    (fx, fy, cx, cy), (k1,) = (v[0] for v in member.intrinsics(member.parameters.mean[None]))
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    pixels = np.random.default_rng(0).uniform([60, 60], [580, 420], (40, 2))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 500, 1e-14)
    solve = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)
    truth = solve(
        pixels[:, None], matrix, np.array([k1, 0, 0, 0, 0.0]), R=np.eye(3), P=matrix, criteria=stop
    )
    np.testing.assert_allclose(bc.undistort(camera, pixels), truth[:, 0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["lens", "separable", "bivariate", "pinhole", "thesis"])
def test_distorting_what_was_undistorted_gives_it_back(cameras, name):
    """Truth: the pixels begun with; 1e-9 px of 1000."""
    camera = cameras[name]
    found = bc.undistortion(camera)
    middle = camera.pixel_hull.mean(axis=0)
    pixels = middle + 0.7 * (camera.pixel_hull - middle)
    np.testing.assert_allclose(found.distorted(found.pixels(pixels)), pixels, rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", ["separable", "bivariate", "pinhole", "thesis"])
def test_lines_of_the_world_come_out_straight(cameras, name):
    """Truth: a line of the world, seen by the camera itself; a pinhole sees a straight one."""
    camera = cameras[name]
    if name == "pinhole":
        world = np.linspace([60.0, 70.0, 80.0], [150.0, 160.0, 80.0], 9)
    else:
        position = np.array(bc.thesis().setup.position if name == "thesis" else [0, 0, 0])
        world = position + np.linspace([-40.0, -20.0, 200.0], [50.0, 15.0, 220.0], 9)
    pixels = bc.predict(camera, world, average=False).mean
    found = bc.undistort(camera, pixels)

    def bend(points):
        values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        return values[1]

    # Averages over draws differ from the mean's prediction in second order alone.
    assert bend(found) < (1e-3 if name == "pinhole" else 1e-8)
    assert bend(found) < bend(pixels)


def test_a_polynomial_keeps_what_lies_straight_ahead(cameras):
    """Truth: pixel and slopes at x/z = y/z = 0 by differences of predictions."""
    camera, h = cameras["separable"], 1e-4
    at = np.array([[0.0, 0, 1], [h, 0, 1], [-h, 0, 1], [0, h, 1], [0, -h, 1]]) * 100
    pixels = bc.predict(camera, at, average=False).mean
    fx, fy, cx, cy = bc.undistortion(camera).ideal.intrinsics
    np.testing.assert_allclose([cx, cy], pixels[0], atol=1e-9)
    slopes = np.abs([pixels[1, 0] - pixels[2, 0], pixels[3, 1] - pixels[4, 1]]) / (2 * h)
    np.testing.assert_allclose([fx, fy], slopes, rtol=1e-6)


def test_an_image_is_sampled_by_the_table_made_once(cameras):
    """Truth: a ramp of grey, whose value is where the photograph is looked at."""
    found = bc.undistortion(cameras["lens"])
    ramp = np.tile(np.arange(640, dtype=np.float32), (480, 1))
    out = found.image(ramp)
    assert found.table is found.table
    inner = np.s_[100:380, 100:540]
    np.testing.assert_allclose(out[inner], found.table.r[inner], atol=0.05)
    with pytest.raises(InputError, match="of 20 by 10 px, the camera of 640 by 480"):
        found.image(np.zeros((10, 20)))


def test_data_frames_and_what_has_no_ideal_camera(cameras):
    pandas = pytest.importorskip("pandas")
    pixels = np.array([[700.0, 500.0], [1000.0, 600.0]])
    frame = pandas.DataFrame(pixels, columns=["r", "c"])
    found = bc.undistort(cameras["separable"], frame)
    np.testing.assert_array_equal(
        found[["undistorted_r", "undistorted_c"]], bc.undistort(cameras["separable"], pixels)
    )
    aside = camera_points(40, noise=0.1)
    moved = bc.Correspondences.from_arrays(
        aside.world + np.array([500.0, 0, 0]), aside.pixels, setup=aside.setup
    )
    camera = bc.camera(bc.fit(moved, 1, 1, ess=100))
    with pytest.raises(InputError, match="straight ahead"):
        bc.undistort(camera, pixels)
    assert np.isfinite(bc.undistort(camera, pixels, field=120.0)).all()
