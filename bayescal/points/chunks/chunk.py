"""A chunk: correspondences of some rows, checked all at once and without a text per point."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar, overload

import numpy as np

from bayescal.arrays import Array
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES, LARGEST, LARGEST_PX, SMALLEST_PX, Setup
from bayescal.points.tables.columns import PIXEL_SIGMAS, SIGMAS
from bayescal.points.tables.table import check_number

Item = TypeVar("Item")

# More points than these are read in chunks, and this many of them are drawn and held.
HELD = 5000


class Lazily(Sequence[Item]):
    """A sequence whose items are made when they are asked for.

    Parameters
    ----------
    make : callable
        The item at an index from 0.
    """

    def __init__(self, count: int, make: Callable[[int], Item]) -> None:
        self._count, self._make = count, make

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Item: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Item]: ...
    def __getitem__(self, index: int | slice) -> Item | Sequence[Item]:
        places = range(self._count)[index]
        return self._make(places) if isinstance(places, int) else [self._make(i) for i in places]


@dataclass(frozen=True, eq=False)
class Found:
    """What is known of a file's points before they are read.

    Attributes
    ----------
    about : int
        About how many there are.
    columns : frozenset of str
        Quantities that it has.
    read : callable
        Reads them chunk by chunk, under a setup.
    notes : tuple of str
        What had to be assumed to read them.
    """

    about: int
    columns: frozenset[str]
    read: Callable[[Setup], Iterator[Correspondences]]
    notes: tuple[str, ...] = ()


def numbered(start: int, count: int) -> Sequence[str]:
    """Labels of points that have none: their numbers, `start` of them before the first."""
    return Lazily(count, lambda i: str(start + i + 1))


def chunk_of(
    source: str,
    start: int,
    columns: Mapping[str, Array],
    setup: Setup,
    *,
    texts: Mapping[str, Sequence[str]] | None = None,
    lines: Sequence[int] | None = None,
) -> Correspondences:
    """Make correspondences of columns of numbers.

    Parameters
    ----------
    start : int
        Points before the first of these.
    columns : mapping of str to Array
        x, y, z, r, c and what there is of deviations, each ``(n_chunk,)``.
    texts : mapping of str to sequence of str, optional
        Labels and groups, by ``"label"`` and ``"group"``.
    lines : sequence of int, optional
        Lines of the file.

    Raises
    ------
    InputError
        Where a number is not finite or can't be what its column says; the message names the row.
    """
    texts = texts or {}
    world = np.column_stack([columns[name] for name in "xyz"])
    pixels = np.column_stack([columns[name] for name in AXES])
    count = len(world)
    labels = texts.get("label") or numbered(start, count)
    sigma = {name[-1]: columns[name] for name in SIGMAS if name in columns}
    made = Correspondences(
        world, pixels, labels, texts.get("group"), sigma, setup, source, lines=lines
    )
    for name, values in columns.items():
        bad = ~(np.abs(values) < (LARGEST_PX if name in AXES else LARGEST))
        if name in SIGMAS:
            bad |= (values < SMALLEST_PX) if name in PIXEL_SIGMAS else (values < 0)
        if bad.any():
            first = int(np.argmax(bad))
            check_number(f"{made.place(first)}: {name}", name, float(values[first]))
    return made
