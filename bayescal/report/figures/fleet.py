"""The fleet's spread: how far every camera is from the median, quantity by quantity."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.errors import InputError
from bayescal.fleets.fleet import Fleet
from bayescal.fleets.odd import score_limit
from bayescal.report.figures.parameters import parameter_symbol
from bayescal.report.figures.style import BLUE, GREY, MANY_POINTS, VERMILLION, WIDTH, styled

FAR = 12.0  # standard deviations, beyond which a camera stands at the edge
NAMED = 3  # odd cameras named of each quantity


def draw_spread(fleet: Fleet) -> Figure:
    """Draw a line of cameras for every quantity.

    Raises
    ------
    InputError
        Where no quantity has a spread.
    """
    shown = [s for s in fleet.spreads if s.scale is not None]
    if not shown:
        raise InputError("no quantity has a spread over these cameras")
    limit = score_limit(fleet.spreads)
    edge = max(FAR, 1.2 * limit)
    with styled():
        figure = Figure(figsize=(WIDTH, 0.9 + 0.36 * len(shown)), layout="constrained")
        panel = figure.subplots()
        for row, s in enumerate(shown):
            x = np.clip(s.scores, -edge, edge)
            # Spread over the line's height by their order in the list, the same on any machine.
            y = row + 0.5 * ((np.arange(len(x)) * 0.618034) % 1 - 0.5)
            far = np.abs(s.scores) > limit
            named = [i for i in np.argsort(-np.abs(s.scores))[:NAMED] if far[i]]
            y[named] = row + np.linspace(-0.3, 0.3, NAMED)[: len(named)]  # names do not meet
            many = len(x) * len(shown) > MANY_POINTS
            panel.plot(
                x[~far], y[~far], ".", color=BLUE, ms=3 if many else 6, alpha=0.4, rasterized=many
            )
            panel.plot(x[far], y[far], "o", color=VERMILLION, ms=4)
            for i in named:
                side, step = ("right", -5) if x[i] > 0 else ("left", 5)
                panel.annotate(
                    s.cameras[i],
                    (x[i], y[i]),
                    (step, 0),
                    textcoords="offset points",
                    ha=side,
                    va="center",
                    fontsize=7.5,
                    parse_math=False,
                )
        for place in (-limit, limit):
            panel.axvline(place, color=GREY, linewidth=0.8, linestyle="--")
        panel.axvline(0, color=GREY, linewidth=0.6)
        panel.set_yticks(range(len(shown)), [f"{s.of}: {parameter_symbol(s.name)}" for s in shown])
        panel.set_ylim(len(shown) - 0.4, -0.6)
        panel.set_xlim(-1.04 * edge, 1.04 * edge)
        panel.set_xlabel("distance from the fleet's median [standard deviations over the fleet]")
    return figure


def spread_text(fleet: Fleet) -> str:
    """Say how many cameras are how far off."""
    limit = score_limit(fleet.spreads)
    far = [
        f"{s.of}: {s.name} {int((np.abs(s.scores) > limit).sum())}"
        for s in fleet.spreads
        if s.scale is not None
    ]
    return f"Cameras beyond {limit:.1f} standard deviations of the fleet: {', '.join(far)}."
