"""Views as text, as wide as the terminal: from 60 to 100 columns."""

from __future__ import annotations

import io
import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from functools import singledispatch
from textwrap import fill

from rich import box
from rich.console import Console, Group, JustifyMethod, RenderableType
from rich.padding import Padding
from rich.segment import Segment, Segments
from rich.table import Table as RichTable
from rich.text import Text

from bayescal.report.blocks import Block, Blocks, Facts, Listing, Part, Prose, Tabled
from bayescal.report.table import Table

# Columns: at most, also where there is no terminal, and at least.
WIDTH, NARROW = 100, 60
# Ends of lines, and the joiner within emoji.
KEPT = "\n\u200d"
BULLETS = {"caveat": "caveat: ", "concern": "! "}


def printed(view: Blocks) -> str:
    """Render a view for standard output, as wide as its terminal within bounds."""
    terminal = sys.stdout.isatty()
    columns = shutil.get_terminal_size((WIDTH, 24)).columns if terminal else WIDTH
    return render(view, terminal=terminal, width=min(max(columns, NARROW), WIDTH))


def render(view: Blocks, *, terminal: bool, width: int = WIDTH) -> str:
    """Render a view as text without trailing blanks.

    Parameters
    ----------
    terminal : bool
        Whether to use bold type.
    width : int, optional
        Columns.
    """
    console = Console(
        width=width,
        highlight=False,
        markup=False,  # labels are anybody's: brackets and colons in them mean nothing
        emoji=False,
        force_terminal=terminal,
        file=io.StringIO(),
        legacy_windows=False,
    )
    parts = console.render(laid_out(view, width))
    shown = [Segment(_harmless(s.text), s.style, s.control) for s in parts]
    with console.capture() as captured:
        console.print(Segments(shown))
    lines = "\n".join(line.rstrip() for line in captured.get().splitlines())
    return re.sub(r"\n{3,}", "\n\n", lines).strip("\n") + "\n"


def _harmless(text: str) -> str:
    """Replace what could command a terminal or turn its lines around: labels are anybody's."""
    return "".join(c if c.isprintable() or c in KEPT else "?" for c in text)


def laid_out(blocks: Iterable[Block], width: int = WIDTH) -> Group:
    """Lay blocks out for a terminal; what needs room, such as a figure, is for a page."""
    return Group(*(part for block in blocks for part in _parts(block, width)))


@singledispatch
def _parts(block: Block, width: int) -> Iterator[RenderableType]:  # noqa: ARG001 (of a page)
    """Lay one block out; blank lines around what stands apart are made one by `render`."""
    yield from ()


@_parts.register
def _prose(block: Prose, _: int) -> Iterator[RenderableType]:
    if block.lead:
        yield Text("")
    words = Text(f"{block.lead}: " if block.lead else "", style="bold")
    words.append(block.text, style="not bold")
    yield Padding(words, (0, 0, 0, 2))


@_parts.register
def _listing(block: Listing, _: int) -> Iterator[RenderableType]:
    if block.role == "about":
        yield Text("\n".join(block.items))
    else:
        yield from _indented(f"{BULLETS.get(block.role, '')}{item}" for item in block.items)


@_parts.register
def _facts(block: Facts, width: int) -> Iterator[RenderableType]:
    names = max((len(name) for name, _ in block.pairs), default=0) + 2
    for name, value in block.pairs:
        lead = f"  {name + ':':{names}}"
        # What wraps stands below the value, not the margin.
        wrapped = fill(
            value,
            width,
            initial_indent=lead,
            subsequent_indent=" " * len(lead),
            break_on_hyphens=False,
        )
        yield Text(wrapped)


@_parts.register
def _table(block: Tabled, width: int) -> Iterator[RenderableType]:
    if block.table.rows:
        yield from (Text(""), tabled(block.table, block.flagged, width))
    yield from _indented((*block.legend, *block.notes))


@_parts.register
def _part(block: Part, width: int) -> Iterator[RenderableType]:
    yield from (
        Text(""),
        Text(block.title, style="bold"),
        laid_out(block.blocks, width),
        Text(""),
    )


def tabled(
    table: Table, flagged: frozenset[int] = frozenset(), width: int = WIDTH
) -> RenderableType:
    """Lay a table out for a terminal, the columns after the first as numbers.

    Where the numbers are wider than the terminal, spare ones are left out and a line says which;
    what is still too wide goes on below, under the columns again that name the rows.
    """
    heads = [column.head for column in table.columns]
    rows = [[cell.text for cell in row] for row in table.rows]
    if table.by_order or flagged:
        mark = {table.marked: ">"} if table.by_order else dict.fromkeys(flagged, "!")
        first = max(len(text) for text in [heads[0], *(row[0] for row in rows)])
        side = ">" if all(row[0].isdigit() for row in rows) else "<"
        heads[0] = f"  {heads[0]:{side}{first}}"
        for number, row in enumerate(rows):
            row[0] = f"{mark.get(number, ' ')} {row[0]:{side}{first}}"
    widths = [max([len(head), *(len(row[i]) for row in rows)]) for i, head in enumerate(heads)]
    kept, dropped = list(range(len(heads))), []
    for head in table.spare:
        if sum(widths[i] + 2 for i in kept) <= width:
            break
        if head in heads:
            dropped.append(head)
            kept = [i for i in kept if heads[i] != head]
    parts: list[RenderableType] = []
    for columns in _beside(kept, widths, width, table.naming):
        shown = RichTable(
            box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style=""
        )
        for column in columns:
            justify: JustifyMethod = "right" if column else "left"
            shown.add_column(heads[column], justify=justify, no_wrap=column > 0)
        for number, row in enumerate(rows):
            stressed = number == table.marked or number in flagged
            shown.add_row(*(row[i] for i in columns), style="bold" if stressed else "")
        parts.append(shown)
    if not dropped:
        return Group(*parts)
    left = ", ".join(head for head in dict.fromkeys(heads) if head in dropped)
    return Group(*parts, *_indented([f"Too wide to show: {left} (--json has them)."]))


def _beside(kept: list[int], widths: list[int], width: int, naming: int) -> list[list[int]]:
    """Split columns into sets that fit beside those that name the rows."""
    names = [column for column in kept if column < naming]
    out = [[*names]]
    for column in kept[len(names) :]:
        if len(out[-1]) > len(names) and sum(widths[i] + 2 for i in (*out[-1], column)) > width:
            out.append([*names])
        out[-1].append(column)
    return out


def _indented(lines: Iterable[str]) -> Iterator[RenderableType]:
    """Lay out sentences, each a paragraph two columns in."""
    yield from (Padding(Text(line), (0, 0, 0, 2)) for line in lines)
