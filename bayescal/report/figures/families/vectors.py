"""Residuals of joint models where they lie in the image: the best beside another position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.report.figures.comparison.image import (
    arrow_scale,
    draw_arrows,
    image_spans,
    key_length,
)
from bayescal.report.figures.labels import name_points, printable_names
from bayescal.report.figures.style import GREY, WIDTH, settle, several_panels

NAMED = 5  # points named in each panel


@dataclass(frozen=True, eq=False)
class _Panel:
    """A model, its residuals ``(n_points, 2)`` in px, and the points with the longest."""

    model: JointModel
    residuals: Array

    @property
    def lengths(self) -> Array:
        return np.asarray(np.hypot(*self.residuals.T))

    @property
    def longest(self) -> list[int]:
        return [int(i) for i in np.argsort(-self.lengths, kind="stable")[:NAMED]]

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.lengths**2)))


def draw(found: FamilyComparison) -> Figure:
    """Draw an arrow per point from where it is predicted towards where it was measured."""
    panels, points = _panels(found), found.points
    pixels = np.column_stack([points.pixel(axis) for axis in "rc"])
    spans = image_spans(points, pixels)
    wide = (WIDTH - 0.7) / len(panels)
    tall = float(np.clip(wide * spans[1] / spans[0], 1.6, 6.5)) + 1.1
    figure = several_panels(WIDTH, tall)
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    scale = arrow_scale(np.concatenate([p.lengths for p in panels]))
    quivers = []
    for ax, panel in zip(axes, panels, strict=True):
        out = np.zeros(len(pixels), dtype=bool)
        out[panel.longest] = True
        quivers.append(draw_arrows(ax, points, pixels, panel.residuals, out, scale))
        ax.set_title(f"{panel.model.key}\nroot mean square {panel.rms:.2f} px", loc="left")
    for ax in axes[1:]:
        ax.set_ylabel("")
    key = key_length(np.concatenate([p.lengths for p in panels]))
    axes[-1].quiverkey(quivers[-1], 0.9, 1.05, key, f"{key:g} px", labelpos="W", color=GREY)
    settle(figure)
    names = printable_names(points.labels)
    for ax, panel in zip(axes, panels, strict=True):
        name_points(ax, pixels[:, 0], pixels[:, 1], panel.longest, names=names)
    return figure


def _panels(found: FamilyComparison) -> list[_Panel]:
    """Give the best model, then the best under the other treatment of the position."""
    chosen = [found.best]
    chosen += [m for m in found.models if m.key.position != found.best.key.position][:1]
    return [_Panel(m, m.residuals.T) for m in chosen]


def alt_text(found: FamilyComparison) -> str:
    """Say how long the arrows are, and which are the longest."""
    names, parts = printable_names(found.points.labels), []
    for panel in _panels(found):
        longest = ", ".join(f"{names[i]} ({panel.lengths[i]:.3g} px)" for i in panel.longest)
        parts.append(
            f"{panel.model.key}: root mean square {panel.rms:.2f} px, the longest at points "
            f"{longest}."
        )
    return f"Residuals over the image as arrows, from predicted to measured. {' '.join(parts)}"
