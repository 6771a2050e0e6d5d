"""Differences and uncertainties of predictions once the poses' share is taken out."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.calibration.model.lens_model import LensModel
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotations
from bayescal.comparison.lenses.prediction import (
    View,
    at_most,
    covered,
    deviation,
    difference,
    distances_drawn,
    image_grid,
    largest,
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


def followed(one: View, other: View, sample: np.ndarray) -> View:
    """Fit the other lens to what the one predicts, by Gauss-Newton."""
    for _ in range(6):
        gap = difference(one, other, sample, sample, None)
        maps = response(other, sample, sample, None).reshape(gap.size, -1)
        other = View(other.model, other.x - np.linalg.lstsq(maps, gap.ravel())[0])
    return other


def test_draws_of_a_difference_are_those_of_lenses_fitted_to_each_other() -> None:
    """Truth: the smaller lens fitted, not linearised, to each draw of the larger."""
    one, sample = view((-0.1, 0.005)), observed_sample(DATA)
    other = followed(one, view((-0.1,)), sample)
    sd = np.array([3e-4, 3e-4, 0.2, 0.2, 0.2, 0.2])
    found = distances_drawn(one, other, np.diag(sd**2), GRID, sample, np.random.default_rng(3))
    steps = sd * np.random.default_rng(3).standard_normal((len(found), len(sd)))
    for step, sizes in zip(steps[:4], found, strict=False):
        moved = View(one.model, one.x + step)
        truth = np.hypot(*difference(moved, followed(moved, other, sample), GRID, sample, None).T)
        np.testing.assert_allclose(sizes, truth, atol=0.02 * truth.max())
    fitted = largest(difference(one, other, GRID, sample, None))
    assert at_most(found) > 1.02 * fitted  # negative control: the fits alone say too little


def test_a_lens_that_contains_another_follows_it_wherever_it_goes() -> None:
    one, sample = view((-0.1,)), observed_sample(DATA)
    sd = np.array([1e-3, 1e-3, 0.5, 0.5, 0.5])
    apart = distances_drawn(
        one, view((-0.1, 0.0)), np.diag(sd**2), GRID, sample, np.random.default_rng(3)
    )
    assert apart.max() < 1e-3
