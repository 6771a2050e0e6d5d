"""Differences and uncertainties of predictions once the poses' share is taken out."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.calibration.lens_model import LensModel
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotations
from bayescal.comparison.lenses.prediction import (
    View,
    covered,
    deviation,
    difference,
    image_grid,
    observed_sample,
    response,
)
from tests.helpers import boards

WORLD, PIXELS = boards.pictures(np.random.default_rng(1), n_views=4)
DATA = boards.observed(WORLD, PIXELS)
GRID = image_grid(boards.SIZE, 9, 7)


def view(k: tuple[float, ...] = (-0.28, 0.07), centre: tuple[float, float] = boards.CENTRE) -> View:
    model = boards.radial(len(k))
    intrinsics = np.array([*boards.FOCAL, *centre])
    return View(model, model.coordinates(intrinsics, np.array(k)))


def test_a_lens_agrees_with_itself() -> None:
    assert np.abs(difference(view(), view(), GRID, observed_sample(DATA), None)).max() < 1e-9


def test_a_turn_is_no_difference() -> None:
    """Truth: a fisheye without distortion whose rays are turned predicts the same."""
    lens = LensModel("f", lens_named("fisheye", order=0), boards.SIZE, square=True, centred=True)
    one = View(lens, lens.coordinates(np.array([300.0, 300, *lens.middle]), np.zeros(0)))
    sample = observed_sample(DATA)
    rays, _ = one.rays(GRID)
    turned = one.pixels(rays @ rotations(np.array([0.05, -0.03, 0.1])).T)
    assert np.abs(turned - GRID).max() > 10  # without taking the turn out they differ
    # The principal point acts nearly as a turn: what is left is far smaller.
    moved = LensModel("f", lens.lens, boards.SIZE, square=True)
    other = View(moved, moved.coordinates(np.array([300.0, 300, 330.0, 240.0]), np.zeros(0)))
    base = View(moved, moved.coordinates(np.array([300.0, 300, 329.0, 240.0]), np.zeros(0)))
    apart = difference(base, other, GRID, sample, None)
    assert np.abs(apart).max() < 0.5


@pytest.mark.parametrize("depth", [None, 2.0])
def test_small_differences_are_linear(depth: float | None) -> None:
    """Truth: the difference of two lenses near each other, fitted, not linearised."""
    one = view()
    sample = observed_sample(DATA)
    step = np.array([1e-4, -1e-4, 0.05, -0.08, 0.2, 0.1])
    other = View(one.model, one.x + step)
    exact = difference(one, other, GRID, sample, depth)
    linear = response(one, GRID, sample, depth) @ step
    np.testing.assert_allclose(linear, exact, atol=0.02 * np.abs(exact).max())


def test_deviation_is_that_of_draws() -> None:
    """Truth: the root mean square of many linear differences; Monte Carlo error of 4000 draws."""
    one, rng = view(), np.random.default_rng(2)
    root = np.diag([1e-4, 1e-4, 0.1, 0.1, 0.3, 0.3])
    maps = response(one, GRID, observed_sample(DATA), None)
    moved = np.einsum("nai,si->sna", maps, rng.standard_normal((4000, 6)) @ root)
    drawn = np.sqrt((moved**2).mean(axis=(0, 2)))
    np.testing.assert_allclose(deviation(maps, root @ root.T), drawn, rtol=0.06)


def test_points_cover_their_hull() -> None:
    pixels = DATA.pixels[DATA.seen]
    assert covered(pixels.mean(axis=0)[None], DATA).all()
    assert not covered(np.array([[0.0, 0.0]]), DATA).any()
