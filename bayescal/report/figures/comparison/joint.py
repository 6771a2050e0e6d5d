"""Probability of every pair of orders of two axes."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from bayescal.arrays import Array
from bayescal.comparison.defence.stability import joint_probabilities
from bayescal.comparison.results import AxisComparison
from bayescal.errors import InputError
from bayescal.report.figures.style import BLUE, GREY, VERMILLION, ink_on, one_panel
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset
from bayescal.rounding import percent

SHADES = LinearSegmentedColormap.from_list("probability", ["#ffffff", BLUE])
LINES = "#b8c0c6"
CELL = (0.72, 0.42)  # inches
SHOWN = 0.0005  # probability below which a cell is not worth a look


def draw(subject: Subject) -> Figure:
    """Draw a cell per pair, shaded by its probability; the most probable is framed."""
    (first, second), table = _table(subject)
    rows, columns = table.shape
    width, height = max(3.6, CELL[0] * columns + 1.1), max(1.7, CELL[1] * rows + 1.1)
    figure, panel = one_panel(width, height)
    edges = [np.arange(size + 1) - 0.5 for size in (columns, rows)]
    panel.pcolormesh(*edges, table, cmap=SHADES, vmin=0, vmax=1, edgecolors=LINES, linewidth=0.5)
    for (i, j), chance in np.ndenumerate(table):
        ink = ink_on(SHADES(float(chance))) if chance >= SHOWN else GREY
        text = typeset(percent(float(chance)))
        panel.text(j, i, text, ha="center", va="center", color=ink, fontsize=8.5)
    i, j = np.unravel_index(int(table.argmax()), table.shape)
    frame = Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor=VERMILLION, linewidth=1.8)
    panel.add_patch(frame).set_clip_on(False)
    panel.set_xticks(range(columns), [str(r.order) for r in second.orders])
    panel.set_yticks(range(rows), [str(r.order) for r in first.orders])
    panel.set_xlabel(f"order of {second.data.axis}({second.data.regressor})")
    panel.set_ylabel(f"order of {first.data.axis}({first.data.regressor})")
    panel.set_title("posterior probability of both orders", loc="left")
    panel.invert_yaxis()  # as a table reads
    panel.tick_params(length=0)
    for spine in panel.spines.values():
        spine.set_visible(False)
    return figure


def _table(subject: Subject) -> tuple[tuple[AxisComparison, AxisComparison], Array]:
    if len(subject.axes) != 2:
        raise InputError("joint needs both axes compared")
    first, second = subject.axes
    chances = [
        {r.order: r.probability for r in axis.orders if r.probability is not None}
        for axis in subject.axes
    ]
    if not all(chances):
        raise InputError("joint needs probabilities, and a flat prior has none")
    return (first, second), joint_probabilities(*chances)


def alt_text(subject: Subject) -> str:
    """Say the most probable pairs."""
    (first, second), table = _table(subject)
    best = np.argsort(-table, axis=None, kind="stable")[:4]
    parts = []
    for place in best.tolist():
        i, j = divmod(place, table.shape[1])
        if table[i, j] >= SHOWN:
            pair = f"{first.orders[i].order} and {second.orders[j].order}"
            parts.append(f"{pair} {percent(float(table[i, j]))}")
    return (
        f"Table of the probability of each pair of orders of {first.data.axis} and "
        f"{second.data.axis}; the most probable: {', '.join(parts)}."
    )
