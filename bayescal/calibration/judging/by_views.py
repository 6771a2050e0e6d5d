"""Arrays of all views, made some views at a time where they would be large."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property

from bayescal.arrays import Array

# Numbers of an array that is made at once: 16 MB, and several times that on the way.
AT_ONCE = 2_000_000


class ByViews:
    """An array of all views: kept where it is small, else made again part by part.

    Parameters
    ----------
    make : callable
        The array of some views.
    n_views, numbers : int
        Views, and numbers that the array has of each.
    """

    def __init__(self, make: Callable[[slice], Array], n_views: int, numbers: int) -> None:
        self._make, self._n = make, n_views
        self._step = max(1, AT_ONCE // max(numbers, 1))

    @cached_property
    def _all(self) -> Array:
        return self._make(slice(0, self._n))

    def __iter__(self) -> Iterator[tuple[slice, Array]]:
        if self._step >= self._n:
            yield slice(0, self._n), self._all
            return
        for start in range(0, self._n, self._step):
            part = slice(start, min(start + self._step, self._n))
            yield part, self._make(part)
