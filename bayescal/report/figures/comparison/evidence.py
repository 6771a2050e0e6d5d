"""Log evidence of every order were tau, the strength of the non-linearity, fixed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bayescal.comparison.defence.sensitivity import TauSensitivity, tau_sensitivity
from bayescal.comparison.results import AxisComparison
from bayescal.errors import InputError
from bayescal.report.figures.style import (
    BLUE,
    CYCLE,
    DASHES,
    GREY,
    PALE,
    WIDTH,
    ink_on,
    one_panel,
    several_panels,
)
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset
from bayescal.rounding import percent, significant

ROOM = 8.0  # nat shown below the winner's lowest


def draw(subject: Subject) -> Figure:
    """Draw a curve per order, relative to the best of all, over a strip of who wins."""
    axis = _with_evidence(subject)
    if not axis.prior.scaled:
        return _without_tau(axis)
    found = _sensitivity(axis)
    figure = several_panels(WIDTH, 4.0)
    panel, strip = figure.subplots(2, 1, sharex=True, height_ratios=[1, 0.07])
    relative = found.log_evidence - found.log_evidence.max()
    floor = float(relative.max(axis=0).min()) - ROOM
    for (order, colour, dash), row in zip(_looks(found.orders), relative, strict=True):
        best = float(row.max())
        label = f"order {order}" + (f" (at most {best:.0f})" if best < floor else "")
        width = 2.2 if order == axis.verdict.order else 1.2
        panel.plot(found.tau, row, color=colour, linestyle=dash, linewidth=width, label=label)
    _mark_tau(panel, axis)
    panel.set_ylim(floor, 0.04 * (0.5 - floor) + 0.3)
    panel.set_ylabel("ln evidence less the highest [nat]")
    panel.set_title(f"{axis.data.axis}({axis.data.regressor}): evidence at a fixed tau", loc="left")
    _draw_wins(strip, found)
    strip.set_xscale("log")
    strip.set_xlim(found.tau[0], found.tau[-1])
    size = f"{axis.data.size:.4g} {subject.unit}"
    strip.set_xlabel(f"tau: prior sd of every order from 2 on, as a fraction of {size}")
    figure.legend(loc="outside right upper", ncols=1 + len(found.orders) // 16)
    return figure


def _with_evidence(subject: Subject) -> AxisComparison:
    if not subject.axis.prior.proper:
        raise InputError("evidence is unavailable under a flat prior")
    return subject.axis


def _sensitivity(axis: AxisComparison) -> TauSensitivity:
    models = {
        r.order: r.posterior.exact.model for r in axis.orders if r.posterior.exact is not None
    }
    if len(models) < len(axis.orders):
        raise InputError("evidence over fixed tau is available only for models with a closed form")
    return tau_sensitivity(models)


def _looks(orders: tuple[int, ...]) -> Iterator[tuple[int, str, str]]:
    """Give every order a colour and dashes of its own."""
    for order in orders:
        yield order, CYCLE[(order - 1) % len(CYCLE)], DASHES[(order - 1) // len(CYCLE)]


def _mark_tau(panel: Axes, axis: AxisComparison) -> None:
    if axis.prior.tau is not None:
        label = f"tau as fixed, {axis.prior.tau:g}"
        panel.axvline(axis.prior.tau, color=GREY, linewidth=1, label=label)
    else:
        lower, upper = axis.prior.tau_bounds
        label = "prior of an\ninferred tau,\n" + typeset(f"{lower:.2g} to {upper:g}")
        panel.axvspan(lower, upper, color=PALE, alpha=0.35, linewidth=0, label=label)


def _draw_wins(strip: Axes, found: TauSensitivity) -> None:
    colours = {order: colour for order, colour, _ in _looks(found.orders)}
    decades = np.log10(found.tau[-1] / found.tau[0])
    for win in found.wins:
        strip.axvspan(win.lower, win.upper, color=colours[win.order], linewidth=0)
        if np.log10(win.upper / win.lower) > 0.03 * decades:
            middle = np.sqrt(win.lower * win.upper)
            colour, name = ink_on(colours[win.order]), str(win.order)
            strip.text(middle, 0.5, name, ha="center", va="center", color=colour, weight="bold")
    strip.set_yticks([0.5], ["wins: order"])
    strip.set_ylim(0, 1)
    strip.tick_params(axis="y", length=0)
    strip.spines["left"].set_visible(False)


def _without_tau(axis: AxisComparison) -> Figure:
    """Draw the one log evidence that each order has under a stated prior."""
    values = _evidences(axis)
    figure, panel = one_panel(WIDTH, 3.2)
    panel.axhline(0, color=GREY, linewidth=0.8)
    panel.plot(list(values), list(values.values()), "o", color=BLUE, markersize=6)
    panel.set_xticks(list(values))
    panel.set_xlabel(f"order of {axis.data.axis}({axis.data.regressor})")
    panel.set_ylabel("ln evidence less the highest [nat]")
    panel.set_title(f"{axis.data.axis}: evidence under the {axis.prior.name} prior", loc="left")
    panel.margins(y=0.15)
    return figure


def _evidences(axis: AxisComparison) -> dict[int, float]:
    """Log evidence of each order less the highest, nat."""
    known = {r.order: r.log_evidence for r in axis.orders if r.log_evidence is not None}
    highest = max(known.values())
    return {order: value - highest for order, value in known.items()}


def alt_text(subject: Subject) -> str:
    """Say which order wins at which tau."""
    axis = _with_evidence(subject)
    if not axis.prior.scaled:
        values = ", ".join(f"order {k} {value:.1f}" for k, value in _evidences(axis).items())
        return f"Log evidence of {axis.data.axis} less the highest, nat: {values}."
    wins = ", ".join(
        f"order {w.order} wins from {significant(w.lower)} to {significant(w.upper)}"
        for w in _sensitivity(axis).wins
    )
    chances = ", ".join(
        f"order {r.order} {percent(r.probability)}"
        for r in axis.orders
        if r.probability is not None
    )
    how = "averaged over" if axis.prior.tau is None else f"fixed at {axis.prior.tau:g}"
    return (
        f"Log evidence of each order of {axis.data.axis} over tau: {wins}. With tau {how}, the "
        f"probabilities are {chances}."
    )
