"""Views whose points are named wrongly are named, and refused where nothing can come of them."""

import dataclasses

import numpy as np
import pytest

import bayescal as bc
from bayescal.errors import InputError
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views
from scripts.validation.simulated_boards import Errors, Truth, views_of


def board_views(spoil) -> Views:
    """Eight views, of which the fourth is spoilt."""
    rng = np.random.default_rng(0)
    views, _ = views_of(Truth((-60.0,), None), Errors(0.2), 8, rng)
    pixels = views.pixels.copy()
    part = views.slices[3]
    pixels[part] = spoil(pixels[part], rng)
    return dataclasses.replace(views, pixels=pixels)


def test_points_in_another_order_are_refused_by_the_view():
    views = board_views(lambda pixels, rng: rng.permutation(pixels))
    with pytest.raises(
        InputError, match=f"view {views.names[3]} looks like no picture .*--without"
    ):
        bc.calibrate(views)


def test_columns_counted_along_rows_are_refused_too():
    views = board_views(lambda pixels, _: pixels.reshape(6, 9, 2).swapaxes(0, 1).reshape(-1, 2))
    with pytest.raises(InputError, match="are its points in another order"):
        bc.calibrate(views)


def test_a_mirrored_view_is_said_and_calibrated():
    views = board_views(lambda pixels, _: pixels * [-1, 1] + [1279, 0])
    (note,) = [n for n in view_notes(views) if "mirrored" in n]
    assert f"view {views.names[3]} shows the target mirrored" in note
    found = bc.calibrate(views, lenses=["radial 1"])
    assert note in found.notes


def test_all_views_mirrored_are_as_good_as_none():
    rng = np.random.default_rng(0)
    views, _ = views_of(Truth((-60.0,), None), Errors(0.2), 8, rng)
    assert not [n for n in view_notes(views) if "mirrored" in n]
