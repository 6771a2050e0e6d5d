"""Answers of a calibrated camera show themselves in a line, not as arrays."""

from __future__ import annotations

import pytest

import bayescal as bc


@pytest.fixture(scope="module")
def fitted() -> bc.CalibratedCamera:
    """A camera of the thesis's points, one model."""
    found = bc.fit(bc.thesis(), 4, 1, ess=400)
    return bc.camera(found)


def test_answers_show_themselves_in_a_line(fitted: bc.CalibratedCamera) -> None:
    pixels = [[900.0, 500.0], [5000.0, 500.0]]
    points = bc.locate(fitted, pixels, depth=300)
    assert repr(points) == "<Location: points of 2 pixels, 1 found>"
    assert repr(bc.locate(fitted, pixels)) == "<Location: directions of 2 pixels, 1 found>"
    pairs = bc.distances(fitted, [[900.0, 500.0, 960.0, 540.0]], depth=300)
    assert repr(pairs) == "<Distances of 1 pair: 1 found, 1 with U>"
    maps = bc.image_maps(fitted, columns=5, rows=4)
    assert repr(maps) == "<ImageMaps: 4 rows of 5, by separable (4, 1), 0 other models>"
    again = bc.camera(bc.fit(bc.thesis(), 4, 1, ess=400, seed=1))
    assert repr(bc.changed(fitted, again)).startswith("<Change: p = 1, 0 px rms, at most ")
