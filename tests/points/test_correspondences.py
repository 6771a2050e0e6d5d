"""Correspondences from arrays, and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bayescal as bc

WORLD = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
PIXELS = [[10.0, 20.0], [30.0, 40.0]]


def test_c_is_counted_from_the_bottom_where_the_setup_says_so() -> None:
    for flipped, expected in ((False, [20, 40]), (True, [80, 60])):
        setup = bc.Setup(height=100, c_from_bottom=flipped)
        points = bc.Correspondences.from_arrays(WORLD, PIXELS, setup=setup)
        np.testing.assert_array_equal(points.pixel("c"), expected)
        np.testing.assert_array_equal(points.pixel("r"), [10, 30])


def test_camera_position_is_subtracted() -> None:
    setup = bc.Setup(position=(1, -2, 0.5))
    points = bc.Correspondences.from_arrays(WORLD, PIXELS, setup=setup)
    np.testing.assert_array_equal(points.camera_frame(), [[0, 4, 2.5], [3, 7, 5.5]])


def test_the_callers_arrays_are_copied() -> None:
    world = np.array(WORLD)
    points = bc.Correspondences.from_arrays(world, PIXELS)
    world[0, 0] = 99
    assert points.world[0, 0] == 1


def test_points_without_a_file_are_named_by_their_label() -> None:
    points = bc.Correspondences.from_arrays(WORLD, PIXELS, labels=("left\n corner", ""))
    assert points.labels == ("left corner", "2")
    assert points.place(0).endswith("point left corner")


def test_hash_tells_points_apart() -> None:
    def digest(**more: Any) -> str:
        return bc.Correspondences.from_arrays(**{"world": WORLD, "pixels": PIXELS, **more}).sha256

    hashes = [digest(), digest(sigma_r=[1, 2]), digest(world=[[1, 2, 3], [4, 5, 7]])]
    assert digest() == hashes[0]
    assert len(set(hashes)) == 3


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"world": [["one", 2, 3]]}, "world must be an array of numbers"),
        ({"sigma_r": ["a", "b"]}, "sigma_r must be an array of numbers"),
        ({"world": [[1, 2], [3, 4]]}, r"world must have shape \(n_points, 3\)"),
        ({"world": np.zeros((0, 3)), "pixels": np.zeros((0, 2))}, "there are no points"),
        ({"pixels": [[1, 2]]}, r"pixels must have shape \(2, 2\)"),
        ({"world": [[1, 2, np.nan], [4, 5, 6]]}, "world holds a number that is NaN"),
        ({"world": [[1, 2, 1e100], [4, 5, 6]]}, "world holds a number"),
        ({"pixels": [[1, 2], [np.inf, 4]]}, "pixels holds a number"),
        ({"pixels": [[1, 2], [3, -1e9]]}, "pixels holds a number"),
        ({"labels": ("a",)}, "labels: 1 given for 2 points"),
        ({"groups": ("a", "b", "c")}, "groups: 3 given for 2 points"),
        ({"sigma_r": [1.0]}, "r: 1 given for 2 points"),
        ({"sigma_r": [1.0, 0.0]}, "sigma_r must be from"),
        ({"sigma_c": [1.0, -1.0]}, "sigma_c must be from"),
        ({"sigma_c": [1.0, np.nan]}, "sigma_c must be from"),
        ({"sigma_c": [1.0, 1e-300]}, "sigma_c must be from"),
    ],
)
def test_arrays_that_can_not_be_used(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(bc.InputError, match=complaint):
        bc.Correspondences.from_arrays(**{"world": WORLD, "pixels": PIXELS, **changes})


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"position": (0, 0, np.nan)}, "camera position"),
        ({"position": (0, 1e100, 0)}, "camera position"),
        ({"width": 0}, "image width must be from 1"),
        ({"height": -1080}, "image height must be from 1"),
        ({"height": 1e-300}, "image height must be from 1"),
        ({"width": float("inf")}, "image width must be from 1"),
        ({"c_from_bottom": True}, "needs the image height"),
    ],
)
def test_setups_that_can_not_be_used(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(bc.InputError, match=complaint):
        bc.Setup(**changes)


def test_pixels_are_taken_as_opencv_has_them() -> None:
    plain = np.arange(6.0).reshape(3, 2)
    found = bc.Correspondences.from_arrays(np.ones((3, 3)), plain[:, None])
    np.testing.assert_array_equal(found.pixels, plain)
