"""What is odd about single points, counted among all of them: a sample would miss a few."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import off_the_image
from bayescal.rounding import grouped

BEHIND = "behind the camera (z < 0), where it sees nothing; correct their world coordinates"
OFF = "off the image; check its size, or the readings"


class Tally:
    """Counts points behind the camera and off the image, and remembers the first of each."""

    def __init__(self) -> None:
        self.n = 0
        self._counts = {BEHIND: 0, OFF: 0}
        self._first: dict[str, str] = {}

    def add(self, chunk: Correspondences) -> None:
        """Count those of a chunk."""
        self.n += len(chunk)
        self._count(BEHIND, chunk, chunk.world[:, 2] < chunk.setup.position[2])
        self._count(OFF, chunk, off_the_image(chunk))

    def _count(self, what: str, chunk: Correspondences, odd: NDArray[np.bool_]) -> None:
        if odd.any():
            self._counts[what] += int(odd.sum())
            self._first.setdefault(what, chunk.place(int(np.argmax(odd))))

    def notes(self) -> Iterator[str]:
        """Say how many there are, where there are any."""
        for what, count in self._counts.items():
            if count:
                lie = "lies" if count == 1 else "lie"
                where, advice = what.split("; ")
                yield (
                    f"of all {grouped(self.n)} points {grouped(count)} {lie} {where} (the first "
                    f"at {self._first[what]}); {advice}"
                )
