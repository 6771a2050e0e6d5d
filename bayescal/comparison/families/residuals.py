"""What the residuals of a joint model say against it: tests of r and of c, one block."""

from __future__ import annotations

from dataclasses import replace

from bayescal.comparison.adequacy.groups import shared_errors
from bayescal.comparison.adequacy.neighbours import neighbours
from bayescal.comparison.adequacy.normality import normality
from bayescal.comparison.adequacy.outcome import AdequacyTest, adjusted
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.surface import surface
from bayescal.comparison.families.linearised import Linearised
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.axis_data import AxisData


def residual_tests(points: Correspondences, model: Linearised) -> tuple[AdequacyTest, ...]:
    """Test the residuals of r and of c, each refitted alone by the slopes it has.

    p-values are those of linear models: of a pinhole or a free position to first order.
    """
    tests = []
    predicted = model.data.pixels - model.residuals
    for i, axis in enumerate(AXES):
        data = AxisData(
            axis,
            regressor=f"predicted {axis}",
            symbol="",
            x=predicted[i],
            t=model.residuals[i],
            sd=model.data.sd[i],
            labels=points.labels,
            size=1.0,
            size_known=False,
            source=points.source,
        )
        problem = Problem(data, model.slopes[i], model.data.levels[i])
        found = (
            surface(problem, predicted),
            neighbours(problem, predicted),
            shared_errors(problem, points.groups, points.world[:, 2]),
            normality(problem),
        )
        tests += [replace(test, name=f"{test.name}, {axis}") for test in found]
    return adjusted(tests)
