"""Grids of circles, by the centres of what is seen of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.detection.opencv import GreyImage, opencv, pixels_of
from bayescal.detection.pattern import Sighting
from bayescal.points.views.board import Board


@dataclass(frozen=True)
class Circles:
    """A grid of circles.

    Attributes
    ----------
    board : Board
        Circles in a row and rows, and the distance of neighbouring circles; where every second
        row is shifted by half, of neighbouring rows, as OpenCV counts them.
    asymmetric : bool
        Whether it is.
    """

    board: Board
    asymmetric: bool = False

    @property
    def name(self) -> str:
        """What it is."""
        return f"{self.board} {'asymmetric ' if self.asymmetric else ''}grid of circles"

    @property
    def method(self) -> str:
        """What finds it."""
        return "findCirclesGrid"

    @property
    def caution(self) -> str:
        """What is odd about circles."""
        return (
            "the middle of a circle's picture is not the picture of its middle: with large circles "
            "seen aslant, or a strong lens, that alone can be tenths of a pixel"
        )

    def target(self) -> Array:
        """Centres of the circles, row by row."""
        if not self.asymmetric:
            return self.board.points()
        row, column = np.divmod(np.arange(self.board.n_points), self.board.columns)
        across = 2 * column + row % 2
        return frozen(np.column_stack([across, row, np.zeros(len(row))]) * self.board.square)

    def find(self, image: GreyImage) -> Sighting | None:
        """Find all its circles, or nothing."""
        cv2 = opencv()
        kind = cv2.CALIB_CB_ASYMMETRIC_GRID if self.asymmetric else cv2.CALIB_CB_SYMMETRIC_GRID
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            size = (self.board.columns, self.board.rows)
            seen, centres = cv2.findCirclesGrid(image, size, flags=flags)
            if seen and len(pixels_of(centres)) == self.board.n_points:
                return Sighting(np.arange(self.board.n_points), pixels_of(centres))
        return None
