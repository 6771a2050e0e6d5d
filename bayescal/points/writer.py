"""Writes points that the reader reads back unchanged."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from bayescal.files import write_whole
from bayescal.points.correspondences import Correspondences


def to_csv(points: Correspondences) -> str:
    """Format correspondences as CSV text; every number survives the round trip.

    Returns
    -------
    str
    """
    # Numbers first: a line that starts with a label could start with a comment's #.
    columns: dict[str, list[str]] = {}
    for name, values in zip(
        ("x", "y", "z", "r", "c"), [*points.world.T, *points.pixels.T], strict=True
    ):
        columns[name] = [repr(float(v)) for v in values]
    columns["label"] = list(points.labels)
    if points.groups is not None:
        columns["group"] = list(points.groups)
    for axis, sd in points.sigma.items():
        columns[f"sigma_{axis}"] = [repr(float(v)) for v in sd]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue()


def save(points: Correspondences, path: str | Path, *, force: bool = False) -> None:
    """Write correspondences to a CSV file, whole or not at all.

    Parameters
    ----------
    points : Correspondences
    path : str or Path
        Where to; an existing file is left alone unless `force`.

    Raises
    ------
    OutputError
        Where the file exists or can't be written.
    """
    write_whole(Path(path), to_csv(points).encode(), force=force)
