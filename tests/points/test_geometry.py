"""Geometry that nobody would mean is named, with what mends it; ordinary cameras are silent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bayescal as bc
from bayescal.points.geometry import odd_geometry


def camera(world: np.ndarray, position=(0.0, 0.0, 0.0), **setup) -> bc.Correspondences:
    """Pixels of a pinhole that looks along z from `position`: f = 1000 px, centre (960, 540)."""
    seen = world - np.asarray(position)
    pixels = np.array([960.0, 540.0]) + 1000 * seen[:, :2] / seen[:, 2:]
    made = bc.Setup(width=1920, height=1080, **setup)
    return bc.Correspondences.from_arrays(world, pixels, setup=made)


def scene(n: int = 40) -> np.ndarray:
    """Points some 300 to 700 units before a camera at the origin."""
    rng = np.random.default_rng(3)
    return np.column_stack(
        [rng.uniform(-200, 200, n), rng.uniform(-100, 100, n), rng.uniform(300, 700, n)]
    )


@pytest.mark.parametrize("points", [bc.thesis(), camera(scene())], ids=["thesis", "scene"])
def test_ordinary_cameras_are_silent(points):
    assert odd_geometry(points) == []


def test_a_national_grid_without_a_camera_position_is_named():
    """Truth: the camera stands at the grid's coordinates, and nobody said so."""
    origin = np.array([682_000.0, 5_334_000.0, 500.0])
    points = camera(scene() + origin, origin)
    (text,) = odd_geometry(points)
    assert "every point lies 90 degrees or more off the camera's axis" in text
    assert "the camera's position is not stated" in text
    assert "--camera-position" in text
    stated = replace(points, setup=replace(points.setup, position=tuple(origin.tolist())))
    assert odd_geometry(stated) == []


def test_a_point_behind_the_camera_is_named_by_its_place():
    world = scene()
    world[7, 2] *= -1
    (text,) = odd_geometry(camera(world))
    assert text.startswith("1 point of 40 lies behind the camera")
    assert "point 8" in text
    everything = camera(scene() * [1, 1, -1])
    (text,) = odd_geometry(everything)
    assert "every point lies behind the camera" in text


def test_a_view_of_less_than_half_a_degree_is_named():
    """z in millimetres where x and y are in metres."""
    (text,) = odd_geometry(camera(scene() * [1, 1, 1000]))
    assert "degrees of view" in text
    assert "another unit" in text


@pytest.mark.parametrize("from_bottom", [False, True])
def test_c_turned_over_is_named(from_bottom):
    points = camera(scene())
    rows = points.pixels * [1, -1] + [0, 1080]  # c against y
    if from_bottom:
        rows[:, 1] = 1080 - rows[:, 1]
    turned = replace(points, pixels=rows, setup=replace(points.setup, c_from_bottom=from_bottom))
    (text,) = odd_geometry(turned)
    assert "c is turned over" in text
    assert ("c_from_bottom = false" if from_bottom else "--c-from-bottom") in text


def test_a_mirrored_world_is_named_and_a_camera_upside_down_is_not():
    """Negative control: a roll by 180 degrees turns r and c alike."""
    points = camera(scene())
    mirrored = replace(points, pixels=points.pixels * [-1, 1] + [1920, 0])
    assert "the world is mirrored" in odd_geometry(mirrored)[0]
    rolled = replace(points, pixels=[1920, 1080] - points.pixels)
    assert odd_geometry(rolled) == []
