"""The bundled corners are those of OpenCV's photographs.

Truth: OpenCV's own tutorial calibrates a camera from the same photographs, to focal lengths of
534.1 px and a principal point of (341.5, 232.9); another detector of corners moves them by one or
two pixels. OpenCV's least squares on our corners is the independent tool.
"""

from __future__ import annotations

import cv2
import numpy as np

import bayescal as bc
from bayescal.points.views.notes import view_notes


def test_thirteen_views_of_one_board() -> None:
    views = bc.chessboard()
    assert len(views) == 13
    np.testing.assert_array_equal(views.counts, 54)
    np.testing.assert_array_equal(views.extent, [200, 125, 0])
    assert (views.width, views.height, len(views.target)) == (640, 480, 54)
    assert views.planar
    assert view_notes(views) == []


def test_opencv_calibrates_the_camera_of_its_tutorial() -> None:
    views = bc.chessboard()
    rms, matrix, k, *_ = cv2.calibrateCamera(
        [views.world[part].astype(np.float32) for part in views.slices],
        [views.pixels[part].astype(np.float32).reshape(-1, 1, 2) for part in views.slices],
        (640, 480),
        None,
        None,
    )
    assert rms < 0.2  # the tutorial's corners give 0.2 and more
    np.testing.assert_allclose([matrix[0, 0], matrix[1, 1]], 534.1, atol=2)
    np.testing.assert_allclose([matrix[0, 2], matrix[1, 2]], [341.5, 232.9], atol=2)
    assert -0.3 < k.ravel()[0] < -0.25
