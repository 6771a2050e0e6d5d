"""A point that is further off than the errors allow, such as a corner taken for another."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class GrossError:
    """A point that is off by more than the error model allows.

    Attributes
    ----------
    point : int
        Row of the views, from 0.
    view, label : str
        As `Views.without` takes them.
    place : str
        File and line, or view and point.
    shift : tuple of float
        Observed less where all other points put it, r and c, px.
    p_value : float
        Of its shift, times the number of points it is the worst of.
    """

    point: int
    view: str
    label: str
    place: str
    shift: tuple[float, float]
    p_value: float

    @property
    def size(self) -> float:
        """How far it is off, px."""
        return math.hypot(*self.shift)

    @property
    def name(self) -> str:
        """As `--without` takes it."""
        return f"{self.view}:{self.label}"
