"""Each point's residual and its probability of being bad, in the order of the file."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.comparison.outliers.records import BAD
from bayescal.comparison.outliers.results import AxisOutliers
from bayescal.report.figures.style import BLUE, GREY, VERMILLION, WIDTH, several_panels
from bayescal.rounding import percent

NAMED = 12  # bad points with their labels; more would hide each other


def draw(axis: AxisOutliers) -> Figure:
    """Draw the axis's points: above the residuals of least squares, below P(bad)."""
    figure = several_panels(WIDTH, 3.9)
    residuals, chances = figure.subplots(2, sharex=True)
    for points, colour, marker, words in (
        ([p for p in axis.points if not p.bad], BLUE, "o", "more probably good"),
        ([p for p in axis.points if p.bad], VERMILLION, "D", "more probably bad"),
    ):
        numbers = [p.index + 1 for p in points]
        residuals.plot(
            numbers, [p.residual for p in points], marker, color=colour, ms=4, label=words
        )
        values = [p.bad_probability for p in points]
        chances.vlines(numbers, 0, values, color=colour, linewidth=1)
        chances.plot(numbers, values, marker, color=colour, ms=4)
    for point in axis.bad[:NAMED]:
        residuals.annotate(
            point.label[:14],
            (point.index + 1, point.residual),
            (5, 0),
            textcoords="offset points",
            va="center",
        )
    residuals.axhline(0, color=GREY, linewidth=0.8)
    residuals.margins(y=0.15)
    residuals.set_ylabel("residual [px]")
    chances.axhline(BAD, color=GREY, linewidth=0.8, linestyle="--")
    chances.set_ylim(0, 1.08)
    chances.set_yticks(np.linspace(0, 1, 5))
    chances.set_ylabel("P(bad)")
    chances.set_xlabel("number of the point, from 1")
    title = f"{axis.data.axis}({axis.data.regressor}): order {axis.order}, outlier mixture"
    residuals.set_title(title, loc="left")
    figure.legend(*residuals.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def alt_text(axis: AxisOutliers) -> str:
    """Name the bad points with their residuals and probabilities."""
    found = ", ".join(
        f"{p.label} ({p.residual:+.3g} px, {percent(p.bad_probability)})" for p in axis.bad[:NAMED]
    )
    rest = f" and {len(axis.bad) - NAMED} more" if len(axis.bad) > NAMED else ""
    said = f"More probably bad than good: {found}{rest}." if found else "None is probably bad."
    return (
        f"Residual of least squares and probability of being bad of each of {len(axis.points)} "
        f"points of {axis.data.axis} at order {axis.order}. {said}"
    )
