"""Pixels per unit of world error: against finite differences of the fitted map."""

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.defence.world_units import world_units
from bayescal.linear.least_squares import factorise, solve
from bayescal.polynomials.separable import axis_data


@pytest.mark.parametrize(("axis", "order"), [("r", 4), ("c", 1)])
def test_slopes_equal_finite_differences(axis, order):
    """Central differences of step h err by h^2 of the third derivative: below 1e-6 here."""
    points = bc.thesis()
    data = axis_data(points, axis)
    fit = solve(factorise(data, order), order)
    camera = points.camera_frame()
    column = 0 if axis == "r" else 1

    def pixel(place):
        return np.polynomial.polynomial.polyval(place[column] / place[2], fit.coefficients)

    for unit in world_units(data, fit, camera):
        step = np.zeros(3)
        step["xyz".index(unit.coordinate)] = 1e-3
        for label, found in (
            (unit.nearest_point, unit.nearest),
            (unit.median_point, unit.median),
        ):
            place = camera[points.labels.index(label)]
            slope = (pixel(place + step) - pixel(place - step)) / 2e-3
            assert found == pytest.approx(abs(slope), abs=1e-6)
    depths = np.abs(camera[:, 2])
    assert depths[points.labels.index(unit.nearest_point)] == depths.min()
    assert depths[points.labels.index(unit.median_point)] == np.median(depths)
