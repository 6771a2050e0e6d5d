"""Reads points: any table with a header, and the forms that other programs write."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.exports import colmap, npy, parquet, qgis, spreadsheet
from bayescal.points.setup import AXES, Setup
from bayescal.points.setup_file import load_setup
from bayescal.points.tables.columns import KNOWN, REQUIRED, SIGMAS, Columns, parse_stated
from bayescal.points.tables.content import Content, read_content
from bayescal.points.tables.frames import frame_table, is_frame
from bayescal.points.tables.pairs import read_pair
from bayescal.points.tables.table import Rows, number, read_rows, rows_of
from bayescal.points.tables.text import quoted
from bayescal.rounding import counted

# In the order they are asked; a table of text is what remains.
EXPORTS = (spreadsheet, parquet, npy, qgis, colmap)
COLUMNS = Columns(REQUIRED, KNOWN)


def load(
    source: Any,
    setup: Setup | str | Path | None = None,
    *,
    columns: str | Mapping[str, str] | None = None,
    view: str | None = None,
    pixels: str | Path | None = None,
) -> Correspondences:
    """Read correspondences from a file or a data frame.

    Parameters
    ----------
    source : str, Path, DataFrame or array_like
        A file, ``"-"`` for standard input, a data frame, or an array of x, y, z, r, c,
        ``(n_points, 5)``. Columns ``x, y, z, r, c`` and optionally ``label, group``,
        ``sigma_r, sigma_c`` (px) and ``sigma_x, sigma_y, sigma_z`` (world units), in any
        order and case, or under names such as ``E, N, h`` and ``col, row``. In text they
        are separated by commas, tabs, semicolons or blanks, with decimal points or
        commas; lines that start with ``#`` are comments. Files of other programs are
        known by their content (docs/files.md). What is assumed beyond our own names
        stands in the result's ``notes``.
    setup : Setup or str or Path, optional
        What is known of the camera, or the TOML file that says it.
    columns : str or mapping, optional
        Names or numbers of columns, such as ``"x=E,y=N,z=h,r=u,c=v"``.
    view : str, optional
        Which view to take of a file that holds several.
    pixels : str or Path, optional
        A second file that holds the pixels, where `source` has world points alone; put
        together by label, else by order.

    Returns
    -------
    Correspondences

    Raises
    ------
    InputError
        Where the source can't be used; the message names the line.
    """
    stated = parse_stated(columns) if isinstance(columns, str) else columns
    camera = None if setup is None else camera_of(setup)
    if not isinstance(source, str | Path):
        return _in_memory(source, camera, stated, view)
    content = read_content(source, "a points file")
    digest, second = hashlib.sha256(content.raw), None
    if pixels is not None:
        second = read_content(pixels, "a file of pixels")
        digest.update(second.raw)
        name, found, own = second.name, read_pair(content, second, stated, view), None
    else:
        name = content.name
        found, own = _one_file(content, stated, view)
    points = points_of(name, found, own if camera is None else camera, view)
    return dataclasses.replace(points, sha256=digest.hexdigest())


def camera_of(setup: Setup | str | Path) -> Setup:
    """Read a setup's file, where it is not a setup already."""
    found = load_setup(setup) if isinstance(setup, str | Path) else setup
    if not isinstance(found, Setup):
        raise InputError(f"setup must be a Setup or a TOML file, not {_kind(found)}")
    return found


def _one_file(
    content: Content, stated: Mapping[str, str] | None, view: str | None
) -> tuple[Rows, Setup | None]:
    """Read a file by the first format that recognises it, else as a table of text."""
    for module in EXPORTS:
        if module.recognises(content):
            found = module.read(content, view)
            rows = rows_of(found.table, COLUMNS, stated)
            return Rows(rows.rows, (*found.notes, *rows.notes)), found.setup
    return read_rows(content.name, content.text(), COLUMNS, stated), None


def _in_memory(
    source: object, setup: Setup | None, stated: Mapping[str, str] | None, view: str | None
) -> Correspondences:
    """Take points from a data frame or an array."""
    if is_frame(source):
        name = type(source).__name__
        found = rows_of(frame_table(source, name), COLUMNS, stated)
        return dataclasses.replace(points_of(name, found, setup, view), lines=None)
    try:
        table = np.asarray(source, dtype=float)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or table.shape[1] != 5:
        raise InputError(
            f"points must be Correspondences, a file, a data frame or an array (n_points, 5) of "
            f"x, y, z, r, c, not {_kind(source)}"
        )
    return Correspondences.from_arrays(table[:, :3], table[:, 3:], setup=setup)


def _kind(value: object) -> str:
    """Name a value's type, and its shape where it has one."""
    shape = getattr(value, "shape", None)
    return type(value).__name__ + (f" of shape {shape}" if shape is not None else "")


def points_of(name: str, found: Rows, setup: Setup | None, view: str | None) -> Correspondences:
    """Make correspondences of rows, whose lines and source they keep.

    Raises
    ------
    InputError
        Where there are none, or a number is not usable; the message names the line.
    """
    if not found.rows:
        raise InputError(f"{name}: there are no points below the header; add at least two")
    kept = _one_view(name, found, view)
    given = kept.rows[0].fields
    numbers = {
        column: [number(name, row, column) for row in kept.rows]
        for column in (*REQUIRED, *SIGMAS)
        if column in given
    }
    texts = {
        column: tuple(row.fields[column] for row in kept.rows) if column in given else None
        for column in ("label", "group")
    }
    points = Correspondences.from_arrays(
        list(zip(*(numbers[c] for c in "xyz"), strict=True)),
        list(zip(*(numbers[c] for c in "rc"), strict=True)),
        labels=texts["label"],
        groups=texts["group"],
        **{column: numbers[column] for column in SIGMAS if column in numbers},
        setup=setup,
    )
    lines = tuple(row.line for row in kept.rows)
    return dataclasses.replace(points, source=name, lines=lines, notes=kept.notes)


def _one_view(name: str, found: Rows, view: str | None) -> Rows:
    """Keep the points of one view, and say where several photographs count as one."""
    if "view" not in found.rows[0].fields:
        if view is not None:
            raise InputError(f"{name}: has no column of views; leave out --view")
        return found
    views = list(dict.fromkeys(row.fields["view"] for row in found.rows))
    if view is not None and view not in views:
        raise InputError(f"{name}: holds no view {quoted(view)}, but {quoted(', '.join(views))}")
    if view is not None and len(views) > 1:
        kept = tuple(row for row in found.rows if row.fields["view"] == view)
        return Rows(kept, (*found.notes, f"of {counted(len(views), 'view')}, {view} is taken"))
    if len(views) > 1:
        raise InputError(
            f"{name}: holds {len(views)} views, {quoted(', '.join(views))}; choose one with "
            "--view, or drop the column if the camera stood still"
        )
    return found


def axis_names(axis: str) -> tuple[str, ...]:
    """Axes that the option ``--axis r|c|both`` means."""
    if axis == "both":
        return AXES
    if axis in AXES:
        return (axis,)
    raise InputError(f"axis must be r, c or both, not {axis!r}")
