"""The thesis's regression problems: regressors, pixels and what is refused."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import bayescal as bc
from bayescal.points.setup import Setup
from bayescal.polynomials.separable import axis_data


@pytest.mark.parametrize(("axis", "column", "offset"), [("r", 0, 330), ("c", 1, 57)])
def test_regressors_are_the_exact_quotients_rounded_once(axis, column, offset):
    """Truth in rational arithmetic: (x - 330) / z and (y - 57) / z of printed integers."""
    truth = [
        float(Fraction(int(w[column]) - offset, int(w[2]))) for w in bc.thesis().world.tolist()
    ]
    assert axis_data(bc.thesis(), axis).x.tolist() == truth


def test_pixels_are_r_and_height_less_the_row():
    points = bc.thesis()
    assert np.array_equal(axis_data(points, "r").t, points.pixels[:, 0])
    assert np.array_equal(axis_data(points, "c").t, 1080 - points.pixels[:, 1])


def test_image_size_is_the_setups_or_else_the_span_of_the_pixels():
    """By hand; pixels that are all the same have no span, and 1 stands for it."""
    world = [[0.0, 0, 1], [1, 1, 1], [2, 2, 1]]
    pixels = [[10.0, 5], [20, 5], [40, 5]]
    unknown = bc.Correspondences.from_arrays(world, pixels)
    known = bc.Correspondences.from_arrays(world, pixels, setup=Setup(width=100.0))
    assert (axis_data(unknown, "r").size, axis_data(unknown, "r").size_known) == (30, False)
    assert (axis_data(unknown, "c").size, axis_data(known, "r").size) == (1, 100)
    assert axis_data(known, "r").size_known


def test_a_point_in_the_cameras_plane_is_refused_by_name():
    points = bc.Correspondences.from_arrays(
        [[0.0, 0, 1], [1, 1, 0]], [[1.0, 1], [2, 2]], labels=("far", "near")
    )
    with pytest.raises(bc.InputError, match="near"):
        axis_data(points, "r")


def test_pixels_an_image_size_outside_the_image_are_refused_by_name():
    points = bc.Correspondences.from_arrays(
        [[0.0, 0, 1], [1, 1, 1]], [[1.0, 1], [301, 2]], setup=Setup(width=100.0)
    )
    with pytest.raises(bc.InputError, match="point 2"):
        axis_data(points, "r")


def test_orders_beyond_the_points_are_refused_with_the_highest_that_works():
    data = axis_data(bc.thesis(), "r")
    distinct = len({Fraction(int(w[0]) - 330, int(w[2])) for w in bc.thesis().world})
    data.check(distinct - 1)
    with pytest.raises(bc.InputError, match=f"the highest order that works is {distinct - 1}"):
        data.check(distinct)
