"""Did the chains reach the same place? Their draws, and the ranks of their draws.

ArviZ's plots would do, but both its 0.23 (arviz_plots 0.8) and its 1.x draw through
pyplot, whose global state and choice of a window system a library must not touch. The
ranks are its ``plot_rank``: Sailynoja, Buerkner & Vehtari 2022, Stat. Comput. 32, 32.
"""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation
from scipy.stats import kstwo, rankdata

from bayescal.arrays import Array
from bayescal.report.figures.parameters import parameter_label
from bayescal.report.figures.style import BLUE, GREY, PALE, VERMILLION, WIDTH, several_panels
from bayescal.report.figures.subject import Subject

SHOWN = 4  # chains whose draws are drawn: more hide one another
LEVEL = 0.95


def draw(subject: Subject) -> Figure:
    """Draw a row per parameter: some chains' draws, and every chain's ranks.

    Right: the share of a chain's draws up to each rank among all draws, less what it
    would be were the chains alike, with the band that holds all chains' with
    probability 0.95.
    """
    draws, names = subject.result.posterior.chain.draws, subject.result.posterior.names
    chains, length, size = draws.shape
    figure = several_panels(WIDTH, 1.05 * size + 0.9)
    panels = figure.subplots(size, 2, squeeze=False, width_ratios=[1.6, 1], sharex="col")
    bound = _bound(chains, length)
    shown = np.linspace(0, chains - 1, min(SHOWN, chains)).astype(int)
    for j, (name, (left, right)) in enumerate(zip(names, panels, strict=True)):
        for chain, colour in zip(shown, (BLUE, VERMILLION, "#009e73", "#e69f00"), strict=False):
            left.plot(np.arange(1, length + 1), draws[chain, :, j], color=colour, linewidth=0.7)
        left.set_ylabel(parameter_label(name, subject.unit))
        if name == "tau":
            left.set_yscale("log")
            # Within a decade more than its ends find room only where there is no other.
            left.yaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(0.5, 0.2)))
        share, differences = rank_differences(draws[:, :, j])
        right.axhspan(-bound, bound, color=PALE, alpha=0.5, linewidth=0)
        lines = np.stack(np.broadcast_arrays(share, differences), axis=2)
        ranks = LineCollection(list(lines), colors=BLUE, linewidths=0.4, alpha=0.5)
        right.add_collection(ranks).set_rasterized(True)
        right.axhline(0, color=GREY, linewidth=0.7)
        right.set_ylim(-1.6 * bound, 1.6 * bound)
        right.set_xlim(0, 1)
    panels[0, 0].set_title(f"{subject.title}: {len(shown)} of {chains} chains", loc="left")
    panels[0, 1].set_title("ranks, less uniform", loc="left")
    panels[-1, 0].set_xlabel("draw")
    panels[-1, 1].set_xlabel("rank among all draws, as a share")
    figure.align_ylabels(panels[:, 0])
    return figure


def rank_differences(draws: Array) -> tuple[Array, Array]:
    """Distribution of each chain's ranks among all draws, less the uniform one.

    Parameters
    ----------
    draws : Array
        One parameter, ``(n_chains, n_draws)``.

    Returns
    -------
    share : Array
        Rank as a share of all draws, ``(n_shares,)``.
    difference : Array
        ``(n_chains, n_shares)``.
    """
    ranks = rankdata(draws).reshape(draws.shape) / draws.size
    share = np.linspace(0, 1, min(draws.shape[1], 100) + 1)
    ordered = np.sort(ranks, axis=1)
    below = np.array([np.searchsorted(row, share, side="right") for row in ordered])
    return share, below / draws.shape[1] - share


def _bound(chains: int, length: int) -> float:
    """Half-width of the band: Kolmogorov-Smirnov's for one chain, Bonferroni's for all."""
    return float(kstwo.isf((1 - LEVEL) / chains, length))


def alt_text(subject: Subject) -> str:
    """Say how far the chains' ranks are apart, and the diagnostics."""
    posterior = subject.result.posterior
    chains, length, size = posterior.chain.draws.shape
    worst = max(
        float(np.abs(rank_differences(posterior.chain.draws[:, :, j])[1]).max())
        for j in range(size)
    )
    rhat = max(p.rhat for p in posterior.parameters)
    ess = min(p.ess for p in posterior.parameters)
    return (
        f"Traces and ranks of {chains} chains of {length} draws, {subject.title}: ranks differ "
        f"from uniform by at most {worst:.2f} (band {_bound(chains, length):.2f}); largest R-hat "
        f"{rhat:.3f}, smallest effective sample size {ess:.0f}."
    )
