"""Names beside the points of a figure, placed so that they cover nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.font_manager import findfont, get_font
from matplotlib.transforms import Transform

from bayescal.arrays import Array

FONT_SIZE = 6.5  # pt
# Size of a character of the default font as a fraction of its size.
DIGIT_WIDTH, DIGIT_HEIGHT = 0.64, 0.76
MARKER, GAP = 2.2, 1.2  # half a marker, and what stays free beside it, pt
STROKE = 0.6  # half the width that a line takes, pt
APART = 1.8  # between two names, pt
REACH = 40.0  # how far from a point its name can matter, pt
LONGEST_NAME = 12  # characters
AMBIGUOUS = 5.0  # cost, pt^2, of a place nearer to another point than to its own


@dataclass(frozen=True)
class Box:
    """A rectangle on the page, pt."""

    left: float
    bottom: float
    right: float
    top: float

    def overlap(self, other: Box) -> float:
        """Area shared with another box, pt^2."""
        width = min(self.right, other.right) - max(self.left, other.left)
        height = min(self.top, other.top) - max(self.bottom, other.bottom)
        return max(width, 0.0) * max(height, 0.0)

    def grown(self, by: float) -> Box:
        """Give the box with so much more on every side, pt."""
        return Box(self.left - by, self.bottom - by, self.right + by, self.top + by)

    def distance(self, x: float, y: float) -> float:
        """Distance to a place, pt; 0 inside."""
        return float(
            np.hypot(
                max(self.left - x, 0.0, x - self.right), max(self.bottom - y, 0.0, y - self.top)
            )
        )

    def outside(self, other: Box) -> float:
        """Area that sticks out of another box, pt^2."""
        area = (self.right - self.left) * (self.top - self.bottom)
        return area - self.overlap(other)


def name_points(
    ax: Axes,
    x: Array,
    y: Array,
    named: Sequence[int],
    *,
    stems: bool = False,
    lines: Sequence[float] = (),
    curve: Array | None = None,
    names: Sequence[str] | None = None,
) -> list[str]:
    """Write the names of some points beside them, covering no marker, line or name.

    The figure's layout must be final, for the places are found on the page.

    Parameters
    ----------
    x, y : Array
        All points drawn, ``(n_points,)``, in the axes' units.
    named : sequence of int
        Points to name, from 0, the most important first.
    stems : bool, optional
        Whether lines go from zero to each point.
    lines : sequence of float, optional
        Heights of lines across the axes.
    curve : Array, optional
        Places on a curve drawn, ``(n_places, 2)``, in the axes' units.
    names : sequence of str, optional
        Of all points, as `printable_names` makes them; their numbers, from 1, by
        default.

    Returns
    -------
    list of str
        The names written.
    """
    page = _Page.of(ax)
    places = np.full((len(x), 2), np.nan)
    drawn = np.isfinite(y)
    places[drawn] = page.points(np.column_stack([x, y])[drawn])
    zero = page.height(0.0)
    taken = _marked(places[drawn], zero if stems else None)
    if curve is not None:
        taken += [Box(px, py, px, py).grown(STROKE) for px, py in page.points(curve).tolist()]
    for height in map(page.height, lines):
        taken.append(Box(page.frame.left, height - STROKE, page.frame.right, height + STROKE))
    written = []
    for point in named:
        if not np.isfinite(places[point]).all():
            continue
        name = str(point + 1) if names is None else names[point]
        px, py = places[point].tolist()
        cost = _Cost.at(point, places, taken, page.frame)
        upwards = py >= zero or not stems
        box = min(_candidates(px, py, len(name), upwards=upwards), key=cost.of)
        taken.append(box.grown(APART))
        written.append(name)
        middle = np.array([box.left + box.right, box.bottom + box.top]) / 2
        note = ax.annotate(
            name,
            (float(x[point]), float(y[point])),
            xytext=(float(middle[0]) - px, float(middle[1]) - py),
            textcoords="offset points",
            ha="center",
            va="center_baseline",
            fontsize=FONT_SIZE,
            parse_math=False,
        )
        note.set_in_layout(False)
    return written


@dataclass(frozen=True, eq=False)
class _Page:
    """Where the axes stand on the page, pt."""

    transform: Transform
    scale: float
    frame: Box

    @classmethod
    def of(cls, ax: Axes) -> _Page:
        figure = ax.get_figure(root=True)
        assert figure is not None, "axes are drawn on a figure"
        scale, frame = 72 / figure.dpi, ax.get_window_extent()
        edges = (float(v) * scale for v in (frame.x0, frame.y0, frame.x1, frame.y1))
        return cls(ax.transData, scale, Box(*edges))

    def points(self, places: Array) -> Array:
        """Places of the axes' units on the page, ``(n, 2)``."""
        return np.asarray(self.transform.transform(places)) * self.scale

    def height(self, y: float) -> float:
        return float(self.transform.transform((0.0, y))[1]) * self.scale


def _marked(places: Array, zero: float | None) -> list[Box]:
    """Give what markers cover, and the lines that go to them from zero, where they do."""
    taken = []
    for px, py in places.tolist():
        low, high = (py, py) if zero is None else (min(py, zero), max(py, zero))
        taken.append(Box(px - MARKER, py - MARKER, px + MARKER, py + MARKER))
        taken.append(Box(px - STROKE, low, px + STROKE, high))
    return taken


@dataclass(frozen=True, eq=False)
class _Cost:
    """How bad a place is for the name of a point: what it covers, and whose it seems to be."""

    place: tuple[float, float]
    near: list[Box]
    others: list[list[float]]
    frame: Box

    @classmethod
    def at(cls, point: int, places: Array, taken: list[Box], frame: Box) -> _Cost:
        """Look around a point at what is within reach."""
        px, py = places[point].tolist()
        others = np.delete(places, point, axis=0)
        gaps = np.hypot(*(others - places[point]).T)  # NaN of what is not drawn
        near = [box for box in taken if box.distance(px, py) < REACH]
        return cls((px, py), near, others[gaps < REACH].tolist(), frame)

    def of(self, box: Box) -> float:
        covered = sum(box.overlap(other) for other in self.near) + 10 * box.outside(self.frame)
        own = box.distance(*self.place)
        return covered + AMBIGUOUS * any(box.distance(*other) < own for other in self.others)


def printable_names(labels: Sequence[str]) -> tuple[str, ...]:
    """Names of points as a figure can show them.

    A label that is long, or holds a character that the figure's font lacks, gives way
    to the point's number with a #.
    """
    known = get_font(findfont("DejaVu Sans")).get_charmap()
    return tuple(
        label
        if len(label) <= LONGEST_NAME and all(ord(c) in known and c.isprintable() for c in label)
        else f"#{i}"
        for i, label in enumerate(labels, 1)
    )


def _candidates(px: float, py: float, digits: int, *, upwards: bool) -> Iterator[Box]:
    """Boxes for a name, the best place first: outward of the point, then around it."""
    width = (digits * DIGIT_WIDTH + 0.1) * FONT_SIZE
    height = DIGIT_HEIGHT * FONT_SIZE
    sign = 1.0 if upwards else -1.0
    beside = MARKER + GAP + width / 2
    out = MARKER + GAP + height / 2
    for step in range(4):
        rise = step * 0.9 * height
        shifts = [(0.0, out), (beside, 0.0), (-beside, 0.0), (beside, out), (-beside, out)]
        for dx, dy in [*shifts, (0.0, -out)] if step == 0 else shifts:
            x, y = px + dx, py + sign * (dy + rise)
            yield Box(x - width / 2, y - height / 2, x + width / 2, y + height / 2)
