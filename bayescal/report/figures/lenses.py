"""Pictures of lens models over many views: evidence, what is left over, how sure the lens is."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.lenses.places import between
from bayescal.comparison.lenses.prediction import (
    View,
    deviation,
    image_grid,
    observed_sample,
    response,
)
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.comparison.image import arrow_scale, key_length
from bayescal.report.figures.style import BLUE, COLOURS, GREY, PALE, VERMILLION, WIDTH, settle

FAR = 300.0  # nat: lenses further below the best are not drawn
COLUMNS, ROWS = 33, 25
SHORTER = 3.0  # than arrows where there is one view of points
LEVELS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


def draw_evidence(found: LensComparison) -> Figure:
    """Draw a bar for every lens within reach, below the best one."""
    lenses = [j for j in found.lenses if _below(found, j.evidence.log_evidence) < FAR]
    below = [_below(found, j.evidence.log_evidence) for j in lenses]
    figure = Figure(figsize=(WIDTH, 0.9 + 0.27 * len(lenses)), layout="constrained")
    panel = figure.subplots()
    colours = [BLUE if j.key in found.verdict.plausible else PALE for j in lenses]
    panel.barh(range(len(lenses)), [b + 0.02 for b in below], color=colours, height=0.7)
    panel.set_yticks(range(len(lenses)), [j.key for j in lenses])
    panel.invert_yaxis()
    panel.set_xscale("symlog", linthresh=1, linscale=0.6)
    panel.set_xlim(0, max([*below, 10]) * 1.2)
    panel.axvline(math.log(20), color=VERMILLION, linewidth=1, linestyle="--")
    panel.set_xlabel("ln evidence below the best [nat]; dashed: odds of 20 to 1")
    settle(figure)
    return figure


def evidence_text(found: LensComparison) -> str:
    """Say how far below the best the next lenses are."""
    rest = ", ".join(
        f"{j.key} {_below(found, j.evidence.log_evidence):.1f}" for j in found.lenses[1:5]
    )
    return f"Log evidence below that of {found.best.key}, nat: {rest or 'no other lens'}."


def _below(found: LensComparison, log_evidence: float) -> float:
    return found.best.evidence.log_evidence - log_evidence


def draw_vectors(found: LensComparison) -> Figure:
    """Draw what is left over of every point in all views, where it lies in the image."""
    problem, data = found.best.evidence.problem, found.setting.data
    pixels, noise = data.pixels[data.seen], problem.noise[data.seen]
    lengths = np.hypot(*noise.T)
    figure, panel = _image(found)
    scale = SHORTER * arrow_scale(lengths) / data.size[0]
    quiver = panel.quiver(
        *pixels.T, *noise.T, angles="xy", scale_units="xy", scale=scale, width=0.0015,
        color=BLUE, rasterized=len(pixels) > 2000,
    )  # fmt: skip
    key = key_length(lengths)
    panel.quiverkey(quiver, 0.9, 1.03, key, f"{key:g} px", labelpos="W", color=GREY)
    settle(figure)
    return figure


def vectors_text(found: LensComparison) -> str:
    """Say how long they are."""
    noise = found.best.evidence.problem.noise[found.setting.data.seen]
    lengths = np.hypot(*noise.T)
    return (
        f"Residuals of {len(lengths)} points in {len(found.views)} views as arrows over the image, "
        f"root mean square {np.sqrt((lengths**2).mean()):.3f} px, the longest "
        f"{lengths.max():.2f} px."
    )


def uncertainty(found: LensComparison) -> tuple[Array, Array]:
    """Pixels of a grid, ``(n, 2)``, and the projection's deviation there at infinity, px."""
    problem, data = found.best.evidence.problem, found.setting.data
    view, sample = View(problem.model, problem.x), observed_sample(data)
    grid = image_grid(data.size, COLUMNS, ROWS)
    own = deviation(response(view, grid, sample, None), np.cov(found.draws.T))
    return grid, np.hypot(own, between(view, found.lenses, grid, sample, None))


def draw_uncertainty(found: LensComparison) -> Figure:
    """Draw contours of the projection's deviation over the image, the points beneath."""
    grid, sd = uncertainty(found)
    figure, panel = _image(found)
    data = found.setting.data
    panel.plot(*data.pixels[data.seen].T, ".", color=PALE, markersize=2, rasterized=True)
    known = sd[np.isfinite(sd)]
    levels = [v for v in LEVELS if known.min() < v < known.max()] or [float(np.median(known))]
    r, c = (values.reshape(ROWS, COLUMNS) for values in grid.T)
    shown = np.ma.masked_invalid(sd.reshape(ROWS, COLUMNS))
    lines = panel.contour(r, c, shown, levels=levels, cmap=COLOURS, linewidths=1.5)
    panel.clabel(lines, fmt=lambda v: f"{v:g} px", fontsize=7)
    settle(figure)
    return figure


def uncertainty_text(found: LensComparison) -> str:
    """Say how large it is at the centre and at the worst."""
    _, sd = uncertainty(found)
    known = sd[np.isfinite(sd)]
    return (
        "Contours of the standard deviation of the projection over the image, px: from "
        f"{known.min():.2g} to {known.max():.2g}."
    )


def _image(found: LensComparison) -> tuple[Figure, Axes]:
    width, height = found.setting.data.size
    figure = Figure(figsize=(WIDTH, WIDTH * height / width * 0.95 + 0.4), layout="constrained")
    panel = figure.subplots()
    panel.set_xlim(-0.5, width - 0.5)
    panel.set_ylim(height - 0.5, -0.5)
    panel.set_aspect("equal")
    panel.set_xlabel("r [px]")
    panel.set_ylabel("c [px]")
    return figure, panel
