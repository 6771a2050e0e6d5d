"""Figures: functions that take results and return matplotlib figures."""

from __future__ import annotations

import corner
import numpy as np
from matplotlib.figure import Figure

from bayescal.comparison.results import AxisComparison, OrderResult

# Two-dimensional levels of one and two sigma: 1 - exp(-k^2 / 2), not 68 % and 95 %.
CORNER_LEVELS = (1 - np.exp(-0.5), 1 - np.exp(-2.0))
COLOUR = "#0072b2"  # Okabe & Ito's blue


def corner_plot(axis: AxisComparison, result: OrderResult) -> Figure:
    """Corner plot of one order's draws.

    Parameters
    ----------
    axis : AxisComparison
    result : OrderResult

    Returns
    -------
    matplotlib.figure.Figure
        Dashed lines: 2.5 %, 50 %, 97.5 % quantiles of each parameter.
    """
    posterior = result.posterior
    draws = posterior.chain.draws
    flat = draws.reshape(-1, draws.shape[2]).copy()
    if posterior.names[-1] == "tau":  # spans decades
        flat[:, -1] = np.log10(flat[:, -1])
    size = flat.shape[1]
    side = 1.9 * size + 1.2
    figure = Figure(figsize=(side, side), layout=None)
    labels = [_label(name) for name in posterior.names]
    corner.corner(
        flat,
        labels=labels,
        levels=CORNER_LEVELS,
        quantiles=[0.025, 0.5, 0.975],
        bins=30,
        smooth=1.0,
        color=COLOUR,
        plot_datapoints=False,
        fill_contours=True,
        max_n_ticks=4,
        label_kwargs={"fontsize": 11},
        fig=figure,
    )
    for ax in figure.axes:
        ax.tick_params(labelsize=8)
    data = axis.data
    figure.suptitle(
        f"{data.axis} as a polynomial of order {result.order} in {data.regressor}: "
        f"{len(flat)} draws of emcee",
        x=0.98,
        y=0.985,
        ha="right",
        fontsize=13,
    )
    figure.text(
        0.98,
        0.985 - 0.35 / side,
        "dashed: 2.5 %, 50 %, 97.5 %\ncontours: 39.3 % and 86.5 % of the\nprobability "
        "(1 and 2 sigma in two dimensions)",
        ha="right",
        va="top",
        fontsize=10,
    )
    return figure


def _label(name: str) -> str:
    if name == "tau":
        return r"$\log_{10}\,\tau$"
    stem, _, index = name.partition("_")
    if stem not in ("alpha", "beta", "sigma"):  # a factor on stated deviations, say
        return name
    symbol = rf"$\{stem}_{{{index}}}$" if index else rf"$\{stem}$"
    return f"{symbol} [px]"
