"""Maps over the image: every colour ends at a line that has its number, and numbers are legible."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import bayescal as bc
from bayescal.prediction.maps import image_maps
from bayescal.report.figures.camera.panels import FEWEST_LEVELS, MOST_LEVELS, _lengths, levels_of


@pytest.fixture(scope="module")
def camera(thesis_comparison) -> bc.CalibratedCamera:
    return bc.camera(thesis_comparison)


@pytest.mark.parametrize("kind", ["sd-map", "difference-map"])
def test_numbers_on_lines_meet_nothing(camera, kind):
    figure = bc.plot(camera, kind)
    figure.draw_without_rendering()
    panels = [panel for panel in figure.axes if panel.axison]
    assert len(panels) > 1
    for panel in panels:
        assert panel.get_ylabel() == "c as recorded [px]"
        shown = [t for t in panel.texts if t.get_visible()]
        boxes = [t.get_window_extent() for t in shown]
        frame = panel.get_window_extent()
        assert shown
        assert all(frame.x0 < b.x0 and b.x1 < frame.x1 for b in boxes)
        assert all(frame.y0 < b.y0 and b.y1 < frame.y1 for b in boxes)
        assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
        assert all(float(t.get_text()) > 0 and t.get_rotation() == 0 for t in shown)


def test_levels_are_round_and_reach_what_is_inside(camera):
    maps = image_maps(camera, columns=17, rows=13)
    inside = maps.places.inside
    shown = (maps.epistemic, maps.predictive, *(d.size for d in maps.differences))
    for values in shown:
        levels = levels_of(values, maps)
        assert FEWEST_LEVELS <= len(levels) <= MOST_LEVELS
        assert all(float(f"{v:.1e}") == pytest.approx(v, rel=1e-12) for v in levels)
        assert levels[0] > values[inside].max() / 10
        assert values[inside].max() < 100 * levels[-1]


def test_lengths_between_places_are_those_of_the_shifts():
    """Truth: a shift that is linear over the image, and is zero between two places."""
    r, c = np.arange(5.0), np.arange(4.0)
    grid = np.stack(np.meshgrid(r, c), axis=-1).reshape(-1, 2)
    fine_r, fine_c, found = _lengths(r, c, 2.0 * (grid - 1.5))
    expected = 2.0 * np.hypot(fine_r - 1.5, (fine_c - 1.5)[:, None])
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert found.min() < 1e-12
