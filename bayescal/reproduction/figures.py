"""Figures 6 to 10 of the thesis, redrawn: functions that return matplotlib figures."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.polynomials.separable import axis_data
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.style import COLOURS, GREY, STYLE, WIDTH, settle
from bayescal.reproduction.error_figures import NAMED, ErrorKind, error_figure
from bayescal.reproduction.models import AS_WRITTEN
from bayescal.reproduction.results import OrderReproduction, Reproduction


def thesis_figures(reproduction: Reproduction) -> dict[str, Figure]:
    """All figures, by the name of their file.

    Returns
    -------
    dict of str to matplotlib.figure.Figure
        Figure 6; 7 to 10; 7 to 10 standardised.
    """
    figures = {"figure-06-pixels": pixels_figure(reproduction)}
    numbers = {("r", False): "07", ("c", False): "08", ("r", True): "09", ("c", True): "10"}
    for standardised in (False, True):
        for (axis, squared), number in numbers.items():
            kind = ErrorKind(squared, standardised)
            words = ["figure", number, "squared-errors" if squared else "residuals", axis]
            name = "-".join(words + ["standardised"] * standardised)
            figures[name] = error_figure(reproduction, axis, kind)
    return figures


def pixels_figure(reproduction: Reproduction) -> Figure:
    """Figure 6: pixel against world coordinate, and against what the models use.

    Returns
    -------
    matplotlib.figure.Figure
        Above, r against x and c against y, coloured by depth z; below, r against x/z
        and c against y/z with the model as written at its order of lowest BIC, and
        the points that the elimination removes at that order named.
    """
    points = reproduction.points
    depth = points.camera_frame()[:, 2]
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 5.6), layout="constrained")
        panels = figure.subplots(2, 2, sharey="col")
        for column, (axis, world) in enumerate((("r", "x"), ("c", "y"))):
            data = axis_data(points, axis)
            result = _shown(reproduction, axis)
            above, below = panels[0, column], panels[1, column]
            drawn: dict[str, Any] = {
                "c": depth,
                "cmap": COLOURS,
                "s": 13,
                "linewidths": 0.3,
                "edgecolors": "black",
            }
            shown = above.scatter(points.world[:, column], data.t, **drawn)
            above.set_xlabel(f"{world} [world units]")
            _model_curve(below, result, data.x)
            below.scatter(data.x, data.t, zorder=3, **drawn)
            below.set_xlabel(f"{data.regressor}, camera position subtracted [1]")
            for ax in (above, below):
                ax.set_ylabel(f"{axis} [px]")
                ax.tick_params(length=2)
                ax.margins(0.07)
        figure.colorbar(shown, ax=panels, label="depth z [world units]", aspect=40, pad=0.02)
        r, c = (_shown(reproduction, axis).order for axis in "rc")
        line = f"model as written: r of order {r}, c of order {c}"
        figure.legend(
            handles=[Line2D([], [], color=GREY, linewidth=0.8, label=line)],
            loc="outside lower center",
            frameon=False,
            title=f"named: removed by the elimination at that order, at most {NAMED} a panel",
            title_fontsize=7.5,
        )
        settle(figure)
        for column, axis in enumerate("rc"):
            data = axis_data(points, axis)
            removed = list(_shown(reproduction, axis).rejection.removed)[:NAMED]
            (line,) = panels[1, column].lines
            curve = np.asarray(line.get_xydata(), dtype=float)
            name_points(panels[1, column], data.x, data.t, removed, curve=curve)
    return figure


def _shown(reproduction: Reproduction, axis: str) -> OrderReproduction:
    """Find the order to draw: of lowest BIC, or the highest where BIC can't choose."""
    model = reproduction[AS_WRITTEN][axis]
    return model.best or model.orders[-1]


def _model_curve(ax: Axes, result: OrderReproduction, x: Array) -> None:
    fit = result.before
    span = np.linspace(x.min(), x.max(), 200)
    ax.plot(span, fit.model.design(span, span) @ fit.fit.coefficients, color=GREY, linewidth=0.8)
