"""Chessboards, by the inner corners of their squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.detection.opencv import GreyImage, opencv, pixels_of
from bayescal.detection.pattern import Sighting
from bayescal.errors import InputError
from bayescal.points.views.board import Board

SECTORS, CLASSIC = "findChessboardCornersSB", "findChessboardCorners"
# Half the side of the window in which a corner is refined, as a fraction of the distance to its
# nearest neighbour, and its limits, px. On rendered boards with squares of 30 px this has a half
# to a quarter of the error of the sectors' own places (unless the picture is very blurred); with
# a window of 0.4, corners of real boards stray to the board's own edge.
WINDOW, SMALLEST, LARGEST = 0.3, 2, 15


@dataclass(frozen=True)
class Chessboard:
    """A chessboard.

    Attributes
    ----------
    board : Board
        Its inner corners.
    """

    board: Board

    def __post_init__(self) -> None:
        if min(self.board.columns, self.board.rows) < 3:
            raise InputError(f"a chessboard needs 3x3 inner corners or more, not {self.board}")

    @property
    def name(self) -> str:
        """What it is."""
        return f"{self.board} chessboard"

    @property
    def method(self) -> str:
        """What finds it: by sectors where OpenCV can."""
        return f"{SECTORS if hasattr(opencv(), SECTORS) else CLASSIC} and cornerSubPix"

    @property
    def caution(self) -> str:
        """What can't be told of a board that looks the same when turned by half."""
        if (self.board.columns + self.board.rows) % 2:
            return ""
        return (
            f"a {self.board} chessboard looks the same turned by half, so its first corner need "
            "not be the same in all views: offsets of its corners mean little"
        )

    def target(self) -> Array:
        """Its corners, row by row."""
        return self.board.points()

    def find(self, image: GreyImage) -> Sighting | None:
        """Find all its corners, or nothing."""
        seek = _sectors if hasattr(opencv(), SECTORS) else _classic
        corners = seek(image, self.board)
        if corners is None or len(corners) != self.board.n_points:
            return None
        grid = refined(corners.reshape(self.board.rows, self.board.columns, 2), image)
        return Sighting(np.arange(self.board.n_points), oriented(grid, image).reshape(-1, 2))


def _sectors(image: GreyImage, board: Board) -> Array | None:
    cv2 = opencv()
    accurate = cv2.CALIB_CB_ACCURACY
    for flags in (accurate, accurate | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE):
        seen, corners = cv2.findChessboardCornersSB(image, (board.columns, board.rows), flags=flags)
        if seen:
            return pixels_of(corners)
    return None


def _classic(image: GreyImage, board: Board) -> Array | None:
    cv2 = opencv()
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    seen, corners = cv2.findChessboardCorners(image, (board.columns, board.rows), flags=flags)
    return pixels_of(corners) if seen else None


def refined(grid: Array, image: GreyImage) -> Array:
    """Refine corners, ``(rows, columns, 2)``, each in a window as its neighbours allow."""
    cv2 = opencv()
    nearest = np.full(grid.shape[:2], np.inf)
    across = np.linalg.norm(np.diff(grid, axis=1), axis=2)
    along = np.linalg.norm(np.diff(grid, axis=0), axis=2)
    for place, step in (
        (np.s_[:, 1:], across),
        (np.s_[:, :-1], across),
        (np.s_[1:], along),
        (np.s_[:-1], along),
    ):
        nearest[place] = np.minimum(nearest[place], step)
    halves = np.clip(WINDOW * nearest, SMALLEST, LARGEST).astype(int)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    found = grid.copy()
    for half in np.unique(halves).tolist():
        corners = grid[halves == half].astype(np.float32).reshape(-1, 1, 2)
        refined = cv2.cornerSubPix(image, corners, (half, half), (-1, -1), stop)
        found[halves == half] = pixels_of(refined)
    return found


def oriented(grid: Array, image: GreyImage) -> Array:
    """Turn a grid of corners, ``(rows, columns, 2)``, so that the same one is always first.

    Columns run clockwise into rows, as x into y; and where the board's colours tell its two
    ends apart (columns + rows odd), the square after the first corner is dark.
    """
    (ar, ac), (br, bc) = (np.mean(grid[:, -1] - grid[:, 0], 0), np.mean(grid[-1] - grid[0], 0))
    if ar * bc - ac * br < 0:
        grid = grid[:, ::-1]
    if (grid.shape[0] + grid.shape[1]) % 2 and _shade(grid, image) > _shade(
        grid[::-1, ::-1], image
    ):
        grid = grid[::-1, ::-1]
    return grid


def _shade(grid: Array, image: GreyImage) -> float:
    """Grey of the squares that have the colour of the first, less that of the others."""
    middles = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    height, width = image.shape
    r = np.clip(np.rint(middles[..., 0]), 0, width - 1).astype(int)
    c = np.clip(np.rint(middles[..., 1]), 0, height - 1).astype(int)
    grey = image[c, r].astype(float)
    sign = (-1.0) ** np.add.outer(np.arange(grey.shape[0]), np.arange(grey.shape[1]))
    return float((sign * grey).sum())
