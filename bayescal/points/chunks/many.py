"""Many points: known by their number, read chunk by chunk, or at once for what needs them so."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bayescal.points.chunks.chunk import HELD, Found
from bayescal.points.chunks.gathered import MOST, gathered
from bayescal.points.chunks.stored import cut, cut_array, of_npy, of_parquet
from bayescal.points.chunks.text import of_text
from bayescal.points.correspondences import Correspondences
from bayescal.points.exports import npy
from bayescal.points.reader import EXPORTS
from bayescal.points.setup import Setup
from bayescal.points.tables.columns import WORLD_SIGMAS, parse_stated
from bayescal.points.tables.content import Content

# Enough of a file to know what it is.
BEGINNING = 65536


@dataclass(frozen=True, eq=False)
class ManyPoints:
    """Points that are read chunk by chunk and never held at once.

    Attributes
    ----------
    source : str
        Where they come from, for messages.
    found : Found
        What is known of them before they are read.
    digest : callable
        SHA-256 of what they are read from.
    setup : Setup
    begun : callable or None
        Called when they begin to be read, once more each time; gives what is told the number of
        points of each chunk.
    """

    source: str
    found: Found
    digest: Callable[[], str]
    setup: Setup = field(default_factory=Setup)
    begun: Callable[[], Callable[[int], None]] | None = None

    def __iter__(self) -> Iterator[Correspondences]:
        told = None if self.begun is None else self.begun()
        for chunk in self.found.read(self.setup):
            yield chunk
            if told is not None:
                told(len(chunk))

    @property
    def exact_world(self) -> bool:
        """Whether the world coordinates have no errors that are stated."""
        stated = self.setup.world_sigma is not None or self.found.columns & set(WORLD_SIGMAS)
        return not stated

    def at_once(self, most: int = MOST) -> Correspondences:
        """Read all points, at most so many, under this setup.

        Raises
        ------
        InputError
            Where they are too many.
        """
        found = self.found
        labelled = "label" in found.columns
        return gathered(self.source, self, self.digest(), found.notes, labelled=labelled, most=most)


def many_points(source: Any, columns: str | Mapping[str, str] | None = None) -> ManyPoints | None:
    """Take points as many; None where they are few, or of a kind that is read at once.

    Parameters
    ----------
    source : Correspondences, str, Path or array_like
        As `bayescal.points.reader.load` takes it.
    columns : str or mapping, optional
        Names or numbers of columns, likewise.

    Raises
    ------
    InputError
        Where it is a file that can't be used.
    """
    stated = parse_stated(columns) if isinstance(columns, str) else columns
    if isinstance(source, Correspondences):
        return _held(source) if len(source) > HELD and source.drawn_from is None else None
    if isinstance(source, np.ndarray):
        return _array(source)
    path = Path(source) if isinstance(source, str | Path) and str(source) != "-" else None
    try:
        if path is None or not path.is_file():
            return None
        with path.open("rb") as stream:
            beginning = stream.read(BEGINNING)
    except (OSError, ValueError):
        return None  # who reads it at once says why it can't
    found = _found(path, beginning, stated)
    if found is None or "view" in found.columns:
        return None
    return ManyPoints(str(path), found, lambda: _file_digest(path))


def _found(path: Path, beginning: bytes, stated: Mapping[str, str] | None) -> Found | None:
    """Look what a file holds."""
    content = Content(str(path), beginning, path)
    for module in EXPORTS:
        if module.recognises(content):
            if module is npy:
                return of_npy(path, stated)
            return of_parquet(path, stated) if beginning.startswith(b"PAR1") else None
    return of_text(path, stated)


def _held(points: Correspondences) -> ManyPoints:
    names = frozenset(["label", *(f"sigma_{name}" for name in points.sigma)])
    found = Found(len(points), names, lambda setup: cut(points, setup), points.notes)
    return ManyPoints(points.source, found, lambda: points.sha256, points.setup)


def _array(table: Any) -> ManyPoints | None:
    if (
        table.ndim != 2
        or table.shape[1] != 5
        or len(table) <= HELD
        or table.dtype.kind not in "fiu"
    ):
        return None
    found = Found(len(table), frozenset(), lambda setup: cut_array(table, "arrays", setup))
    return ManyPoints(
        "arrays",
        found,
        lambda: hashlib.sha256(np.ascontiguousarray(table)).hexdigest(),
    )


def _file_digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
