"""How soon the chains forget: autocorrelation of each parameter."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.inference.chains.diagnostics import autocovariance
from bayescal.report.figures.parameters import parameter_symbol
from bayescal.report.figures.style import CYCLE, DASHES, GREY, PALE, WIDTH, legend_of, one_panel
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset

LAGS = 25


def draw(subject: Subject) -> Figure:
    """Draw a line per parameter, the mean over chains, with the band of none at all."""
    posterior = subject.result.posterior
    figure, panel = one_panel(WIDTH, 2.9)
    bound = _bound(posterior.chain.draws)
    label = typeset("95% band") + " of\nindependent draws"
    panel.axhspan(-bound, bound, color=PALE, alpha=0.6, linewidth=0, label=label)
    panel.axhline(0, color=GREY, linewidth=0.7)
    for j, name in enumerate(posterior.names):
        rho = autocorrelation(posterior.chain.draws[:, :, j])
        look = CYCLE[j % len(CYCLE)], DASHES[j // len(CYCLE) % len(DASHES)]
        panel.plot(
            np.arange(len(rho)),
            rho,
            color=look[0],
            linestyle=look[1],
            marker="o",
            markersize=2.5,
            linewidth=1,
            label=parameter_symbol(name),
        )
    panel.set_xlabel("lag [draws]")
    panel.set_ylabel("autocorrelation [1]")
    panel.set_title(subject.title, loc="left")
    legend_of(panel, "right upper", 1 + len(posterior.names) // 14)
    return figure


def autocorrelation(draws: Array) -> Array:
    """Mean over the chains at each lag, ``(n_lags,)``.

    Parameters
    ----------
    draws : Array
        One parameter, ``(n_chains, n_draws)``.
    """
    covariance = autocovariance(draws)[:, :LAGS].mean(axis=0)
    return covariance / covariance[0] if covariance[0] > 0 else np.ones_like(covariance)


def _bound(draws: Array) -> float:
    return 1.96 / float(np.sqrt(draws.shape[0] * draws.shape[1]))


def alt_text(subject: Subject) -> str:
    """Say the correlation at lag 1 and the autocorrelation time."""
    posterior = subject.result.posterior
    first = [
        float(autocorrelation(posterior.chain.draws[:, :, j])[1])
        for j in range(len(posterior.names))
    ]
    return (
        f"Autocorrelation of the draws over lag, {subject.title}: at lag 1 from {min(first):.3f} "
        f"to {max(first):.3f}, independent draws within {_bound(posterior.chain.draws):.3f}; "
        f"autocorrelation time {posterior.chain.autocorrelation_time:.2f}, acceptance "
        f"{posterior.chain.acceptance:.3f}."
    )
