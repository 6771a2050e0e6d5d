"""Residuals of one order over the regressor that its polynomial leaves out."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.adequacy.coordinate import other_coordinate
from bayescal.comparison.adequacy.outcome import p_words
from bayescal.comparison.adequacy.problem import other_name
from bayescal.errors import InputError
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.separable import axis_data
from bayescal.report.figures.comparison.residuals import describe, draw_over
from bayescal.report.figures.residual_points import ResidualPoints
from bayescal.report.figures.subject import Subject


def draw(subject: Subject) -> Figure:
    """Draw a marker per point, and say in the title whether the residuals depend on it."""
    found = ResidualPoints.of(subject.axis, subject.result)
    name = other_name(subject.axis.data.regressor)
    figure, panel = draw_over(subject, found, _other(subject), name)
    tested = other_coordinate(found.problem, _other(subject))
    if tested.p_value is not None:
        panel.set_title(f"F test of a dependence on {name}: {p_words(tested.p_value)}", loc="right")
    return figure


def _other(subject: Subject) -> Array:
    """Regressor of the other axis, ``(n_points,)``."""
    points, own = subject.comparison.points, subject.axis.data.axis
    if points is None:
        raise InputError("other needs points of a camera: y is a function of x alone")
    return axis_data(points, PIXEL_AXES[own].other).x


def alt_text(subject: Subject) -> str:
    """Say how large the residuals are, which stand out, and what the F test says."""
    found = ResidualPoints.of(subject.axis, subject.result)
    other = _other(subject)
    tested = other_coordinate(found.problem, other)
    words = f"{p_words(tested.p_value)}; " if tested.p_value is not None else ""
    name = other_name(subject.axis.data.regressor)
    test = f"F test of a dependence on {name}: {words}{tested.meaning}"
    return f"{describe(subject, found, name)} {test}"
