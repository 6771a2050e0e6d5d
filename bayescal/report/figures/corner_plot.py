"""What corner plots have in common: every pair of parameters, and each alone with quantiles."""

from __future__ import annotations

from collections.abc import Sequence

import corner
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.report.figures.style import BLUE, several_panels
from bayescal.report.typography import typeset

# Two-dimensional levels of one and two sigma: 1 - exp(-k^2 / 2), not 68 % and 95 %.
LEVELS = (1 - float(np.exp(-0.5)), 1 - float(np.exp(-2.0)))
QUANTILES, SHOWN = (0.025, 0.5, 0.975), "2.5%, 50%, 97.5%"
SHARE = 0.997  # of the draws of each parameter is in view
PANEL, LEAST = 1.0, 5.2  # inches: of a panel, of the whole


def corner_plot(draws: Array, labels: Sequence[str], bins: int = 30) -> tuple[Figure, Array]:
    """Draw parameters ``(n_draws, n)`` against each other; the panels, ``(n, n)``."""
    size = len(labels)
    side = max(LEAST, PANEL * size + 1.0)
    figure = several_panels(side, side, layout=None)
    corner.corner(
        draws,
        labels=list(labels),
        levels=LEVELS,
        quantiles=list(QUANTILES),
        range=[SHARE] * size,
        bins=bins,
        smooth=1.0,
        color=BLUE,
        plot_datapoints=False,
        fill_contours=True,
        no_fill_contours=True,  # no white below them: there are no points to hide
        max_n_ticks=3,
        labelpad=0.12 * PANEL,
        label_kwargs={"fontsize": 9},
        hist_kwargs={"density": True},
        fig=figure,
    )
    panels = np.array(figure.axes).reshape(size, size)
    for panel in panels.ravel():
        panel.tick_params(labelsize=6.5)
    figure.subplots_adjust(left=0.95 / side, bottom=0.95 / side, right=1 - 0.1 / side, top=0.98)
    return figure, panels


def check_spread(draws: Array, names: Sequence[str], title: str) -> None:
    """Refuse parameters whose draws are all the same."""
    for name, values in zip(names, draws.T, strict=True):
        if not np.ptp(values) > 0:
            raise InputError(f"corner of {title}: the draws of {name} don't differ")


def explain(figure: Figure, title: str, draws: str, *laid_over: Line2D) -> None:
    """Write, in the empty corner, what the lines and contours are."""
    inner, outer = (typeset(f"{100 * level:.1f}%") for level in LEVELS)
    figure.legend(
        handles=[
            Line2D([], [], color=BLUE, linewidth=5, alpha=0.6, label=draws),
            *laid_over,
            Line2D([], [], color=BLUE, linestyle="--", linewidth=1, label=typeset(SHOWN)),
        ],
        loc="upper right",
        bbox_to_anchor=(0.995, 0.985),
        alignment="left",
        title=f"{title}\ncontours: {inner} and {outer} of the\nprobability (1 and 2 sigma in two\n"
        "dimensions)",
        title_fontsize=8.5,
    )
