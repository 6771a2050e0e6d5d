"""Defended comparisons that several tests look at."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.comparison.results import AxisComparison
from tests.helpers.cases import camera_points, defended

LINE = (960.0, 700.0)


@pytest.fixture(scope="package")
def weak_curve() -> AxisComparison:
    """b_2 = 0.45 px under 1 px of noise, 200 points: worth about 4 of twice ln L."""
    return defended(camera_points(200, (*LINE, 0.45), 1.0, 7), (1, 2))


@pytest.fixture(scope="package")
def one_bad_group() -> AxisComparison:
    """A straight line; the five points of group h at one end are 3 px off together."""
    names = tuple("abcdefgh"[i // 5] for i in range(40))
    shift = 3.0 * (np.array(names) == "h")
    return defended(camera_points(40, LINE, 1.0, 1, shift=shift, groups=names))
