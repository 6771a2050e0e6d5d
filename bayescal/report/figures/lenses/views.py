"""What is left over, a panel per view."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from bayescal.arrays import Array
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.comparison.image import arrow_scale, key_length
from bayescal.report.figures.labels import printable_names
from bayescal.report.figures.lenses.image import frame
from bayescal.report.figures.lenses.vectors import bad_words, draw_bad, draw_vectors, leftovers
from bayescal.report.figures.style import GREY, WIDTH, settle, several_panels

KEY = 0.25  # inches above the panels for the arrow that explains the others
ACROSS, MOST = 4, 20  # panels in a row; in all: of more views the loudest are shown


def draw(found: LensComparison) -> Figure:
    """Draw arrows of one scale in a panel per view."""
    chosen = shown(found)
    across = min(ACROSS, len(chosen))
    down = math.ceil(len(chosen) / across)
    width, height = found.setting.data.size
    tall = down * (WIDTH / across * height / width + 0.25) + KEY
    layout = ConstrainedLayoutEngine(rect=(0, 0, 1, 1 - KEY / tall))
    figure = several_panels(WIDTH, tall, layout=layout)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    lengths = np.hypot(*leftovers(found)[1].T)
    scale = arrow_scale(lengths) / width
    names, sizes = printable_names(found.views.names), view_rms(found)
    quivers = []
    for panel, view in zip(panels, chosen, strict=False):
        frame(panel, found)
        panel.set_xticks([])
        panel.set_yticks([])
        panel.spines[:].set_visible(True)
        panel.spines[:].set_color(GREY)
        quivers.append(draw_vectors(panel, *leftovers(found, view), scale, width=0.005))
        draw_bad(panel, found, view)
        panel.set_title(f"{names[view]}: {sizes[view]:.2f} px", loc="left", fontsize=8)
    for panel in panels[len(chosen) :]:
        panel.set_axis_off()
    key = key_length(lengths)
    panels[0].quiverkey(
        quivers[0], 0.96, 1 - KEY / tall / 2, key, f"{key:g} px", labelpos="W", color=GREY,
        coordinates="figure",
    )  # fmt: skip
    settle(figure)
    return figure


def view_rms(found: LensComparison) -> Array:
    """Root mean square of what is left over of each view, ``(n_views,)``, px."""
    squares = (found.problem.noise**2).sum(axis=(1, 2))
    return np.asarray(np.sqrt(squares / found.setting.data.counts))


def shown(found: LensComparison) -> list[int]:
    """Choose views to draw: all, or those with the largest residuals."""
    sizes = view_rms(found)
    if len(sizes) <= MOST:
        return list(range(len(sizes)))
    return sorted(int(v) for v in np.argsort(-sizes, kind="stable")[:MOST])


def alt_text(found: LensComparison) -> str:
    """Say which views have the largest residuals."""
    sizes, names = view_rms(found), printable_names(found.views.names)
    worst = np.argsort(-sizes, kind="stable")[:3]
    parts = ", ".join(f"{names[v]} {sizes[v]:.2f}" for v in worst)
    few = "" if len(shown(found)) == len(sizes) else f" of the {MOST} loudest of {len(sizes)} views"
    return (
        f"Residuals as arrows, a panel per view{few}; root mean square px, the largest: {parts}; "
        f"the median {np.median(sizes):.2f}.{bad_words(found)}"
    )
