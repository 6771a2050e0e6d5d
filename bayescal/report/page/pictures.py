"""Figures as a page holds them: drawn, and written into the page itself."""

from __future__ import annotations

import base64
import io
from dataclasses import replace

from matplotlib.figure import Figure as Drawing
from PIL import Image

from bayescal.errors import InputError
from bayescal.report.blocks import Block, Blocks, Details, Figure, Part, Picture, Prose
from bayescal.report.figures.registry import drawn_as, figure_kinds
from bayescal.report.figures.style import figure_bytes

# A figure is drawn as lines (SVG) unless it is so crowded that this many bytes do not hold it.
LARGEST_SVG = 100_000
DPI, COLOURS = 150, 256
CSS_PX = 100  # an inch of a figure on the page


def drawn(blocks: Blocks) -> Blocks:
    """Draw the figures among blocks; say why where there is nothing to draw."""
    return tuple(map(_drawn, blocks))


def _drawn(block: Block) -> Block:
    if isinstance(block, Details | Part):
        return replace(block, blocks=drawn(block.blocks))
    if not isinstance(block, Figure):
        return block
    kind = figure_kinds(drawn_as(block.result))[block.name]
    which = block.axis, block.order
    try:
        figure = kind.draw(block.result, *which)
        alt = kind.alt_text(block.result, *which)
    except InputError as error:
        return Prose(f"No figure of {kind.summary}: {error}.", "note")
    name = "-".join(str(part) for part in ("figure", block.name, *which) if part is not None)
    return pictured(name, figure, alt, block.caption, block.dpi)


def pictured(
    name: str, figure: Drawing, alt: str, caption: str, dpi: float | None = None
) -> Picture:
    """Put a figure on the page under a name that is unique there."""
    width, height = (round(CSS_PX * float(side)) for side in figure.get_size_inches())
    return Picture(name, _embedded(figure, dpi), alt, caption, width, height)


def _embedded(figure: Drawing, dpi: float | None) -> str:
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
