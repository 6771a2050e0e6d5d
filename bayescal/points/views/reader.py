"""Reads views of a target, whatever wrote them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from fnmatch import fnmatch
from importlib import import_module
from pathlib import Path
from typing import Any

from bayescal.errors import InputError
from bayescal.points.setup import Setup
from bayescal.points.setup_file import load_setup
from bayescal.points.tables.columns import parse_stated
from bayescal.points.tables.content import Content, read_content
from bayescal.points.tables.frames import is_frame
from bayescal.points.tables.text import quoted
from bayescal.points.views.board import Board, board_named
from bayescal.points.views.formats import orpc, table
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views
from bayescal.rounding import counted

# Formats in the order they are tried; the table takes what is left.
FORMATS = ("npz", "mat", "cameramodel", "vnl", "orpc", "table")
WHAT = "a file of views"


def load_views(
    source: Any,
    *,
    board: Board | str | Path | None = None,
    square: float | None = None,
    columns: str | Mapping[str, str] | None = None,
    only: str | None = None,
    width: float | None = None,
    height: float | None = None,
    setup: Setup | str | Path | None = None,
) -> Views:
    """Read views of a target.

    Parameters
    ----------
    source : str, Path or DataFrame
        A file, ``"-"`` for standard input, or a data frame: a table with columns ``view, x,
        y, z, r, c`` and optionally ``label``, ``sigma_r, sigma_c`` (px); or a file (or
        folder) of another tool (docs/views.md lists them).
    board : Board or str or Path, optional
        Points of the target where the file holds pixels alone: inner corners along x and y,
        such as ``"9x6"``; or the file that describes it (``.dsc``).
    square : float, optional
        Distance of the board's neighbouring points; 1 by default.
    columns : str or mapping, optional
        Names or numbers of a table's columns, such as ``"view=photo,r=u,c=v"``.
    only : str, optional
        Pattern of the names of the views to keep, such as ``"*cam0*"``.
    width, height : float, optional
        Image size, px; goes before what the file says.
    setup : Setup or str or Path, optional
        A setup, or its TOML file, for the image size and the title block of a report.

    Returns
    -------
    Views

    Raises
    ------
    InputError
        Where the file can't be used; the message says where and what to do.
    """
    stated = parse_stated(columns) if isinstance(columns, str) else columns
    if not isinstance(source, str | Path):
        if not is_frame(source):
            raise InputError(
                f"views must be a file or a data frame, not {type(source).__name__}; arrays go "
                "into Views.from_arrays"
            )
        found = table.from_frame(source, stated)
    else:
        given = _source(source, board, square, stated)
        found = _format(given).read(given)
    if setup is None:
        return _sized(_kept(found, only), width, height)
    camera = _camera(setup)
    own = (camera.width if width is None else width, camera.height if height is None else height)
    return dataclasses.replace(_sized(_kept(found, only), *own), heading=camera.heading)


def _source(
    source: str | Path,
    board: Board | str | Path | None,
    square: float | None,
    columns: Mapping[str, str] | None,
) -> Source:
    """Read the bytes, and bring what the user says of the board together."""
    target = None
    if not isinstance(board, Board | str | Path | None):
        raise InputError(f"board must be such as '9x6', not {type(board).__name__}")
    if isinstance(board, str | Path) and Path(board).suffix.lower() == ".dsc":
        target, board = Path(board), None
    if square is not None and board is None:
        raise InputError("the square's side needs a board, such as 9x6")
    if isinstance(board, str | Path):
        board = board_named(str(board), 1.0 if square is None else square)
    elif board is not None and square is not None:
        board = dataclasses.replace(board, square=square)
    path = None if str(source) == "-" else Path(source)
    folder = path is not None and _is_folder(path)
    content = Content(str(source), b"") if folder else read_content(source, WHAT)
    name = content.name
    given = Source(name, content.raw, path, board, target, columns)
    if folder and not orpc.recognises(given):
        raise InputError(f"{name}: is a folder without .orpc files; name a file of views")
    if target is not None and not orpc.recognises(given):
        raise InputError(f"{target.name} describes boards of .orpc files, which {name} is not")
    return given


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False  # reading it says what is wrong


def _kept(views: Views, only: str | None) -> Views:
    """Keep the views whose names have a pattern."""
    if only is None:
        return views
    kept = [i for i, name in enumerate(views.names) if fnmatch(name, only)]
    if not kept:
        raise InputError(
            f"{views.source}: no view is called {quoted(only)}; there are "
            f"{quoted(', '.join(views.names))}"
        )
    note = f"{len(kept)} of {counted(len(views), 'view')} kept, called {only}"
    return dataclasses.replace(views.select(kept), notes=(*views.notes, note))


def _format(source: Source) -> Any:
    """Find the module that reads a file."""
    modules = (import_module(f"bayescal.points.views.formats.{name}") for name in FORMATS)
    found = next(module for module in modules if module.recognises(source))
    if source.columns and found is not table:
        raise InputError(f"{source.name}: is a {found.NAME}, whose columns are known")
    return found


def _camera(setup: Setup | str | Path) -> Setup:
    """Read what the user states of the camera."""
    if not isinstance(setup, Setup | str | Path):
        raise InputError(f"setup must be a Setup or a TOML file, not {type(setup).__name__}")
    camera = setup if isinstance(setup, Setup) else load_setup(setup)
    if camera.c_from_bottom:
        raise InputError("views count c from the top; leave c_from_bottom out of the setup")
    return camera


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
