"""Whether the residuals are normal: their quantiles against the normal's."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.special import betaincinv, ndtri

from bayescal.arrays import Array, IntArray
from bayescal.comparison.adequacy.normality import FEWEST_DOF
from bayescal.comparison.adequacy.problem import Problem
from bayescal.errors import InputError
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.residual_points import ResidualPoints
from bayescal.report.figures.style import BLUE, GREY, PALE, WIDTH, legend_of, one_panel, settle
from bayescal.report.figures.subject import Subject
from bayescal.report.typography import typeset

ENVELOPE = 0.95
SIMULATIONS = 4000  # for the bounds, and as many for their level
CHUNK = 2_000_000  # simulated numbers held at once
MANY = 1000  # ranks drawn at most, nearly


def draw(subject: Subject) -> Figure:
    """Draw studentised residuals by rank, with the envelope of each rank."""
    found = ResidualPoints.of(subject.axis, subject.result)
    ranked, expected, z, lower, upper = _ranked(subject, found)
    figure, panel = one_panel(0.62 * WIDTH, 0.62 * WIDTH)
    label = typeset(f"{100 * ENVELOPE:.0f}% envelope")
    panel.fill_between(expected, lower, upper, color=PALE, alpha=0.6, linewidth=0, label=label)
    panel.plot(expected, expected, color=GREY, linewidth=0.9, label="normal")
    panel.plot(expected, z, "o", color=BLUE, markersize=3.8, label="point")
    panel.set_xlabel("normal quantile [1]")
    panel.set_ylabel(f"studentised residual of {subject.axis.data.axis} [1]")
    panel.set_title(subject.title, loc="left")
    panel.margins(0.06)
    legend_of(panel, "lower center", 3)
    settle(figure)
    place = {int(i): rank for rank, i in enumerate(found.problem.usable[ranked])}
    names = [found.names[i] for i in place]
    named = [place[i] for i in found.named if i in place]
    name_points(panel, expected, z, named, curve=np.column_stack([expected] * 2), names=names)
    return figure


def envelope(problem: Problem, kept: IntArray, rng: np.random.Generator) -> tuple[Array, Array]:
    """Bounds that ordered residuals of normal errors leave anywhere with probability 0.05.

    Normal errors go through the same fit and are studentised alike: a fit takes away so
    much of the spread of ordered numbers that the bounds of independent ones would hold
    nearly everything. The level of each rank is the one at which 95 % of the simulated
    sets stay wholly inside (Davison & Hinkley 1997, Bootstrap Methods, 4.2.4).

    Parameters
    ----------
    kept : IntArray
        Ranks wanted, from 0, ``(n_kept,)``.

    Returns
    -------
    lower, upper : Array
        ``(n_kept,)``.
    """
    # Bounds from one half of the sets, their level from the other: of the same half they
    # would hold too much.
    ordered = np.sort(_simulated(problem, kept, rng), axis=0)
    others = _simulated(problem, kept, rng)
    below = np.array([np.searchsorted(o, s) for o, s in zip(ordered.T, others.T, strict=True)])
    extreme = np.minimum(below - 1, SIMULATIONS - 1 - below).min(axis=0)
    level = max(0, int(np.sort(extreme)[int((1 - ENVELOPE) * SIMULATIONS)]))
    return ordered[level], ordered[SIMULATIONS - 1 - level]


def _simulated(problem: Problem, kept: IntArray, rng: np.random.Generator) -> Array:
    """Ordered studentised residuals of normal errors, ``(SIMULATIONS, n_kept)``."""
    free = np.sqrt(problem.free[problem.usable])
    n, q = problem.n, problem.q
    sets = np.empty((SIMULATIONS, len(kept)))
    step = max(1, CHUNK // n)
    for start in range(0, SIMULATIONS, step):
        e = rng.standard_normal((min(step, SIMULATIONS - start), n))
        e -= (e @ q) @ q.T
        sigma = np.sqrt((e**2).sum(axis=1) / problem.dof)
        z = e[:, problem.usable] / (sigma[:, None] * free)
        sets[start : start + len(e)] = np.sort(z, axis=1)[:, kept]
    return sets


def _shown(n: int) -> IntArray:
    """Ranks to draw of n: all, or of very many the outermost and some between."""
    between = np.linspace(0, n - 1, MANY).astype(int)
    ends = np.arange(MANY // 10)
    return np.arange(n) if n <= MANY else np.unique([*between, *ends, *(n - 1 - ends)])


def _ranked(subject: Subject, found: ResidualPoints) -> tuple[IntArray, Array, Array, Array, Array]:
    """Points in order of their residual, normal medians, residuals and their envelope.

    Raises
    ------
    InputError
        Where the residuals say nothing.
    """
    problem = found.problem
    if problem.unusable is not None:
        raise InputError(f"qq of {subject.title}: {problem.unusable}")
    if problem.dof < FEWEST_DOF:
        raise InputError(f"qq of {subject.title}: {problem.dof} degrees of freedom are too few")
    n = len(problem.usable)
    kept = _shown(n)
    ranked = np.argsort(problem.studentised, kind="stable")[kept]
    expected = np.asarray(ndtri(betaincinv(kept + 1.0, n - kept, 0.5)), dtype=float)
    rng = np.random.default_rng(subject.comparison.seed)
    return ranked, expected, problem.studentised[ranked], *envelope(problem, kept, rng)


def alt_text(subject: Subject) -> str:
    """Say how many points leave the envelope, and the extremes."""
    found = ResidualPoints.of(subject.axis, subject.result)
    _, _, z, lower, upper = _ranked(subject, found)
    left = int(((z < lower) | (z > upper)).sum())
    return (
        f"Normal quantiles of the studentised residuals, {subject.title}: {left} of {len(z)} "
        f"points outside the envelope that normal errors leave anywhere with probability "
        f"{1 - ENVELOPE:.2f}; from {z[0]:.2f} to {z[-1]:.2f}. {found.outstanding(subject.unit)}"
    )
