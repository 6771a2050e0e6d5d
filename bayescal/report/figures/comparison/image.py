"""Residuals where they lie in the image, as arrows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.quiver import Quiver
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.report.figures.labels import name_points
from bayescal.report.figures.residual_points import ResidualPoints
from bayescal.report.figures.style import (
    BLUE,
    GREY,
    MANY_POINTS,
    VERMILLION,
    WIDTH,
    one_panel,
    settle,
)
from bayescal.report.figures.subject import Subject

# Lengths of arrows as fractions of the panel's width: of a long one (the 90 % quantile),
# unless the longest would then be longer than it may be.
LONG, LONGEST = 0.1, 0.3


@dataclass(frozen=True, eq=False)
class Arrows:
    """Residuals of one axis or of both.

    Attributes
    ----------
    residuals : Array
        In r and c, 0 along an axis not drawn, ``(n_points, 2)``, px.
    parts : dict of str to ResidualPoints
        By axis.
    orders : dict of str to int
        By axis.
    """

    points: Correspondences
    residuals: Array
    parts: dict[str, ResidualPoints]
    orders: dict[str, int]

    @classmethod
    def of(cls, subject: Subject) -> Arrows:
        """Collect the residuals of the axes to draw."""
        points = subject.comparison.points
        if points is None:
            raise InputError("image needs points of a camera: y is a function of x alone")
        residuals = np.zeros((len(points), 2))
        parts, orders = {}, {}
        for axis in subject.axes:
            name = axis.data.axis
            result = axis.chosen if subject.order is None else subject.result
            parts[name] = ResidualPoints.of(axis, result)
            residuals[:, "rc".index(name)] = parts[name].residuals
            orders[name] = result.order
        return cls(points, residuals, parts, orders)

    @property
    def lengths(self) -> Array:
        """Lengths, ``(n_points,)``, px."""
        return np.asarray(np.hypot(*self.residuals.T))

    @property
    def named(self) -> list[int]:
        """Points that stand out on an axis drawn, from 0, the worst first."""
        found = {i for part in self.parts.values() for i in part.named}
        return sorted(found, key=lambda i: (-self.lengths[i], i))

    @property
    def title(self) -> str:
        """What is drawn."""
        orders = ", ".join(f"{name} of order {order}" for name, order in self.orders.items())
        return f"residuals, {orders}"


def draw(subject: Subject) -> Figure:
    """Draw an arrow per point from where it is predicted towards where it was measured."""
    found = Arrows.of(subject)
    points = found.points
    pixels = np.column_stack([points.pixel(axis) for axis in "rc"])
    spans = image_spans(points, pixels)
    tall = float(np.clip(0.86 * WIDTH * spans[1] / spans[0], 2.2, 7.0)) + 0.9
    figure, panel = one_panel(WIDTH, tall)
    out = np.zeros(len(pixels), dtype=bool)
    out[found.named] = True
    quiver = draw_arrows(panel, points, pixels, found.residuals, out, arrow_scale(found.lengths))
    key = key_length(found.lengths)
    panel.quiverkey(quiver, 0.9, 1.03, key, f"{key:g} px", labelpos="W", color=GREY)
    panel.set_title(found.title, loc="left")
    settle(figure)
    names = next(iter(found.parts.values())).names
    name_points(panel, pixels[:, 0], pixels[:, 1], found.named, names=names)
    return figure


def image_spans(points: Correspondences, pixels: Array) -> tuple[float, float]:
    """Give width and height of the image, or of what the points cover of it, px."""
    sizes = [points.setup.size(axis) for axis in "rc"]
    width, height = (
        size if size is not None else float(np.ptp(pixels[:, i])) or 1.0
        for i, size in enumerate(sizes)
    )
    return width, height


def arrow_scale(lengths: Array) -> float:
    """Px of residual that an arrow as long as the panel is wide stands for."""
    return max(float(np.quantile(lengths, 0.9)) / LONG, float(lengths.max()) / LONGEST) or 1.0


def key_length(lengths: Array) -> float:
    """Length of the arrow that explains the others, px: one digit, like a long one."""
    return float(f"{float(np.quantile(lengths, 0.9)) or 1.0:.0e}")


def draw_arrows(
    panel: Axes,
    points: Correspondences,
    pixels: Array,
    residuals: Array,
    out: NDArray[np.bool_],
    scale: float,
) -> Quiver:
    """Draw the image's edge, the points and an arrow at each.

    Parameters
    ----------
    pixels, residuals : Array
        ``(n_points, 2)``, px.
    out : Array
        Which stand out, ``(n_points,)``.
    scale : float
        As of `arrow_scale`.
    """
    width, height = (points.setup.size(axis) for axis in "rc")
    if width is not None and height is not None:
        panel.add_patch(Rectangle((0, 0), width, height, fill=False, edgecolor=GREY, linewidth=0.8))
    many = len(pixels) > MANY_POINTS
    panel.plot(*pixels[~out].T, "o", color=BLUE, markersize=2.6, rasterized=many)
    panel.plot(*pixels[out].T, "D", color=VERMILLION, markersize=3)
    # Arrows are drawn in fractions of the panel's width, c upwards or downwards as it is.
    upwards = 1.0 if points.setup.c_from_bottom else -1.0
    quiver = panel.quiver(
        *pixels.T,
        residuals[:, 0],
        upwards * residuals[:, 1],
        color=np.where(out, VERMILLION, BLUE).tolist(),
        scale=scale,
        scale_units="width",
        angles="uv",
        width=0.0025,
        headwidth=4,
        headlength=5,
        minlength=0.5,
        rasterized=many,
    )
    _frame(panel, upwards)
    return quiver


def _frame(panel: Axes, upwards: float) -> None:
    """Lay the image out with pixels square."""
    panel.set_aspect("equal", adjustable="datalim")
    panel.autoscale_view()
    panel.margins(0.04)
    panel.set_xlabel("r [px]")
    panel.set_ylabel("c, from the bottom [px]" if upwards > 0 else "c [px]")
    if upwards < 0:
        panel.invert_yaxis()


def alt_text(subject: Subject) -> str:
    """Say how long the arrows are, and which points stand out."""
    found = Arrows.of(subject)
    worst = int(found.lengths.argmax())
    names = next(iter(found.parts.values())).names
    parts = " ".join(f"{name}: {part.outstanding('px')}" for name, part in found.parts.items())
    return (
        f"Arrows over the image, {found.title}: from predicted to measured, {len(names)} points, "
        f"root mean square {np.sqrt(np.mean(found.lengths**2)):.2f} px, the longest "
        f"{found.lengths[worst]:.3g} px at point {names[worst]}. {parts}"
    )
