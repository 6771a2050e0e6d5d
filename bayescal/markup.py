"""Pieces of HTML that results show themselves with in a notebook.

They state no colour and no font, so that a notebook's own theme holds, dark or light, and
ask for nothing from outside. Every text is escaped: labels are whatever a file held.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

_CELL = "padding: 0.2em 0.7em; text-align: right; white-space: nowrap"
_CAPTION = "caption-side: top; text-align: left; padding: 0.3em 0"


def paragraph(text: str) -> str:
    """Text as a paragraph."""
    return f'<p style="max-width: 60em">{escape(text)}</p>'


def bullets(title: str, texts: Iterable[str]) -> str:
    """Texts as a list under a title; nothing where there are none."""
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    if not items:
        return ""
    return f'<p>{escape(title)}</p><ul style="max-width: 60em">{items}</ul>'


def table(
    caption: str, heads: Sequence[str], rows: Sequence[Sequence[str]], *, marked: int | None = None
) -> str:
    """Small table; the first cell of each row is its head.

    Parameters
    ----------
    caption : str
        What it shows, and in which units.
    heads : sequence of str
        Of the columns.
    marked : int, optional
        The row in bold type; its head must say in words why.

    Returns
    -------
    str
    """
    columns = "".join(f'<th scope="col" style="{_CELL}">{escape(head)}</th>' for head in heads)
    body = []
    for number, (first, *cells) in enumerate(rows):
        weight = "bold" if number == marked else "normal"
        style = f"{_CELL}; font-weight: {weight}"
        body.append(
            f'<tr><th scope="row" style="{style}">{escape(first)}</th>'
            + "".join(f'<td style="{style}">{escape(cell)}</td>' for cell in cells)
            + "</tr>"
        )
    return (
        '<div style="overflow-x: auto"><table>'
        f'<caption style="{_CAPTION}">{escape(caption)}</caption>'
        f"<thead><tr>{columns}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )
