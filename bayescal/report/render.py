"""Views as text, 100 columns wide."""

from __future__ import annotations

import io

from rich.console import Console, RenderableType

WIDTH = 100


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
        force_terminal=terminal,
        file=io.StringIO(),
        legacy_windows=False,
    )
    with console.capture() as captured:
        console.print(view)
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"
