"""The line that says a comparison of orders should have been one of families."""

import re
from dataclasses import replace

import numpy as np
import pytest

import bayescal as bc
from tests.helpers.cameras import turned_points


def test_the_hint_is_given_where_it_is_due():
    """A turned camera: very strongly. A separable camera, and the thesis data: not."""
    turned = turned_points(0.06)
    found = bc.compare(turned, [1, 2], ess=100)
    assert "free camera position" in found.hint
    gain = float(re.search(r"2 ln B about (\d+)", found.hint)[1])
    pinhole = bc.fit_family(turned, "pinhole", (1,), ess=400).best.log_evidence
    stated = sum(axis.chosen.log_evidence for axis in found.axes.values())
    assert gain == pytest.approx(2 * (pinhole - stated), rel=0.01)  # Laplace
    assert bc.compare(turned, [1, 2], ess=100, hint=False).hint is None
    points = bc.thesis()
    assert bc.compare(points, [1, 4], ess=100).hint is None
    away = points.camera_frame()
    w, u = away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]
    exact = np.column_stack([960 + 1100 * w, 540 - 1100 * u])
    noisy = exact + np.random.default_rng(0).normal(0, 2, exact.shape)
    assert bc.compare(replace(points, pixels=noisy), [1, 2], ess=100).hint is None
