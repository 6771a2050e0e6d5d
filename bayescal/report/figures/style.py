"""The look that figures share, and how they become bytes."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib import style as looks
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.typing import ColorType

from bayescal.errors import InputError

WIDTH = 7.2  # inches: two columns of a journal
# Okabe & Ito's colours, which the colour-blind can tell apart.
BLUE, VERMILLION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PURPLE, BLACK, GREY = "#56b4e9", "#cc79a7", "#000000", "#666666"
PALE = "#c9d3db"  # what matters less
MANY_POINTS = 2000  # markers beyond it become pixels inside an SVG or PDF
CYCLE = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, BLACK)
DASHES = ("-", "--", ":")
KEPT, REMOVED = BLUE, VERMILLION
# Cividis is safe for the colour-blind; its palest end is left out, for it fades on white.
COLOURS = LinearSegmentedColormap.from_list(
    "depth", colormaps["cividis"](np.linspace(0, 0.92, 256))
)
STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7.5,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "hatch.linewidth": 0.4,
    "svg.hashsalt": "bayescal",  # the same figure gives the same bytes
}


# Figures of a comparison are read on a page 720 px wide: a point is 1.4 px there.
PAGE_STYLE: Any = {
    **STYLE,
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
}


def ink_on(colour: ColorType) -> str:
    """Choose black or white for letters on a colour, whichever has more contrast (WCAG 2.2)."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = float(np.dot([0.2126, 0.7152, 0.0722], linear))
    return "black" if (luminance + 0.05) ** 2 > 1.05 * 0.05 else "white"


FORMATS = ("png", "svg", "pdf")
# No dates and no versions: the same figure gives the same bytes.
_METADATA: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
}


# Axes that the user gave to be drawn in.
_GIVEN: ContextVar[Axes | None] = ContextVar("given", default=None)


@contextmanager
def styled(ax: Axes | None = None) -> Iterator[None]:
    """Give figures their look, whatever the user's own settings are; axes of the user have theirs.

    Parameters
    ----------
    ax : Axes, optional
        What `one_panel` gives in place of axes of its own.

    Raises
    ------
    InputError
        Where they are none.
    """
    if ax is not None and not isinstance(ax, Axes):
        raise InputError(f"ax must be axes of matplotlib, not a {type(ax).__name__}")
    token = _GIVEN.set(ax)
    try:
        with nullcontext() if ax is not None else looks.context(["default", PAGE_STYLE]):
            yield
    finally:
        _GIVEN.reset(token)


def one_panel(width: float, height: float) -> tuple[Figure, Axes]:
    """Make a figure of one panel, inches; or give the axes that the user gave, and their figure."""
    given = _GIVEN.get()
    if given is not None:
        root: Figure = given.figure.canvas.figure  # theirs may be a figure within a figure
        return root, given
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def legend_of(panel: Axes, where: str, columns: int) -> None:
    """Say what a panel shows: outside it, or within axes that the user gave."""
    if _GIVEN.get() is not None:
        panel.legend()
    else:
        root: Any = panel.figure
        root.legend(loc=f"outside {where}", ncols=columns)


def several_panels(width: float, height: float, layout: Any = "constrained") -> Figure:
    """Make an empty figure, inches, for several panels.

    Raises
    ------
    InputError
        Where the user gave axes.
    """
    if _GIVEN.get() is not None:
        raise InputError("a figure of several panels can't be drawn in one; leave out ax")
    return Figure(figsize=(width, height), layout=layout)


def figure_bytes(figure: Figure, kind: str, dpi: float = 200) -> bytes:
    """Encode a figure, white behind it, without dates: the same figure, the same bytes.

    Parameters
    ----------
    kind : str
        ``"png"``, ``"svg"`` or ``"pdf"``.
    dpi : float, optional
        Of a PNG.
    """
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format=kind, dpi=dpi, facecolor="white", metadata=_METADATA[kind])
    return stream.getvalue()


def settle(figure: Figure) -> None:
    """Lay a figure out for good, so that names can be placed on the page."""
    figure.draw_without_rendering()
    if _GIVEN.get() is None:
        figure.set_layout_engine("none")


def save_figure(figure: Figure, stem: Path) -> None:
    """Write a figure as PNG (300 dpi) and SVG beside each other, without dates.

    Parameters
    ----------
    stem : Path
        Of the files, without a suffix.
    """
    with rc_context(STYLE):
        figure.savefig(stem.with_suffix(".png"), dpi=300, metadata={"Software": None})
        figure.savefig(stem.with_suffix(".svg"), metadata={"Date": None})
