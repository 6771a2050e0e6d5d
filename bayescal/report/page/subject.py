"""What every section is made from: a comparison, its result document, its pictures."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure
from PIL import Image

from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.errors import InputError
from bayescal.report.figures.registry import KINDS
from bayescal.report.figures.style import figure_bytes
from bayescal.report.page.blocks import Block, Part, Picture, Prose

# A figure is drawn as lines (SVG) unless it is so crowded that this many bytes do not hold it.
LARGEST_SVG = 100_000
DPI, COLOURS = 150, 256
CSS_PX = 100  # an inch of a figure on the page


@dataclass(frozen=True, eq=False)
class PageSubject:
    """A comparison and its result document.

    Attributes
    ----------
    comparison : Comparison
    document : dict
        The result document that the page embeds.
    study : OutlierStudy or None
        Its bad points, where they were looked for.
    families : FamilyComparison or None
        Families of models of the same points, where they were compared.
    """

    comparison: Comparison
    document: dict[str, Any]
    study: OutlierStudy | None = None
    families: FamilyComparison | None = None

    @property
    def axes(self) -> tuple[AxisComparison, ...]:
        """All axes."""
        return tuple(self.comparison.axes.values())

    def parts(self, blocks: Mapping[str, tuple[Block, ...]]) -> tuple[Block, ...]:
        """Put each axis's blocks under its name; those without blocks are left out.

        Parameters
        ----------
        blocks : mapping of str to tuple of Block
            By the axis's name.
        """
        found = {name: part for name, part in blocks.items() if part}
        return tuple(
            Part(axis_title(self.comparison.axes[name]), part) for name, part in found.items()
        )

    def picture(
        self,
        kind: str,
        caption: str,
        axis: str | None = None,
        order: int | None = None,
        dpi: float | None = None,
    ) -> Block:
        """Draw a figure, or say why there is none.

        Parameters
        ----------
        kind : str
            One of the kinds of figure.
        caption : str
        axis : str, optional
        order : int, optional
            The recommended one by default.
        dpi : float, optional
            Of the dots of a figure that is known to be too crowded for lines.
        """
        try:
            figure = KINDS[kind].draw(self.comparison, axis, order)
            alt = KINDS[kind].alt_text(self.comparison, axis, order)
        except InputError as error:
            return Prose(f"No figure of {KINDS[kind].summary}: {error}.", "note")
        name = "-".join(str(part) for part in ("figure", kind, axis, order) if part is not None)
        return pictured(name, figure, alt, caption, dpi)


def pictured(
    name: str, figure: Figure, alt: str, caption: str, dpi: float | None = None
) -> Picture:
    """Put a figure on the page.

    Parameters
    ----------
    name : str
        Unique on the page.
    figure : matplotlib.figure.Figure
    alt, caption : str
    dpi : float, optional
        As `PageSubject.picture`.
    """
    width, height = (round(CSS_PX * float(side)) for side in figure.get_size_inches())
    return Picture(name, embedded(figure, dpi), alt, caption, width, height)


def axis_title(axis: AxisComparison) -> str:
    """Name an axis with its regressor."""
    return f"{axis.data.axis} as a polynomial of {axis.data.regressor}"


def embedded(figure: Figure, dpi: float | None = None) -> str:
    """Encode a figure as a data URI: as lines where they are few, else as dots of few colours."""
    if dpi is None:
        lines = figure_bytes(figure, "svg")
        if len(lines) <= LARGEST_SVG:
            return _uri("svg+xml", lines)
    with Image.open(io.BytesIO(figure_bytes(figure, "png", dpi or DPI))) as image:
        # Maximum coverage keeps colours that are rare, such as a frame's.
        few = image.convert("RGB").quantize(
            COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )
    stream = io.BytesIO()
    few.save(stream, "png", optimize=True)
    return _uri("png", stream.getvalue())


def _uri(kind: str, raw: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(raw).decode('ascii')}"
