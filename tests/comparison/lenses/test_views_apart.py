"""Views that are noisier than others, and views that say too little."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
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
    assert any("far above the usual" in caveat for caveat in one.verdict.caveats)
    assert not any("far above the usual" in caveat for caveat in own.verdict.caveats)


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
