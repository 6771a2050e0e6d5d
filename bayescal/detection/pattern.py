"""What a kind of target must offer, and what is found of it in a photograph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from bayescal.arrays import Array, IntArray
from bayescal.detection.opencv import GreyImage


@dataclass(frozen=True, eq=False)
class Sighting:
    """Points of a target found in a photograph.

    Attributes
    ----------
    points : IntArray
        Which of the target's points, ``(n,)``.
    pixels : Array
        r, c, ``(n, 2)``, px.
    """

    points: IntArray
    pixels: Array


class Pattern(Protocol):
    """A kind of target; implementations are frozen dataclasses, one file each."""

    @property
    def name(self) -> str:
        """What it is, for people: "9x6 chessboard"."""

    @property
    def method(self) -> str:
        """What finds it, for people: OpenCV's function."""

    @property
    def caution(self) -> str:
        """What can't be told of such a target, or is odd about it; empty where nothing is."""

    def target(self) -> Array:
        """Its points x, y, z, ``(n_corners, 3)``, the unit of its side."""

    def find(self, image: GreyImage) -> Sighting | None:
        """Find it in an image; None where it is not seen."""
