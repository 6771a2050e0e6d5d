"""What is left over of every point in all views, where it lies in the image."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver

from bayescal.arrays import Array
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.comparison.image import arrow_scale, key_length
from bayescal.report.figures.lenses.image import image_panel
from bayescal.report.figures.style import BLUE, GREY, MANY_POINTS, VERMILLION, settle
from bayescal.rounding import counted

SHORTER = 3.0  # than arrows where there is one view of points


def draw(found: LensComparison) -> Figure:
    """Draw an arrow per point, from where it is predicted towards where it was measured."""
    pixels, left = leftovers(found)
    lengths = np.hypot(*left.T)
    figure, panel = image_panel(found)
    scale = SHORTER * arrow_scale(lengths) / found.setting.data.size[0]
    quiver = draw_vectors(panel, pixels, left, scale, width=0.0015)
    draw_bad(panel, found)
    key = key_length(lengths)
    panel.quiverkey(quiver, 0.9, 1.03, key, f"{key:g} px", labelpos="W", color=GREY)
    panel.set_title(f"{found.best.name}, all views", loc="left")
    settle(figure)
    return figure


def leftovers(found: LensComparison, view: int | None = None) -> tuple[Array, Array]:
    """Give pixels and what is left over there, of all views or one, ``(n, 2)`` each, px."""
    data, noise = found.setting.data, found.problem.noise
    if view is None:
        return data.pixels[data.seen], noise[data.seen]
    seen = data.seen[view]
    return data.pixels[view, seen], noise[view, seen]


def draw_vectors(panel: Axes, pixels: Array, left: Array, scale: float, *, width: float) -> Quiver:
    """Draw arrows; `scale` is px of residual by px of the image, `width` a share of the panel's."""
    return panel.quiver(
        *pixels.T, *left.T, angles="xy", scale_units="xy", scale=scale, width=width,
        color=BLUE, rasterized=len(pixels) > MANY_POINTS,
    )  # fmt: skip


def draw_bad(panel: Axes, found: LensComparison, view: int | None = None) -> None:
    """Cross the points that are taken for bad, of all views or one, where they were measured."""
    gone = () if found.bad is None else found.bad.left_out
    name = None if view is None else found.views.names[view]
    rows = [point.point for point in gone if name in (None, point.view)]
    pixels = found.views.pixels[rows]
    panel.plot(*pixels.T, "x", color=VERMILLION, markersize=4, markeredgewidth=0.8)


def alt_text(found: LensComparison) -> str:
    """Say how long they are."""
    lengths = np.hypot(*leftovers(found)[1].T)
    return (
        f"Residuals of {len(lengths)} points in {len(found.views)} views as arrows over the image, "
        f"root mean square {np.sqrt((lengths**2).mean()):.3f} px, the longest "
        f"{lengths.max():.2f} px.{bad_words(found)}"
    )


def bad_words(found: LensComparison) -> str:
    """Say how many points are crossed, with a space before it; empty where there are none."""
    gone = () if found.bad is None else found.bad.left_out
    return f" Crosses: {counted(len(gone), 'point')} taken for bad." if gone else ""
