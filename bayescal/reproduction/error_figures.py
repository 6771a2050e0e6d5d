"""Figures 7 to 10 of the thesis: an error of every point, for every order.

The thesis draws five orders over each other; here each order has its own panel, on
shared axes. A point is named by its number in a panel where its residual is
significant by itself at that order (at the elimination's level, per point) or where
the elimination removes it: the `NAMED` largest of these.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.style import GREY, KEPT, REMOVED, STYLE, WIDTH, settle
from bayescal.reproduction.models import AS_CODED
from bayescal.reproduction.results import AxisReproduction, OrderReproduction, Reproduction
from bayescal.rounding import plain

NAMED = 6
FAMILY_WISE: Final = "--"  # line styles of the two thresholds
PER_POINT: Final = ":"


@dataclass(frozen=True)
class ErrorKind:
    """What an error figure draws.

    Attributes
    ----------
    squared : bool
        Squared errors ("chi-squared error" in the thesis), or signed residuals.
    standardised : bool
        In units of each residual's own standard deviation, or in px.
    """

    squared: bool
    standardised: bool

    def values(self, result: OrderReproduction) -> Array:
        """Heights of all points, ``(n_points,)``; NaN where there is none."""
        values = result.before.residuals
        if self.standardised:
            missing = np.full(len(values), np.nan)
            values = missing if result.tests is None else result.tests.standardised
            values = np.where(np.isfinite(values), values, np.nan)
        return values**2 if self.squared else values

    def label(self, axis: str) -> str:
        """Label of the vertical axis, with its unit."""
        if self.standardised:
            squared = "squared " if self.squared else ""
            return f"{squared}standardised residual of {axis} [$\\sigma{'^2' * self.squared}$]"
        if self.squared:
            return f"squared error of {axis} [px²]"
        return f"residual of {axis}, measured - predicted [px]"

    def bounds(self, result: OrderReproduction) -> dict[str, list[float]]:
        """Heights of the thresholds of an order, by line style; none in px."""
        if not self.standardised or result.tests is None:
            return {}
        rule, n = result.rejection.rule, len(result.before.residuals)
        found = {}
        for style, level in ((FAMILY_WISE, rule.significance / n), (PER_POINT, rule.significance)):
            bound = result.tests.threshold(level)
            found[style] = [bound**2] if self.squared else [-bound, bound]
        return found


def error_figure(reproduction: Reproduction, axis: str, kind: ErrorKind) -> Figure:
    """Figures 7 to 10: an error of every point, an order a row, a variant a column.

    Parameters
    ----------
    axis : str
        ``"r"`` or ``"c"``.

    Returns
    -------
    matplotlib.figure.Figure
        Standardised, with the levels of the elimination's first test drawn.
    """
    models = [model for model in reproduction.models if model.axis == axis]
    rows = len(reproduction.orders)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 1.42 * rows + 0.9), layout="constrained")
        panels = figure.subplots(rows, len(models), sharex=True, sharey=True, squeeze=False)
        for column, model in enumerate(models):
            for row, result in enumerate(model.orders):
                _error_panel(panels[row, column], model, result, kind)
        n = len(reproduction.points)
        panels[0, 0].set_xlim(0, n + 1)
        panels[0, 0].set_ylim(*_limits(models, kind))
        for ax in panels[-1]:
            ax.set_xlabel("point number")
        figure.supylabel(kind.label(axis), fontsize=8)
        _legend(figure, reproduction, kind)
        settle(figure)
        for column, model in enumerate(models):
            for row, result in enumerate(model.orders):
                numbers, heights = np.arange(1.0, n + 1), kind.values(result)
                lines = [height for bounds in kind.bounds(result).values() for height in bounds]
                named = _named(result, reproduction)
                name_points(panels[row, column], numbers, heights, named, stems=True, lines=lines)
    return figure


def _error_panel(
    ax: Axes, model: AxisReproduction, result: OrderReproduction, kind: ErrorKind
) -> None:
    heights = kind.values(result)
    numbers = np.arange(1, len(heights) + 1)
    removed = np.zeros(len(heights), dtype=bool)
    removed[list(result.rejection.removed)] = True
    ax.axhline(0, color=GREY, linewidth=0.5)
    for chosen, colour, marker in ((~removed, KEPT, "o"), (removed, REMOVED, "D")):
        ax.vlines(numbers[chosen], 0, heights[chosen], color=colour, linewidth=0.8)
        ax.plot(numbers[chosen], heights[chosen], marker, color=colour, markersize=2.6)
    for style, heights_of_lines in kind.bounds(result).items():
        for height in heights_of_lines:
            ax.axhline(height, color="black", linewidth=0.7, linestyle=style)
    same = model.variant == AS_CODED and not result.before.model.slipped
    name = f"{model.name} = as written" if same else model.name
    ax.set_title(
        f"{name}, order {result.order}: RSS {plain(result.before.rss)} px²", loc="left", pad=3
    )
    ax.tick_params(length=2)


def _limits(models: list[AxisReproduction], kind: ErrorKind) -> tuple[float, float]:
    """Vertical limits that leave room for the names of the highest points."""
    values = np.concatenate([kind.values(result) for m in models for result in m.orders])
    values = values[np.isfinite(values)]
    bounds = [0.0]
    for result in (result for model in models for result in model.orders):
        bounds += [height for heights in kind.bounds(result).values() for height in heights]
    low, high = min([*values, *bounds]), max([*values, *bounds])
    room = 0.18 * (high - low) or 1.0
    return (low - 0.03 * (high - low) if kind.squared else low - room), high + room


def _named(result: OrderReproduction, reproduction: Reproduction) -> list[int]:
    """Points to name in a panel, from 0: see the module's description."""
    tests = result.tests
    if tests is None:
        return []
    out = tests.p_values < reproduction.rule.significance
    out[list(result.rejection.removed)] = True
    largest = np.argsort(-np.abs(np.nan_to_num(tests.standardised)), kind="stable")
    return [int(point) for point in largest if out[point]][:NAMED]


def _legend(figure: Figure, reproduction: Reproduction, kind: ErrorKind) -> None:
    rule = reproduction.rule
    level = f"{100 * rule.significance:g}%"
    test = f"{level} per point" if rule.per_point else f"{level} family-wise"
    point: dict[str, Any] = {"markersize": 3, "linewidth": 0.8}
    line: dict[str, Any] = {"color": "black", "linewidth": 0.7}
    removed = f"removed by the elimination ({test})"
    handles = [
        Line2D([], [], color=KEPT, marker="o", label="kept", **point),
        Line2D([], [], color=REMOVED, marker="D", label=removed, **point),
    ]
    if kind.standardised:
        handles += [
            Line2D([], [], linestyle=FAMILY_WISE, label=f"{level} family-wise", **line),
            Line2D([], [], linestyle=PER_POINT, label=f"{level} per point", **line),
        ]
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=len(handles),
        frameon=False,
        title=f"named: significant at {level} per point or removed, at most {NAMED} a panel",
        title_fontsize=7.5,
    )
