"""Which cameras a fleet has: files, patterns of their names, or a manifest that lists them."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.paths import named_paths
from bayescal.points.tables.content import read_content
from bayescal.points.tables.text import quoted
from bayescal.rounding import counted

KNOWN = ("file", "camera", "setup")


@dataclass(frozen=True)
class Listed:
    """A camera by its files.

    Attributes
    ----------
    name : str
    file : str
        Of its points or views.
    setup : str or None
        Its own setup file, where a manifest names one.
    """

    name: str
    file: str
    setup: str | None = None


def listed(given: Sequence[str | Path]) -> list[Listed]:
    """List the cameras that files, patterns and manifests mean, each name once.

    A manifest is a CSV file whose header has ``file`` and may have ``camera`` (a name) and
    ``setup``; its paths are relative to it.

    Raises
    ------
    InputError
        Where there are none, or a manifest can't be used.
    """
    found: list[Listed] = []
    for path in named_paths(given, "files of cameras", "cameras/*.csv"):
        rows = _manifest(path) if path.suffix.lower() == ".csv" else None
        found += [Listed(path.stem, str(path))] if rows is None else rows
    return _told_apart(found)


def _manifest(path: Path) -> list[Listed] | None:
    """Read a manifest; None where the file is none."""
    with path.open("rb") as stream:
        head = stream.readline(4096)
    if b"file" not in [word.strip(b' "\xef\xbb\xbf\r\n').lower() for word in head.split(b",")]:
        return None
    lines = read_content(path, "a manifest").text().splitlines()
    header = [name.strip().lower() for name in next(csv.reader(lines[:1]))]
    foreign = [name for name in header if name not in KNOWN]
    if foreign:
        raise InputError(
            f"{path}:1: column {quoted(foreign[0])} is none of {', '.join(KNOWN)}; drop it"
        )
    found: list[Listed] = []
    named: dict[str, int] = {}
    for number, fields in enumerate(csv.reader(lines[1:]), 2):
        if not any(map(str.strip, fields)):
            continue
        if len(fields) != len(header):
            raise InputError(
                f"{path}:{number}: has {counted(len(fields), 'field')}, the header {len(header)}"
            )
        row = dict(zip(header, map(str.strip, fields), strict=True))
        if not row["file"]:
            raise InputError(f"{path}:{number}: file: is empty; name the camera's file")
        name = row.get("camera")
        if name and named.setdefault(name, number) != number:
            raise InputError(
                f"{path}:{number}: camera {quoted(name)} is named in line {named[name]}, too; "
                "give each a name of its own"
            )
        place = path.parent / row["file"]
        setup = str(path.parent / row["setup"]) if row.get("setup") else None
        found.append(Listed(name or place.stem, str(place), setup))
    if not found:
        raise InputError(f"{path}: lists no cameras below its header; add some")
    return found


def _told_apart(found: Iterable[Listed]) -> list[Listed]:
    """Name cameras by their files where their names alone do not tell them apart."""
    cameras = list(dict.fromkeys(found))
    names = [camera.name for camera in cameras]
    if len(set(names)) == len(names):
        return cameras
    full = [Listed(c.file, c.file, c.setup) for c in cameras]
    again = {c.name for c in full}
    if len(again) < len(full):
        raise InputError(f"{full[0].file}: cameras of one file need names of their own; add some")
    return full
