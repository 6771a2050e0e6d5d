"""Views as text, 100 columns wide."""

from __future__ import annotations

import io
from collections.abc import Iterable

from rich import box
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.segment import Segment, Segments
from rich.table import Table as RichTable
from rich.text import Text

from bayescal.report.grid import Table

WIDTH = 100
# Ends of lines, and the joiner within emoji.
KEPT = "\n\u200d"


def render(view: RenderableType, *, terminal: bool) -> str:
    """Render a view as text, 100 columns wide, without trailing blanks.

    Parameters
    ----------
    view : rich.console.RenderableType
    terminal : bool
        Whether to use bold type.
    """
    console = Console(
        width=WIDTH,
        highlight=False,
        markup=False,  # labels are anybody's: brackets and colons in them mean nothing
        emoji=False,
        force_terminal=terminal,
        file=io.StringIO(),
        legacy_windows=False,
    )
    shown = [Segment(_harmless(s.text), s.style, s.control) for s in console.render(view)]
    with console.capture() as captured:
        console.print(Segments(shown))
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"


def _harmless(text: str) -> str:
    """Replace what could command a terminal or turn its lines around: labels are anybody's."""
    return "".join(c if c.isprintable() or c in KEPT else "?" for c in text)


def laid_out(table: Table) -> RenderableType:
    """Lay a table out for a terminal, the columns after the first as numbers.

    Where the numbers are so wide that 100 columns do not hold them, spare ones are left
    out and a line says which.
    """
    heads = [column.head for column in table.columns]
    rows = [[cell.text for cell in row] for row in table.rows]
    if table.by_order:
        width = max(len(text) for text in [heads[0], *(row[0] for row in rows)])
        side = ">" if all(row[0].isdigit() for row in rows) else "<"
        heads[0] = f"  {heads[0]:{side}{width}}"
        for number, row in enumerate(rows):
            row[0] = f"{' >'[number == table.marked]} {row[0]:{side}{width}}"
    widths = [max([len(head), *(len(row[i]) for row in rows)]) for i, head in enumerate(heads)]
    kept, dropped = list(range(len(heads))), []
    for head in table.spare:
        if sum(widths[i] + 2 for i in kept) <= WIDTH:
            break
        if head in heads:
            dropped.append(head)
            kept.remove(heads.index(head))
    shown = RichTable(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="")
    for column in kept:
        shown.add_column(heads[column], justify="right" if column else "left", no_wrap=True)
    for number, row in enumerate(rows):
        shown.add_row(*(row[i] for i in kept), style="bold" if number == table.marked else "")
    if not dropped:
        return shown
    left = ", ".join(head for head in heads if head in dropped)
    return Group(shown, Text(f"  Too wide to show: {left} (--json has them)."))


def listed(facts: Iterable[tuple[str, str]]) -> RenderableType:
    """Lay out names and values, two columns without lines."""
    table = RichTable(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, value in facts:
        table.add_row(f"  {name}", value)
    return table


def indented(lines: Iterable[str]) -> list[RenderableType]:
    """Lay out sentences, each a paragraph two columns in."""
    return [Padding(Text(line), (0, 0, 0, 2)) for line in lines]
