"""A regular board: how many corners, how far apart."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError

MOST = 10_000  # corners of a board


@dataclass(frozen=True)
class Board:
    """A grid of points in the plane z = 0: corners inside a chessboard, or centres of circles.

    Attributes
    ----------
    columns, rows : int
        Points along x and along y.
    square : float
        Distance of neighbours, in whatever unit the target has.
    """

    columns: int
    rows: int
    square: float = 1.0

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 2 or self.columns * self.rows > MOST:
            raise InputError(
                f"a board of {self.columns} by {self.rows} points can't be used; it has at least "
                f"2 by 2 and at most {MOST} (count the inner corners, such as 9x6)"
            )
        if not isinstance(self.square, int | float):
            raise InputError(f"the square's side must be a number, not {self.square!r}")
        if not 1e-9 <= self.square <= 1e9:
            raise InputError(f"the square's side must be from 1e-9 to 1e9, not {self.square:g}")

    @property
    def n_points(self) -> int:
        """How many points the board has."""
        return self.columns * self.rows

    def points(self) -> Array:
        """x, y, z of its points, x running fastest, ``(n_points, 3)``, the square's unit."""
        y, x = np.divmod(np.arange(self.n_points), self.columns)
        return frozen(np.column_stack([x, y, np.zeros(self.n_points)]) * self.square)

    def __str__(self) -> str:
        return f"{self.columns}x{self.rows}"


def board_named(text: str, square: float = 1.0) -> Board:
    """Make a board of a text such as 9x6.

    Raises
    ------
    InputError
        Where it is none.
    """
    found = re.fullmatch(r"\s*(\d{1,5})\s*[xX]\s*(\d{1,5})\s*", text, flags=re.ASCII)
    if not found:
        raise InputError(f"{text[:40]!r} is no board; write its inner corners, such as 9x6")
    return Board(int(found[1]), int(found[2]), square)
