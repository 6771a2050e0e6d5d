"""Reads points: any table with a header, and the forms that other programs write."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.columns import KNOWN, REQUIRED, SIGMAS, Columns, parse_stated
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES, Setup, load_setup
from bayescal.points.table import Rows, number, read_bytes, read_rows
from bayescal.points.text import decode, quoted
from bayescal.rounding import counted

COLUMNS = Columns(REQUIRED, KNOWN)


def load(
    source: str | Path,
    setup: Setup | str | Path | None = None,
    *,
    columns: str | Mapping[str, str] | None = None,
    view: str | None = None,
) -> Correspondences:
    """Read correspondences from a table with a header.

    Parameters
    ----------
    source : str or Path
        The file, or ``"-"`` for standard input. Columns ``x, y, z, r, c`` and
        optionally ``label, group``, ``sigma_r, sigma_c`` (px) and ``sigma_x, sigma_y,
        sigma_z`` (world units), in any order and case, or under names such as
        ``E, N, h`` and ``col, row``; separated by commas, tabs, semicolons or blanks;
        with decimal points or commas. Lines that start with ``#`` are comments. UTF-8,
        with or without a BOM. What is assumed beyond our own names stands in the
        result's ``notes``.
    setup : Setup or str or Path, optional
        What is known of the camera, or the TOML file that says it.
    columns : str or mapping, optional
        Names or numbers of columns, such as ``"x=E,y=N,z=h,r=u,c=v"``.
    view : str, optional
        Which view to take of a file that holds several.

    Returns
    -------
    Correspondences

    Raises
    ------
    InputError
        Where the file can't be used; the message names its line.
    """
    name, raw = read_bytes(source)
    camera = setup if isinstance(setup, Setup) or setup is None else load_setup(setup)
    stated = parse_stated(columns) if isinstance(columns, str) else columns
    found = read_rows(name, decode(name, raw), COLUMNS, stated)
    points = points_of(name, found, camera, view)
    return dataclasses.replace(points, sha256=hashlib.sha256(raw).hexdigest())


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
    if view is not None:
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
