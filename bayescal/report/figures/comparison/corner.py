"""Corner plot: the draws of all parameters, the closed form laid over them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.linear.closed_form_density import Densities
from bayescal.report.figures.corner_plot import LEVELS, check_spread, corner_plot, explain
from bayescal.report.figures.parameters import parameter_label
from bayescal.report.figures.style import VERMILLION
from bayescal.report.figures.subject import Subject
from bayescal.rounding import rounded

SHOWN_OVER = 12  # parameters up to which the closed form is laid over the draws


def draw(subject: Subject) -> Figure:
    """Draw every pair of parameters, and each alone with three quantiles."""
    names, draws = subject.result.posterior.names, _draws(subject)
    figure, panels = corner_plot(draws, [_label(name, subject.unit) for name in names])
    laid_over = []
    if subject.exact is not None and len(names) <= SHOWN_OVER:
        _overlay(panels, names, Densities(subject.exact))
        laid_over.append(Line2D([], [], color=VERMILLION, linewidth=1, label="closed form"))
    explain(figure, subject.title, f"{len(draws)} draws of emcee", *laid_over)
    return figure


def _draws(subject: Subject) -> Array:
    """All draws, ``(n_draws, n_parameters)``; tau, which spans decades, as log10."""
    posterior = subject.result.posterior
    flat = posterior.chain.draws.reshape(-1, len(posterior.names)).copy()
    if "tau" in posterior.names:
        j = posterior.names.index("tau")
        flat[:, j] = np.log10(flat[:, j])
    check_spread(flat, posterior.names, subject.title)
    return flat


def _overlay(panels: Array, names: tuple[str, ...], densities: Densities) -> None:
    """Lay the closed form over the panels, as lines."""
    for j, name in enumerate(names):
        diagonal: Axes = panels[j, j]
        diagonal.plot(*densities.marginal(name), color=VERMILLION, linewidth=1)
        top = max(diagonal.get_ylim()[1], 1.05 * float(densities.marginal(name)[1].max()))
        diagonal.set_ylim(0, top)
        for i in range(j):
            panel: Axes = panels[j, i]
            limits = panel.get_xlim(), panel.get_ylim()
            found = densities.joint(names[i], name)
            panel.contour(
                found.x,
                found.y,
                found.density,
                levels=sorted(set(found.thresholds(LEVELS))),
                colors=VERMILLION,
                linewidths=0.9,
            )
            panel.set_xlim(limits[0])
            panel.set_ylim(limits[1])


def _label(name: str, unit: str) -> str:
    return r"$\log_{10}\,\tau$" if name == "tau" else parameter_label(name, unit)


def alt_text(subject: Subject) -> str:
    """Say mean and sd of every parameter, and how near the closed form is."""
    posterior = subject.result.posterior
    unit = subject.unit
    parts = ", ".join(
        f"{p.name} {rounded(p.mean, p.sd)} ± {rounded(p.sd, p.sd)}"
        + ("" if p.name in ("tau", "scale") else f" {unit}")
        for p in posterior.parameters
    )
    chains, length, _ = posterior.chain.draws.shape
    known = [p.deviation for p in posterior.parameters if p.deviation is not None]
    near = (
        f" Means and sds are within {max(known):.1f} Monte Carlo errors of the closed form."
        if known
        else ""
    )
    return f"Corner plot of {chains * length} draws, {subject.title}. Mean ± sd: {parts}.{near}"
