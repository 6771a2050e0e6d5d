"""Writes points and setup files that the readers read back unchanged."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path

from bayescal.files import write_whole
from bayescal.points.camera import CAMERA_KEYS, PINHOLE_KEYS, StatedCamera
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import Setup


def to_csv(points: Correspondences) -> str:
    """Format correspondences as CSV text; every number survives the round trip.

    Parameters
    ----------
    points : Correspondences

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


def to_toml(setup: Setup) -> str:
    """Format a setup as TOML text; every number survives the round trip.

    Parameters
    ----------
    setup : Setup

    Returns
    -------
    str
    """
    lines = ["[camera]", f"position = {_list(setup.position)}"]
    lines += _stated(setup.camera, CAMERA_KEYS)
    lines += ["", "[image]"]
    lines += [
        f"{name} = {size!r}"
        for name, size in (("width", setup.width), ("height", setup.height))
        if size is not None
    ]
    lines.append(f"c_from_bottom = {str(setup.c_from_bottom).lower()}")
    lines.append("assumed = [" + ", ".join(f'"{name}"' for name in setup.assumed) + "]")
    if setup.world_sigma is not None:
        lines += ["", "[world]", f"sigma = {_list(setup.world_sigma)}"]
    for axis, prior in setup.priors.items():
        lines += ["", f"[prior.{axis}]", f"mean = {_list(prior.mean)}", f"sd = {_list(prior.sd)}"]
    optics = _stated(setup.camera, PINHOLE_KEYS)
    if optics:
        lines += ["", "[prior.pinhole]", *optics]
    return "\n".join(lines) + "\n"


def _stated(camera: StatedCamera, keys: Iterable[str]) -> list[str]:
    """Lines of what is stated of the camera under some keys."""
    known = [(key, getattr(camera, key)) for key in keys if getattr(camera, key) is not None]
    return [f"{key} = {_list(v) if isinstance(v, tuple) else repr(v)}" for key, v in known]


def _list(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(repr(v) for v in values) + "]"


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
