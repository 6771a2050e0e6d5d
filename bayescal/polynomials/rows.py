"""A design matrix point by point, where there are too many points to hold it whole."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from bayescal.arrays import Array, IntArray

# Points of a block: what few draws make of them fits into a core's cache.
BLOCK = 8192
ALL = slice(None)


class Rows(Protocol):
    """A design matrix, ``(n_points, n_coefficients)``: an array, or what makes parts of it."""

    @property
    def shape(self) -> tuple[int, ...]:
        """``(n_points, n_coefficients)``."""
        ...

    def __getitem__(self, part: slice | IntArray, /) -> Array: ...


class Designed(Protocol):
    """What makes a design matrix of some of its points."""

    def __len__(self) -> int: ...

    def columns(self, order: int) -> int:
        """Count the coefficients of an order."""
        ...

    def design(self, order: int, part: slice | IntArray = ALL) -> Array:
        """Design matrix of an order, of some points."""
        ...


@dataclass(frozen=True, eq=False)
class Design:
    """The design matrix of many points, made part by part."""

    data: Designed
    order: int

    @property
    def shape(self) -> tuple[int, ...]:
        """``(n_points, n_coefficients)``."""
        return len(self.data), self.data.columns(self.order)

    def __getitem__(self, part: slice | IntArray, /) -> Array:
        return self.data.design(self.order, part)


def rows_of(data: Designed, order: int) -> Rows:
    """Give the design of few points, and of many what makes any part of it."""
    return data.design(order) if len(data) <= BLOCK else Design(data, order)


def blocks(n: int) -> Iterator[slice]:
    """Cut points into blocks that a sum over them is made of."""
    return (slice(start, min(start + BLOCK, n)) for start in range(0, n, BLOCK))
