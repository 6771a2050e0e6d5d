"""Writes views that the reader reads back unchanged."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from bayescal.files import write_whole
from bayescal.points.views.views import Views


def views_to_csv(views: Views, comments: Sequence[str] = ()) -> str:
    """Format views as a table, a row per point; every number survives the round trip.

    Parameters
    ----------
    comments : sequence of str
        Lines to stand above the header.
    """
    columns = {"view": [views.names[i] for i in views.view]}
    for name, values in zip("xyzrc", [*views.world.T, *views.pixels.T], strict=True):
        columns[name] = [f"{v!r}".removesuffix(".0") for v in values.tolist()]
    if views.labels is not None:
        columns["label"] = list(views.labels)
    if views.sigma is not None:
        for name, values in zip(("sigma_r", "sigma_c"), views.sigma.T, strict=True):
            columns[name] = [repr(v) for v in values.tolist()]
    text = io.StringIO()
    for line in comments:
        text.write(f"# {' '.join(line.split())}\n")
    if views.image_size is not None:
        text.write(f"# image: {views.width} x {views.height}\n")
    if views.sigma is not None and views.relative_sigma:
        text.write("# sigma: relative\n")
    writer = csv.writer(text, lineterminator="\n")
    names = list(columns)
    if any(name.startswith("#") for name in views.names):  # its line would be a comment
        names.append(names.pop(0))
    writer.writerow(names)
    writer.writerows(zip(*(columns[n] for n in names), strict=True))
    return text.getvalue()


def save_views(
    views: Views, path: str | Path, *, comments: Sequence[str] = (), force: bool = False
) -> None:
    """Write views to a CSV file, whole or not at all.

    Parameters
    ----------
    views : Views
    path : str or Path
        Where to; an existing file is left alone unless `force`.
    comments : sequence of str, optional
        Lines to stand above the header.
    force : bool, optional

    Raises
    ------
    OutputError
        Where the file exists or can't be written.
    """
    write_whole(Path(path), views_to_csv(views, comments).encode(), force=force)
