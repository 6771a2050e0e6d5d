"""Writes points that the reader reads back unchanged."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from bayescal.files import write_whole
from bayescal.points.correspondences import Correspondences

# Rows that are turned into text at a time.
ROWS = 65536


def to_csv(points: Correspondences) -> str:
    """Format correspondences as CSV text; every number survives the round trip.

    Returns
    -------
    str
    """
    # Numbers first: a line that starts with a label could start with a comment's #.
    numbers = dict(zip("xyzrc", [*points.world.T, *points.pixels.T], strict=True))
    deviations = {f"sigma_{axis}": sd for axis, sd in points.sigma.items()}
    texts = {"label": points.labels, "group": points.groups}
    named = {name: values for name, values in texts.items() if values is not None}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*numbers, *named, *deviations])
    for start in range(0, len(points), ROWS):
        part = slice(start, start + ROWS)
        # repr of a double has every digit.
        first, last = ([v[part].tolist() for v in c.values()] for c in (numbers, deviations))
        writer.writerows(zip(*first, *(v[part] for v in named.values()), *last, strict=True))
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
