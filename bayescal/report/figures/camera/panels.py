"""What maps over the image share: panels of its shape, contours, hatching, the hull."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox
from scipy.interpolate import RegularGridInterpolator

from bayescal.arrays import Array
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.sights import Sights
from bayescal.report.figures.style import (
    BLACK,
    BLUE,
    COLOURS,
    GREY,
    VERMILLION,
    WIDTH,
    settle,
    several_panels,
)

STEPS, FINE_STEPS = (
    np.array([v * 10.0**k for k in range(-6, 6) for v in digits])
    for digits in ((1, 2, 5), (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8))
)
FEWEST_LEVELS, MOST_LEVELS = 3, 7
APART = 2.0  # between labels, px of the screen
FINER = 6  # places between two of the grid
LONG = 0.09  # of the image's width: the longest arrow
SPARE = 0.75  # inches, above and below the panels


class Mapped(Protocol):
    """Places over the image, row by row, and which of them are trusted."""

    @property
    def places(self) -> Sights: ...  # noqa: D102
    @property
    def shape(self) -> tuple[int, int]: ...  # noqa: D102
    @property
    def extrapolated(self) -> BoolArray: ...  # noqa: D102
    @property
    def hull(self) -> Array: ...  # noqa: D102


def image_panels(maps: Mapped, number: int) -> tuple[Figure, list[Axes]]:
    """Make panels with the image's shape, two beside each other, and the legend of all."""
    low, high = maps.places.pixels.min(axis=0), maps.places.pixels.max(axis=0)
    columns = min(number, 2)
    rows = -(-number // columns)
    wide, tall = high - low
    height = rows * (WIDTH / columns * 0.82 * tall / wide + SPARE) + 0.3
    figure = several_panels(WIDTH, height)
    every = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for extra in every[number:]:
        extra.set_axis_off()
    for panel in every[:number]:
        panel.set_xlim(low[0], high[0])
        panel.set_ylim(high[1], low[1])
        panel.set_aspect("equal")
        panel.set_xlabel("r [px]")
        panel.set_ylabel("c as recorded [px]")
    figure.legend(handles=_legend(maps), loc="outside lower center", ncols=3)
    return figure, every[:number]


def _legend(maps: Mapped) -> list[Patch]:
    handles = [Patch(fill=False, edgecolor=VERMILLION, label="hull of the calibration points")]
    if maps.extrapolated.any():
        handles.append(Patch(fill=False, hatch="////", edgecolor=GREY, label="extrapolated"))
    if not maps.places.found.all():
        handles.append(Patch(fill=False, hatch="xxxx", edgecolor=GREY, label="no inverse"))
    return handles


def draw_map(panel: Axes, maps: Mapped, values: Array, title: str) -> None:
    """Fill a panel with contours of values, px; hatch what can't be believed.

    Parameters
    ----------
    values : Array
        ``(n,)``, or shifts ``(n, 2)`` whose lengths are meant.
    """
    r, c = (side.reshape(maps.shape) for side in maps.places.pixels.T)
    if values.ndim == 2:
        shown, levels = _lengths(r[0], c[:, 0], values), levels_of(np.hypot(*values.T), maps)
    else:
        shown, levels = (r[0], c[:, 0], values.reshape(maps.shape)), levels_of(values, maps)
    if len(levels) > 1:
        *at, field = shown[0], shown[1], np.ma.masked_invalid(shown[2])
        norm = LogNorm(levels[0], levels[-1])
        panel.contourf(*at, field, levels, cmap=COLOURS, norm=norm, extend="both", alpha=0.55)
        lines = panel.contour(*at, field, levels, colors=BLACK, linewidths=0.7)
        for label in panel.clabel(lines, fmt=lambda v: f"{v:g}", fontsize=7.5, inline=False):
            label.set_rotation(0)  # a 6 is no 9
            label.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
    for where, hatch in ((maps.extrapolated, "////"), (~maps.places.found, "xxxx")):
        if where.any():
            region = where.astype(float).reshape(maps.shape)
            area = panel.contourf(r, c, region, levels=[0.5, 1.5], colors="none", hatches=[hatch])
            area.set_edgecolor(GREY)
            area.set_linewidth(0)
    panel.add_patch(Polygon(maps.hull, fill=False, edgecolor=VERMILLION, linewidth=1.2))
    panel.set_title(f"{title} [px]", loc="left")


def _lengths(r: Array, c: Array, shift: Array) -> tuple[Array, Array, Array]:
    """Give lengths of shifts ``(n, 2)`` on a finer grid: where they turn round, they are zero."""
    fine_r, fine_c = (np.linspace(v[0], v[-1], FINER * (len(v) - 1) + 1) for v in (r, c))
    between = RegularGridInterpolator((c, r), shift.reshape(len(c), len(r), 2))
    found = between(np.stack(np.meshgrid(fine_c, fine_r, indexing="ij"), axis=-1))
    return fine_r, fine_c, np.hypot(found[..., 0], found[..., 1])


def levels_of(values: Array, maps: Mapped) -> list[float]:
    """Part the values by round steps, from an eighth to a hundredfold of the largest inside."""
    known = values[np.isfinite(values) & (values > 0)]
    if not known.size:
        return []
    inner = values[maps.places.inside & np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    if inner.size and inner.max() > 0:
        high = min(high, 100 * float(inner.max()))
        # Where two models agree, they agree to any digit.
        low = max(low, float(inner.max()) / 8)
    steps = (s[(low < s) & (high > s)] for s in (STEPS, FINE_STEPS))
    found = next((s for s in steps if len(s) >= FEWEST_LEVELS), FINE_STEPS[:0])
    while len(found) > MOST_LEVELS:
        found = found[::2]
    return [float(step) for step in found]


def draw_shifts(panel: Axes, maps: Mapped, shift: Array, every: int) -> None:
    """Draw arrows of shifts ``(n, 2)`` at some of the places inside, the longest a known length."""
    some = np.zeros(maps.shape, dtype=bool)
    some[every // 2 :: every, every // 2 :: every] = True
    use = some.ravel() & maps.places.inside & np.isfinite(shift).all(axis=1)
    longest = float(np.hypot(*shift[use].T).max(initial=0.0))
    if longest > 0:
        width = float(np.ptp(maps.places.pixels[:, 0]))
        panel.quiver(
            *maps.places.pixels[use].T, *shift[use].T, angles="xy", scale_units="xy",
            scale=longest / (LONG * width), width=0.004, color=BLUE,
        )  # fmt: skip


def finished(figure: Figure) -> Figure:
    """Lay the figure out; of contours' labels that meet, or leave their panel, keep the first."""
    settle(figure)
    for panel in figure.axes:
        frame, kept = panel.get_window_extent(), list[Bbox]()
        for label in (text for text in panel.texts if text.get_path_effects()):
            box = label.get_window_extent().padded(APART)
            within = frame.containsx(box.x0) and frame.containsx(box.x1)
            within = within and frame.containsy(box.y0) and frame.containsy(box.y1)
            if within and not any(box.overlaps(other) for other in kept):
                kept.append(box)
            else:
                label.set_visible(False)
    return figure
