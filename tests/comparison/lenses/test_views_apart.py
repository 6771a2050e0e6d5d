"""Views that are noisier than others, and views that say too little."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.arrays import Array
from bayescal.calibration.fitting.view_levels import view_levels
from bayescal.calibration.model.observations import Observations
from bayescal.points.views.views import Views
from tests.helpers import boards

TARGET = boards.board(6, 5)


def views_with(levels: list[float], seed: int = 0, sigma: float = 0.1) -> Views:
    """Views whose noise is `sigma` times a level of their own."""
    rng = np.random.default_rng(seed)
    world, pixels = boards.pictures(rng, len(levels), sigma=0.0, target=TARGET)
    noise = sigma * np.array(levels)[:, None, None] * rng.standard_normal(pixels.shape)
    width, height = boards.SIZE
    return Views.from_arrays(
        [world] * len(levels), list(pixels + noise), width=width, height=height
    )


def test_levels_of_views_are_those_they_were_made_with() -> None:
    """Truth: the simulation; of 54 degrees of freedom a level is known to a tenth."""
    truth = [1.0, 1.0, 5.0, 1.0, 1.0, 0.3, 1.0, 1.0]
    data = Observations.from_views(views_with(truth), boards.SIZE)
    found = view_levels(data, [boards.radial(2), boards.radial(0)])
    np.testing.assert_allclose(found / np.array(truth), 1, atol=0.35)


def test_a_loud_view_weighs_less_where_views_have_levels() -> None:
    """Truth: the lens that made the views; with one sigma the loud view makes all deviations."""
    views = views_with([1.0] * 7 + [20.0])
    options = {"lenses": ["radial 2"], "independent": True, "ess": 100}
    one, own = (bc.calibrate(views, sigma=s, **options) for s in ("inferred", "per-view"))
    assert own.posterior["fx"].sd < one.posterior["fx"].sd / 3
    assert abs(own.posterior["fx"].mean - boards.FOCAL[0]) < 4 * own.posterior["fx"].sd
    assert own.posterior["sigma"].mean == pytest.approx(0.1, rel=0.15)
    assert any("far larger than usual" in caveat for caveat in one.verdict.caveats)
    assert not any("far larger than usual" in caveat for caveat in own.verdict.caveats)


def test_an_aspect_ratio_or_focal_length_that_views_leave_open_is_said() -> None:
    """Truth: frontal views at one distance: focal length and distance are one."""
    rng, width = np.random.default_rng(3), boards.SIZE[0]
    pixels = []
    for _ in range(5):
        turn, at = rng.normal(0, 0.01, 3), np.array([*rng.uniform(-40, 40, 2), 500.0])
        seen = boards.seen(TARGET, turn, at)
        pixels.append(seen + rng.normal(0, 0.1, seen.shape))
    views = Views.from_arrays([TARGET] * 5, pixels, width=width, height=boards.SIZE[1])
    found = bc.calibrate(views, lenses=["pinhole"], independent=True, ess=100)
    said = " ".join(found.verdict.caveats)
    assert "hardly tell" in said
    assert "focal length" in said
    assert "nearly parallel" in said


def drift_of(pictures: list[tuple[Array, Array]]) -> str:
    """What is said of halves of the views that disagree."""
    world, pixels = map(list, zip(*pictures, strict=True))
    width, height = boards.SIZE
    views = Views.from_arrays(world, pixels, width=width, height=height)
    found = bc.calibrate(views, lenses=["radial 2"], independent=True, ess=100)
    return " ".join(f.text for f in found.verdict.findings if f.kind == "drift")


@pytest.mark.parametrize(
    ("changed", "k1", "said"),
    [
        ([0] * 4 + [1] * 4, -0.25, "the first half of the views and the rest disagree by"),
        ([0, 1] * 6, -0.265, "every second view and the others disagree by"),
    ],
)
def test_a_camera_that_changes_between_views_is_said(
    changed: list[int], k1: float, said: str
) -> None:
    rng = np.random.default_rng(5)
    lenses = [(-0.28, 0.07, 0.0, 0.0, 0.0), (k1, 0.07, 0.0, 0.0, 0.0)]
    pictures = [boards.pictures(rng, 1, lenses[which], 0.1) for which in changed]
    assert said in drift_of([(world, pixels[0]) for world, pixels in pictures])


def test_halves_that_know_unequally_much_do_not_disagree() -> None:
    """Truth: one camera; 1 % of sets may be called, of ten more than one in 0.4 % of cases."""
    called = 0
    for seed in range(10):
        world, pixels = boards.pictures(np.random.default_rng(seed), 8, sigma=0.1)
        few = np.arange(len(world)) % 9 < 2  # every second view shows a strip of the target
        called += bool(
            drift_of([(world[few], p[few]) if v % 2 else (world, p) for v, p in enumerate(pixels)])
        )
    assert called <= 1
