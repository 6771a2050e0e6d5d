"""A sample of points, drawn at random as they come."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, IntArray
from bayescal.points.chunks.chunk import HELD
from bayescal.points.correspondences import Correspondences, one_line

Texts: TypeAlias = NDArray[np.object_]


class Drawn:
    """Draws points without replacement, every one as likely, from chunks of any number.

    Each point has a random key, and those of the smallest keys are kept (bottom-k sampling:
    Cohen & Kaplan 2007, PODC, 225).

    Parameters
    ----------
    size : int
        How many are kept.
    """

    def __init__(self, rng: np.random.Generator, size: int = HELD) -> None:
        self._rng, self._size = rng, size
        self._keys, self._places = np.empty(0), np.empty(0, dtype=np.intp)
        self._numbers = np.empty((0, 5))
        self._sigma: dict[str, Array] = {}
        self._labels, self._lines = np.empty(0, dtype=object), np.empty(0, dtype=object)
        self._groups = np.empty(0, dtype=object)
        self._last: Correspondences | None = None
        self.n = 0

    def add(self, chunk: Correspondences) -> None:
        """Let the points of a chunk take the places of some drawn before."""
        keys = self._rng.random(len(chunk))
        full = len(self._keys) == self._size
        new = np.flatnonzero(keys < self._keys.max()) if full else np.arange(len(chunk))
        every = np.concatenate([self._keys, keys[new]])
        keep = np.arange(len(every))
        if len(every) > self._size:
            keep = np.argpartition(every, self._size)[: self._size]
        old, taken = (
            keep[keep < len(self._keys)],
            new[keep[keep >= len(self._keys)] - len(self._keys)],
        )
        self._keys = np.concatenate([self._keys[old], keys[taken]])
        self._take(chunk, old, taken)
        self.n += len(chunk)
        self._last = chunk

    def _take(self, chunk: Correspondences, old: IntArray, new: IntArray) -> None:
        """Keep some points of before, and add some of a chunk."""

        def joined(kept: Texts, texts: Sequence[Any] | None) -> Texts:
            found = np.empty(len(new), dtype=object)
            found[:] = ["" if texts is None else texts[i] for i in new.tolist()]
            return np.concatenate([kept[old], found])

        self._places = np.concatenate([self._places[old], self.n + new])
        rows = np.column_stack([chunk.world[new], chunk.pixels[new]])
        self._numbers = np.concatenate([self._numbers[old], rows])
        for name, sd in chunk.sigma.items():
            kept = self._sigma.get(name, np.empty(0))
            self._sigma[name] = np.concatenate([kept[old], sd[new]])
        self._labels = joined(self._labels, chunk.labels)
        self._groups = joined(self._groups, chunk.groups)
        self._lines = joined(self._lines, chunk.lines)

    def points(self, sha256: str, notes: tuple[str, ...]) -> Correspondences:
        """Give those drawn, in the order they came."""
        assert self._last is not None, "there were points"
        order = np.argsort(self._places)
        numbers, last = self._numbers[order], self._last
        return Correspondences(
            numbers[:, :3],
            numbers[:, 3:],
            self._names(order),
            None if last.groups is None else one_line(tuple(self._groups[order])),
            {name: sd[order] for name, sd in self._sigma.items()},
            last.setup,
            last.source,
            None if last.lines is None else tuple(self._lines[order]),
            sha256,
            notes,
            self.n,
        )

    def _names(self, order: IntArray) -> tuple[str, ...]:
        """Labels, and the number of a point that has none."""
        names = one_line(tuple(self._labels[order]))
        places = self._places[order].tolist()
        return tuple(name or str(i + 1) for name, i in zip(names, places, strict=True))
