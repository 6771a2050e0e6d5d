"""Corner plot: the draws of all parameters, the closed form laid over them."""

from __future__ import annotations

import corner
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.linear.closed_form_density import Densities
from bayescal.report.figures.parameters import parameter_label
from bayescal.report.figures.style import BLUE, VERMILLION, several_panels
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset
from bayescal.rounding import rounded

# Two-dimensional levels of one and two sigma: 1 - exp(-k^2 / 2), not 68 % and 95 %.
LEVELS = (1 - float(np.exp(-0.5)), 1 - float(np.exp(-2.0)))
QUANTILES = (0.025, 0.5, 0.975)
SHARE = 0.997  # of the draws of each parameter is in view
PANEL, LEAST = 1.0, 5.2  # inches: of a panel, of the whole
SHOWN_OVER = 12  # parameters up to which the closed form is laid over the draws


def draw(subject: Subject) -> Figure:
    """Draw every pair of parameters, and each alone with three quantiles."""
    names, draws = subject.result.posterior.names, _draws(subject)
    size = len(names)
    side = max(LEAST, PANEL * size + 1.0)
    figure = several_panels(side, side, layout=None)
    corner.corner(
        draws,
        labels=[_label(name, subject.unit) for name in names],
        levels=LEVELS,
        quantiles=list(QUANTILES),
        range=[SHARE] * size,
        bins=30,
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
    overlaid = subject.exact is not None and size <= SHOWN_OVER
    if subject.exact is not None and overlaid:
        _overlay(panels, names, Densities(subject.exact))
    _caption(figure, subject, len(draws), overlaid=overlaid)
    return figure


def _draws(subject: Subject) -> Array:
    """All draws, ``(n_draws, n_parameters)``; tau, which spans decades, as log10."""
    posterior = subject.result.posterior
    flat = posterior.chain.draws.reshape(-1, len(posterior.names)).copy()
    for j, name in enumerate(posterior.names):
        if name == "tau":
            flat[:, j] = np.log10(flat[:, j])
        if not np.ptp(flat[:, j]) > 0:
            raise InputError(f"corner of {subject.title}: the draws of {name} don't differ")
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


def _caption(figure: Figure, subject: Subject, draws: int, *, overlaid: bool) -> None:
    """Write, in the empty corner, what the lines and contours are."""
    handles = [Line2D([], [], color=BLUE, linewidth=5, alpha=0.6, label=f"{draws} draws of emcee")]
    if overlaid:
        handles.append(Line2D([], [], color=VERMILLION, linewidth=1, label="closed form"))
    handles.append(
        Line2D([], [], color=BLUE, linestyle="--", linewidth=1, label=typeset("2.5%, 50%, 97.5%"))
    )
    inner, outer = (typeset(f"{100 * level:.1f}%") for level in LEVELS)
    figure.legend(
        handles=handles,
        loc="upper right",
        bbox_to_anchor=(0.995, 0.985),
        alignment="left",
        title=f"{subject.title}\ncontours: {inner} and {outer} of the\nprobability (1 and 2 sigma "
        "in two\ndimensions)",
        title_fontsize=8.5,
    )


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
