"""Reads views of a target, whatever wrote them."""

from __future__ import annotations

import dataclasses
from importlib import import_module
from pathlib import Path
from typing import Any

from bayescal.errors import InputError
from bayescal.points.board import Board, board_named
from bayescal.points.formats.source import Source
from bayescal.points.setup import Setup, load_setup
from bayescal.points.table import read_bytes
from bayescal.points.views import Views

# Formats in the order they are tried; the table takes what is left.
FORMATS = ("table",)
WHAT = "a file of views"


def load_views(
    source: str | Path,
    *,
    board: Board | str | None = None,
    square: float | None = None,
    width: float | None = None,
    height: float | None = None,
    setup: Setup | str | Path | None = None,
) -> Views:
    """Read views of a target.

    Parameters
    ----------
    source : str or Path
        The file, or ``"-"`` for standard input: a table with columns ``view, x, y, z, r, c``
        and optionally ``label``, ``sigma_r, sigma_c`` (px), or a file of another tool
        (docs/views.md lists them).
    board : Board or str, optional
        Points of the target where the file holds pixels alone: inner corners along x and y,
        such as ``"9x6"``.
    square : float, optional
        Distance of the board's neighbouring points; 1 by default.
    width, height : float, optional
        Image size, px; goes before what the file says.
    setup : Setup or str or Path, optional
        A setup, or its TOML file, for the image size.

    Returns
    -------
    Views

    Raises
    ------
    InputError
        Where the file can't be used; the message says where and what to do.
    """
    if square is not None and board is None:
        raise InputError("the square's side needs a board, such as 9x6")
    if isinstance(board, str):
        board = board_named(board, 1.0 if square is None else square)
    elif board is not None and square is not None:
        board = dataclasses.replace(board, square=square)
    name, raw = read_bytes(source, WHAT)
    path = None if str(source) == "-" else Path(source)
    given = Source(name, raw, path, board)
    found = _format(given).read(given)
    return _sized(found, *_stated(width, height, setup))


def _format(source: Source) -> Any:
    modules = (import_module(f"bayescal.points.formats.{name}") for name in FORMATS)
    return next(module for module in modules if module.recognises(source))


def _stated(
    width: float | None, height: float | None, setup: Setup | str | Path | None
) -> tuple[float | None, float | None]:
    """Image size that the user states, by options or in a setup."""
    if setup is not None:
        camera = setup if isinstance(setup, Setup) else load_setup(setup)
        if camera.c_from_bottom:
            raise InputError("views count c from the top; leave c_from_bottom out of the setup")
        width = camera.width if width is None else width
        height = camera.height if height is None else height
    return width, height


def _sized(views: Views, width: float | None, height: float | None) -> Views:
    """State the image size, noting where it is not the file's own."""
    own = (views.width, views.height)
    new = (own[0] if width is None else width, own[1] if height is None else height)
    if new == own:
        return views
    if new[0] is None or new[1] is None:
        raise InputError("an image has a width and a height; state both")
    sized = views.with_size(new[0], new[1])
    if own == (None, None):
        return sized
    note = f"image {new[0]:g} by {new[1]:g} px as stated, not {own[0]} by {own[1]} as in the file"
    return dataclasses.replace(sized, notes=(*sized.notes, note))
