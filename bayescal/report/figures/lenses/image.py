"""What figures over the image of many views share."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.style import COLOURS, PALE, WIDTH, one_panel

COLUMNS, ROWS = 65, 49  # of a grid over the image
LEVELS = tuple(m * 10.0**e for e in range(-4, 4) for m in (1, 2, 5))  # px, of contours
MOST_LEVELS = 8  # from the largest downwards: rings about a zero say little


def image_panel(found: LensComparison) -> tuple[Figure, Axes]:
    """Lay out a figure that is the image."""
    width, height = found.setting.data.size
    figure, panel = one_panel(WIDTH, WIDTH * height / width * 0.95 + 0.4)
    frame(panel, found)
    panel.set_xlabel("r [px]")
    panel.set_ylabel("c [px]")
    return figure, panel


def frame(panel: Axes, found: LensComparison) -> None:
    """Make a panel the image, c downwards."""
    width, height = found.setting.data.size
    panel.set_xlim(-0.5, width - 0.5)
    panel.set_ylim(height - 0.5, -0.5)
    panel.set_aspect("equal")


def draw_contours(panel: Axes, found: LensComparison, grid: Array, values: Array) -> None:
    """Draw labelled contours of values, px, on a grid over the image, the points beneath."""
    data = found.setting.data
    panel.plot(*data.pixels[data.seen].T, ".", color=PALE, markersize=2, rasterized=True)
    known = values[np.isfinite(values)]
    levels = [v for v in LEVELS if known.min() < v < known.max()][-MOST_LEVELS:]
    levels = levels or [float(np.median(known))]
    r, c = (part.reshape(ROWS, COLUMNS) for part in grid.T)
    shown = np.ma.masked_invalid(values.reshape(ROWS, COLUMNS))
    lines = panel.contour(r, c, shown, levels=levels, cmap=COLOURS, norm=LogNorm(), linewidths=1.5)
    panel.clabel(lines, fmt=lambda v: f"{v:g} px", fontsize=7.5)
