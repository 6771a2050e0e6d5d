"""Corner plot of the lens: its draws, the error models averaged."""

from __future__ import annotations

import corner
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.comparison.lenses.results import LensComparison
from bayescal.errors import InputError
from bayescal.report.figures.comparison.corner import LEAST, LEVELS, PANEL, QUANTILES, SHARE
from bayescal.report.figures.style import BLUE, several_panels
from bayescal.report.typography import typeset
from bayescal.rounding import rounded

PIXELS = ("f", "fx", "fy", "cx", "cy")  # parameters in px


def draw(found: LensComparison) -> Figure:
    """Draw every pair of the lens's parameters, and each alone with three quantiles."""
    names, draws = lens_draws(found)
    size = len(names)
    side = max(LEAST, PANEL * size + 1.0)
    figure = several_panels(side, side, layout=None)
    corner.corner(
        draws,
        labels=[f"{name} [px]" if name in PIXELS else name for name in names],
        levels=LEVELS,
        quantiles=list(QUANTILES),
        range=[SHARE] * size,
        bins=24,
        smooth=1.0,
        color=BLUE,
        plot_datapoints=False,
        fill_contours=True,
        max_n_ticks=3,
        labelpad=0.12 * PANEL,
        label_kwargs={"fontsize": 9},
        fig=figure,
    )
    for panel in figure.axes:
        panel.tick_params(labelsize=6.5)
    figure.subplots_adjust(left=0.95 / side, bottom=0.95 / side, right=1 - 0.1 / side, top=0.98)
    quantiles = typeset("2.5%, 50%, 97.5%")
    inner, outer = (typeset(f"{100 * level:.1f}%") for level in LEVELS)
    figure.legend(
        handles=[
            Line2D([], [], color=BLUE, linewidth=5, alpha=0.6, label=f"{len(draws)} draws"),
            Line2D([], [], color=BLUE, linestyle="--", linewidth=1, label=quantiles),
        ],
        loc="upper right",
        bbox_to_anchor=(0.995, 0.985),
        alignment="left",
        title=f"{found.best.name}, error models averaged\ncontours: {inner} and {outer} of the\n"
        "probability (1 and 2 sigma in two\ndimensions)",
        title_fontsize=8.5,
    )
    return figure


def lens_draws(found: LensComparison) -> tuple[tuple[str, ...], Array]:
    """Give names and draws of the lens's own parameters, the bow left out, ``(n_draws, n)``."""
    model, diagonal = found.problem.model, found.setting.data.diagonal
    kept = [j for j, name in enumerate(model.names) if not name.startswith("bow")]
    draws = model.report(found.draws, diagonal)[:, kept]
    names = tuple(model.names[j] for j in kept)
    for name, values in zip(names, draws.T, strict=True):
        if not np.ptp(values) > 0:
            raise InputError(f"corner of {found.best.name}: the draws of {name} don't differ")
    return names, draws


def alt_text(found: LensComparison) -> str:
    """Say mean and sd of every parameter."""
    names, draws = lens_draws(found)
    parts = ", ".join(
        f"{name} {rounded(float(v.mean()), sd)} ± {rounded(sd, sd)}"
        for name, v in zip(names, draws.T, strict=True)
        for sd in [float(v.std(ddof=1))]
    )
    return f"Corner plot of {len(draws)} draws of {found.best.name}. Mean ± sd: {parts}."
