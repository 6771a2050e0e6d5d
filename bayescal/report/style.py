"""The look that figures share, and how they are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

WIDTH = 7.2  # inches: two columns of a journal
KEPT, REMOVED, GREY = "#0072b2", "#d55e00", "#666666"  # Okabe & Ito's blue and vermillion
# Cividis is safe for the colour-blind; its palest end is left out, for it fades on white.
COLOURS = LinearSegmentedColormap.from_list(
    "depth", colormaps["cividis"](np.linspace(0, 0.92, 256))
)
STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7.5,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "bayescal",  # the same figure gives the same bytes
}


def settle(figure: Figure) -> None:
    """Lay a figure out for good, so that names can be placed on the page."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def save_figure(figure: Figure, stem: Path) -> None:
    """Write a figure as PNG (300 dpi) and SVG beside each other, without dates.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    stem : Path
        Of the files, without a suffix.
    """
    with rc_context(STYLE):
        figure.savefig(stem.with_suffix(".png"), dpi=300, metadata={"Software": None})
        figure.savefig(stem.with_suffix(".svg"), metadata={"Date": None})
