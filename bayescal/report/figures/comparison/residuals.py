"""Residuals of one order over its regressor."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.residual_points import STANDS_OUT, ResidualPoints
from bayescal.report.figures.style import (
    BLUE,
    GREY,
    MANY_POINTS,
    PALE,
    VERMILLION,
    WIDTH,
    legend_of,
    one_panel,
    settle,
)
from bayescal.report.figures.subject import Subject
from bayescal.rounding import significant


def draw(subject: Subject) -> Figure:
    """Draw a marker per point, with twice the noise level shaded."""
    data = subject.axis.data
    found = ResidualPoints.of(subject.axis, subject.result)
    return draw_over(subject, found, data.x, data.regressor)[0]


def draw_over(subject: Subject, found: ResidualPoints, x: Array, name: str) -> tuple[Figure, Axes]:
    """Draw residuals over some coordinate of the points.

    Parameters
    ----------
    x : Array
        ``(n_points,)``, dimensionless.
    name : str
        Of the coordinate.
    """
    data, e = subject.axis.data, found.residuals
    figure, panel = one_panel(WIDTH, 3.1)
    lines = [0.0]
    if found.sigma is not None:
        bound = 2 * found.sigma
        label = f"within 2 sigma, {significant(found.sigma)} {subject.unit} {found.level}"
        panel.axhspan(-bound, bound, color=PALE, alpha=0.45, linewidth=0, label=label)
        lines += [-bound, bound]
    panel.axhline(0, color=GREY, linewidth=0.8)
    if data.sd is not None:
        bars = panel.errorbar(
            x, e, data.sd, fmt="none", ecolor=GREY, elinewidth=0.7, label="stated sd"
        )
        bars[2][0].set_rasterized(len(e) > MANY_POINTS)
    out = np.zeros(len(e), dtype=bool)
    out[list(found.named)] = True
    many = len(e) > MANY_POINTS
    panel.plot(x[~out], e[~out], "o", color=BLUE, markersize=4, label="point", rasterized=many)
    if out.any():
        label = f"studentised residual beyond {STANDS_OUT}"
        panel.plot(x[out], e[out], "D", color=VERMILLION, markersize=4.5, label=label)
    panel.set_xlabel(f"{name}{' [1]' if '/' in name else ''}")
    panel.set_ylabel(f"residual of {data.axis} [{subject.unit}]")
    panel.set_title(subject.title, loc="left")
    panel.margins(x=0.03, y=0.12)
    legend_of(panel, "lower center", 3)
    settle(figure)
    name_points(panel, x, e, found.named, lines=lines, names=found.names)
    return figure, panel


def alt_text(subject: Subject) -> str:
    """Say how large the residuals are, and which stand out."""
    found = ResidualPoints.of(subject.axis, subject.result)
    return describe(subject, found, subject.axis.data.regressor)


def describe(subject: Subject, found: ResidualPoints, name: str) -> str:
    """Say how large residuals over some coordinate are, and which stand out."""
    data, unit = subject.axis.data, subject.unit
    size = significant(float(np.sqrt(np.mean(found.residuals**2))), 3)
    return (
        f"Residuals of {data.axis} at order {subject.result.order} over {name}, {len(data)} "
        f"points: root mean square {size} {unit}, from {found.residuals.min():.3g} to "
        f"{found.residuals.max():.3g} {unit}. {found.outstanding(unit)}"
    )
