"""Whether the residuals are normal: their quantiles against the normal's."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.special import betaincinv, ndtri

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.normality import FEWEST_DOF
from bayescal.errors import InputError
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.residual_points import ResidualPoints
from bayescal.report.figures.style import BLUE, GREY, PALE, WIDTH, settle
from bayescal.report.figures.subject import Subject

ENVELOPE = 0.95


def draw(subject: Subject) -> Figure:
    """Draw studentised residuals by rank, with the envelope of each rank."""
    found = ResidualPoints.of(subject.axis, subject.result)
    ranked, expected, lower, upper = _quantiles(subject, found)
    z = found.problem.studentised[ranked]
    figure = Figure(figsize=(0.62 * WIDTH, 0.62 * WIDTH), layout="constrained")
    panel = figure.subplots()
    label = f"{100 * ENVELOPE:.0f} % envelope of each rank"
    panel.fill_between(expected, lower, upper, color=PALE, alpha=0.6, linewidth=0, label=label)
    panel.plot(expected, expected, color=GREY, linewidth=0.9, label="normal")
    panel.plot(expected, z, "o", color=BLUE, markersize=3.8, label="point")
    panel.set_xlabel("normal quantile [1]")
    panel.set_ylabel(f"studentised residual of {subject.axis.data.axis} [1]")
    panel.set_title(subject.title, loc="left")
    panel.margins(0.06)
    figure.legend(loc="outside lower center", ncols=3)
    settle(figure)
    place = {int(i): rank for rank, i in enumerate(found.problem.usable[ranked])}
    names = [found.names[i] for i in place]
    named = [place[i] for i in found.named]
    name_points(panel, expected, z, named, curve=np.column_stack([expected] * 2), names=names)
    return figure


def _quantiles(subject: Subject, found: ResidualPoints) -> tuple[IntArray, Array, Array, Array]:
    """Ranking of the points, and the normal quantiles of their ranks.

    The i-th smallest of n uniform numbers is Beta(i, n + 1 - i); its median and central
    interval are carried to the normal. Residuals are nearly independent.
    """
    problem = found.problem
    if problem.unusable is not None:
        raise InputError(f"qq of {subject.title}: {problem.unusable}")
    if problem.fit.dof < FEWEST_DOF:
        raise InputError(f"qq of {subject.title}: {problem.fit.dof} degrees of freedom are too few")
    z = problem.studentised
    ranked = np.argsort(z, kind="stable")
    i = np.arange(1.0, len(z) + 1)
    tail = (1 - ENVELOPE) / 2
    expected, lower, upper = (_normal(i, len(z) + 1 - i, p) for p in (0.5, tail, 1 - tail))
    return ranked, expected, lower, upper


def _normal(a: Array, b: Array, probability: float) -> Array:
    """Carry quantiles of beta distributions to the normal's."""
    return np.asarray(ndtri(betaincinv(a, b, probability)), dtype=float)


def outside(subject: Subject) -> tuple[int, int]:
    """Count the points outside their rank's envelope, and all."""
    found = ResidualPoints.of(subject.axis, subject.result)
    ranked, _, lower, upper = _quantiles(subject, found)
    z = found.problem.studentised[ranked]
    return int(((z < lower) | (z > upper)).sum()), len(z)


def alt_text(subject: Subject) -> str:
    """Say how many points leave the envelope, and the extremes."""
    found = ResidualPoints.of(subject.axis, subject.result)
    left, n = outside(subject)
    z = found.problem.studentised
    return (
        f"Normal quantiles of the studentised residuals, {subject.title}: {left} of {n} points "
        f"outside their rank's {100 * ENVELOPE:.0f} % envelope; from {z.min():.2f} to "
        f"{z.max():.2f}. {found.outstanding(subject.unit)}"
    )
