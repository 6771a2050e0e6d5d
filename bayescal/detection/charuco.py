"""ChArUco boards: chessboards whose white squares bear markers, so that a part of one is enough."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.detection.opencv import GreyImage, opencv, pixels_of
from bayescal.detection.pattern import Sighting
from bayescal.errors import InputError
from bayescal.points.views.board import Board

FEWEST = 4


@dataclass(frozen=True)
class Charuco:
    """A ChArUco board.

    Attributes
    ----------
    board : Board
        Its inner corners; OpenCV counts its squares, one more each way.
    marker : float
        Side of a marker, the unit of the square's.
    dictionary : str
        OpenCV's name of the markers, such as ``"4x4_50"``.
    legacy : bool
        Whether it was printed from OpenCV before 4.6, whose first square bears a marker where
        the rows are even.
    """

    board: Board
    marker: float
    dictionary: str
    legacy: bool = False

    def __post_init__(self) -> None:
        if not 0 < self.marker < self.board.square:
            raise InputError(
                f"a marker's side must be above 0 and below its square's, {self.board.square:g}, "
                f"not {self.marker:g}"
            )

    @property
    def name(self) -> str:
        """What it is."""
        return f"{self.board} ChArUco board of {self.dictionary.upper()}"

    @property
    def method(self) -> str:
        """What finds it."""
        return "CharucoDetector"

    @property
    def caution(self) -> str:
        """Nothing is odd: markers number the corners."""
        return ""

    def target(self) -> Array:
        """Its corners, row by row."""
        return frozen(np.asarray(self._made().getChessboardCorners()).reshape(-1, 3))

    def find(self, image: GreyImage) -> Sighting | None:
        """Find what of it is seen, at least four corners."""
        cv2 = opencv()
        corners, ids, *_ = cv2.aruco.CharucoDetector(self._made()).detectBoard(image)
        if ids is None or len(ids) < FEWEST:
            return None
        return Sighting(np.asarray(ids, dtype=np.intp).ravel(), pixels_of(corners))

    def _made(self) -> Any:
        """Make OpenCV's board."""
        aruco = getattr(opencv(), "aruco", None)
        if not hasattr(aruco, "CharucoDetector"):
            raise InputError("this OpenCV finds no ChArUco boards; install OpenCV 4.7 or newer")
        assert aruco is not None, "it has CharucoDetector"
        size = (self.board.columns + 1, self.board.rows + 1)
        markers = aruco.getPredefinedDictionary(self._number(aruco))
        made = aruco.CharucoBoard(size, self.board.square, self.marker, markers)
        if made.getIds().size > len(markers.bytesList):
            raise InputError(
                f"{self.dictionary.upper()} has {len(markers.bytesList)} markers and this board "
                f"{made.getIds().size}; name a larger dictionary"
            )
        made.setLegacyPattern(self.legacy)
        return made

    def _number(self, aruco: Any) -> int:
        """OpenCV's number of the dictionary."""
        known = [n.removeprefix("DICT_") for n in dir(aruco) if re.fullmatch(r"DICT_[0-9A-Z_]+", n)]
        name = self.dictionary.upper().removeprefix("DICT_")
        if name not in known:
            raise InputError(
                f"{self.dictionary[:40]!r} is no dictionary of OpenCV's; it has {', '.join(known)}"
            )
        return int(getattr(aruco, f"DICT_{name}"))
