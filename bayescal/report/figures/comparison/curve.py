"""The fitted curve less its straight part: what the higher orders do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.inference.posterior import INTERVAL_PROBABILITY
from bayescal.polynomials.basis import legendre_design
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.residual_points import ResidualPoints
from bayescal.report.figures.style import (
    BLACK,
    BLUE,
    CYCLE,
    GREY,
    MANY_POINTS,
    SKY,
    WIDTH,
    legend_of,
    one_panel,
    settle,
)
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset
from bayescal.rounding import significant

PLACES = 81


@dataclass(frozen=True, eq=False)
class Curve:
    """Posterior of a fitted curve over its domain, less its straight part.

    Attributes
    ----------
    x : Array
        Regressor, ``(n_places,)``.
    mean, lower, upper : Array
        Posterior mean and central 95 % interval of the curve (without noise), less the
        line, ``(n_places,)``, px.
    line : Array
        Level in the middle of the domain and rise over half of it, ``(2,)``, px: the
        posterior means of b_0 and b_1.
    """

    x: Array
    mean: Array
    lower: Array
    upper: Array
    line: Array

    @classmethod
    def of(cls, subject: Subject) -> Curve:
        """Evaluate the curve of an order."""
        domain = subject.axis.data.domain
        s = np.linspace(-1, 1, PLACES)
        x = domain.middle + domain.half_range * s
        design = legendre_design(s, subject.result.order)
        tails = np.array([(1 - INTERVAL_PROBABILITY) / 2, (1 + INTERVAL_PROBABILITY) / 2])
        draws, exact = subject.amplitude_draws, subject.exact
        amplitudes = exact.mean if exact is not None else draws.mean(axis=0)
        # Of the draws: the closed form's quantiles take a hundred times longer, and 4000
        # draws place the ends of an interval to 2 % of its half-width.
        lower, upper = np.quantile(draws @ design.T, tails, axis=0)
        line = amplitudes[:2]
        straight = legendre_design(s, 1) @ line
        mean = design @ amplitudes
        return cls(x, mean - straight, lower - straight, upper - straight, line)

    def less_line(self, s: Array, values: Array) -> Array:
        """Take the line off values at scaled places `s`, ``(n_places,)``."""
        return np.asarray(values - legendre_design(s, 1) @ self.line)


def draw(subject: Subject) -> Figure:
    """Draw curve, band and data, and thinly the curves of other plausible orders."""
    axis, curve = subject.axis, Curve.of(subject)
    data, found = axis.data, ResidualPoints.of(axis, subject.result)
    left = curve.less_line(data.domain.scale(data.x), data.t)
    figure, panel = one_panel(WIDTH, 3.7)
    panel.axhline(0, color=GREY, linewidth=0.8)
    label = typeset(f"{100 * INTERVAL_PROBABILITY:.0f}% of the curve")
    panel.fill_between(
        curve.x, curve.lower, curve.upper, color=SKY, alpha=0.4, linewidth=0, label=label
    )
    panel.plot(
        curve.x, curve.mean, color=BLUE, linewidth=1.8, label=f"order {subject.result.order}"
    )
    for order in sorted(axis.verdict.plausible):
        if order != subject.result.order:
            other = Curve.of(Subject(subject.comparison, data.axis, order))
            s = data.domain.scale(other.x)
            mean = other.mean + legendre_design(s, 1) @ (other.line - curve.line)
            colour = CYCLE[(order - 1) % len(CYCLE)]
            panel.plot(
                curve.x, mean, color=colour, linewidth=1, linestyle="--", label=f"order {order}"
            )
    if data.sd is not None:
        bars = panel.errorbar(data.x, left, data.sd, fmt="none", ecolor=GREY, elinewidth=0.7)
        bars[2][0].set_rasterized(len(left) > MANY_POINTS)
    many = len(left) > MANY_POINTS
    panel.plot(data.x, left, "o", color=BLACK, markersize=3.2, label="measured", rasterized=many)
    panel.set_xlabel(f"{data.regressor}{' [1]' if '/' in data.regressor else ''}")
    panel.set_ylabel(f"{data.axis} less the straight part [{subject.unit}]")
    panel.set_title(subject.title, loc="left")
    panel.margins(x=0.03, y=0.08)
    legend_of(panel, "lower center", 5)
    settle(figure)
    places = np.column_stack([curve.x, curve.mean])
    name_points(panel, data.x, left, found.named, curve=places, lines=[0.0], names=found.names)
    return figure


def alt_text(subject: Subject) -> str:
    """Say how far the curve bends and how well it is known."""
    curve, unit = Curve.of(subject), subject.unit
    worst = int(np.abs(curve.mean).argmax())
    half = (curve.upper - curve.lower) / 2
    bend = (
        f"it goes from {curve.mean.min():.3g} to {curve.mean.max():.3g} {unit}, furthest at "
        f"{curve.x[worst]:.3g}"
        if subject.result.order > 1
        else "it is straight"
    )
    return (
        f"Fitted curve less its straight part, {subject.title}, with the measured points: {bend}; "
        f"half of its {100 * INTERVAL_PROBABILITY:.0f}% band is "
        f"{significant(float(half.min()))} {unit} where narrowest and "
        f"{significant(float(half.max()))} {unit} where widest."
    )
