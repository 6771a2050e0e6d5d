"""Reads points files: CSV or TSV with a header."""

from __future__ import annotations

import hashlib
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES, Setup, load_setup
from bayescal.points.table import PIXEL_SIGMAS, WORLD_SIGMAS, Columns, number, read_bytes, rows
from bayescal.points.text import decode

REQUIRED = ("x", "y", "z", "r", "c")
SIGMAS = PIXEL_SIGMAS + WORLD_SIGMAS
TEXTS = ("label", "group")
COLUMNS = Columns(REQUIRED, (*REQUIRED, *TEXTS, *SIGMAS))


def load(source: str | Path, setup: Setup | str | Path | None = None) -> Correspondences:
    """Read correspondences from a CSV or TSV file with a header.

    Parameters
    ----------
    source : str or Path
        The file, or ``"-"`` for standard input. Columns ``x, y, z, r, c`` and
        optionally ``label, group``, ``sigma_r, sigma_c`` (px) and ``sigma_x, sigma_y,
        sigma_z`` (world units), in any order and case; lines that start with ``#`` are
        comments. UTF-8, with or without a BOM.
    setup : Setup or str or Path, optional
        What is known of the camera, or the TOML file that says it.

    Returns
    -------
    Correspondences

    Raises
    ------
    InputError
        Where the file can't be used; the message names its line.
    """
    name, raw = read_bytes(source)
    found = list(rows(name, decode(name, raw), COLUMNS))
    if not found:
        raise InputError(f"{name}: there are no points below the header; add at least two")
    columns = {column: [row.fields[column] for row in found] for column in found[0].fields}
    numbers = {
        column: [number(name, row, column) for row in found]
        for column in (*REQUIRED, *SIGMAS)
        if column in columns
    }
    camera = setup if isinstance(setup, Setup) or setup is None else load_setup(setup)
    points = Correspondences.from_arrays(
        list(zip(*(numbers[c] for c in "xyz"), strict=True)),
        list(zip(*(numbers[c] for c in "rc"), strict=True)),
        labels=tuple(columns["label"]) if "label" in columns else None,
        groups=tuple(columns["group"]) if "group" in columns else None,
        **{column: numbers[column] for column in SIGMAS if column in numbers},
        setup=camera,
    )
    return Correspondences(
        points.world,
        points.pixels,
        points.labels,
        points.groups,
        points.sigma,
        points.setup,
        source=name,
        lines=tuple(row.line for row in found),
        sha256=hashlib.sha256(raw).hexdigest(),
    )


def axis_names(axis: str) -> tuple[str, ...]:
    """Axes that the option ``--axis r|c|both`` means."""
    if axis == "both":
        return AXES
    if axis in AXES:
        return (axis,)
    raise InputError(f"axis must be r, c or both, not {axis!r}")
