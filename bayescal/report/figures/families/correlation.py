"""Correlation of a joint model's parameters, as a table of colours."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.errors import InputError
from bayescal.report.figures.comparison.joint import LINES
from bayescal.report.figures.parameters import parameter_symbol
from bayescal.report.figures.style import BLUE, VERMILLION, WIDTH, ink_on, one_panel
from bayescal.report.numbers import correlations
from bayescal.report.views.families.words import weak_words

DIVERGING = LinearSegmentedColormap.from_list("correlation", [VERMILLION, "#ffffff", BLUE])
CELL = 0.42  # inches, at most
WRITTEN = 16  # parameters up to which the numbers find room
STRONG = 0.5  # correlations that the description names
NAMED = 6


def draw(found: FamilyComparison) -> Figure:
    """Draw the lower half of the matrix, with its numbers where they find room."""
    model = best_sampled(found)
    assert model.posterior is not None, "it was sampled"
    matrix, names = correlations(model.posterior), model.posterior.names
    size = len(names) - 1
    cell = min(CELL, (WIDTH - 1.6) / size)
    figure, panel = one_panel(max(3.2, cell * size + 1.6), max(2.2, cell * size + 1.3))
    lower = np.where(np.tri(size, dtype=bool), matrix[1:, :-1], np.nan)
    edges = np.arange(size + 1) - 0.5
    mesh = panel.pcolor(
        edges,
        edges,
        lower,
        cmap=DIVERGING,
        vmin=-1,
        vmax=1,
        edgecolors=LINES,
        linewidth=0.5 if size <= 40 else 0.0,
    )
    if size < WRITTEN:
        for i in range(size):
            for j in range(i + 1):
                value = float(lower[i, j])
                text = f"{round(value, 2) + 0.0:.2f}".replace("-", "\N{MINUS SIGN}")
                ink = ink_on(DIVERGING((1 + value) / 2))
                panel.text(j, i, text, ha="center", va="center", fontsize=7, color=ink)
    panel.set_xticks(range(size), [_label(name) for name in names[:-1]], rotation=90)
    panel.set_yticks(range(size), [_label(name) for name in names[1:]])
    panel.invert_yaxis()  # as a table reads
    panel.set_aspect("equal")
    panel.tick_params(length=0, labelsize=8.5 if size < 30 else 5)
    for spine in panel.spines.values():
        spine.set_visible(False)
    panel.set_title(f"correlation, {model.key}", loc="left")
    figure.colorbar(mesh, ax=panel, fraction=0.035, pad=0.01, label="correlation [1]")
    return figure


def best_sampled(found: FamilyComparison) -> JointModel:
    """Give the most probable model that was sampled.

    Raises
    ------
    InputError
        Where none was.
    """
    for model in found.models:
        if model.posterior is not None:
            return model
    raise InputError("no model was sampled: all have a closed form")


def _label(name: str) -> str:
    stem, _, index = name.partition("_")
    if stem in ("sigma", "tau", "nu", "alpha", "beta") and not index.isdigit():
        return f"{parameter_symbol(stem)} {index.replace('_', ' ')}".rstrip()
    return parameter_symbol(name)


def alt_text(found: FamilyComparison) -> str:
    """Name the strongest correlations, and what is weakly identified."""
    model = best_sampled(found)
    assert model.posterior is not None, "it was sampled"
    matrix, names = correlations(model.posterior), model.posterior.names
    i, j = np.tril_indices(len(names), -1)
    order = np.argsort(-np.abs(matrix[i, j]), kind="stable")[:NAMED]
    strong = [k for k in order.tolist() if abs(matrix[i[k], j[k]]) >= STRONG]
    said = ", ".join(f"{names[j[k]]} and {names[i[k]]} {matrix[i[k], j[k]]:+.2f}" for k in strong)
    strongest = f"The strongest: {said}." if said else f"None is beyond {STRONG:g}."
    weak = " ".join(f"{line[0].upper()}{line[1:]}" for line in weak_words(model.posterior))
    return (
        f"Table of the correlations of the {len(names)} parameters of {model.key}. {strongest} "
        f"{weak}"
    ).rstrip()
