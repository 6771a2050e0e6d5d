"""Points that are off, such as corners taken for others: by more than the errors allow, or bad."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bayescal.rounding import percent, significant


@dataclass(frozen=True)
class OffPoint:
    """A point that is not where the others put it.

    Attributes
    ----------
    point : int
        Row of the views, from 0.
    view, label : str
        As `Views.without` takes them.
    place : str
        File and line, or view and point.
    shift : tuple of float
        Observed less where all other points (that are good) put it, r and c, px; NaN where the
        lens can't see it.
    """

    point: int
    view: str
    label: str
    place: str
    shift: tuple[float, float]

    @property
    def size(self) -> float:
        """How far it is off, px."""
        return math.hypot(*self.shift)

    @property
    def name(self) -> str:
        """As `--without` takes it."""
        return f"{self.view}:{self.label}"


@dataclass(frozen=True)
class GrossError(OffPoint):
    """A point that is off by more than the error model allows.

    Attributes
    ----------
    p_value : float
        Of its shift, times the number of points it is the worst of.
    """

    p_value: float


@dataclass(frozen=True)
class BadPoint(OffPoint):
    """A point that is bad, or may be.

    Attributes
    ----------
    probability : float
        Of being bad, the lenses averaged.
    left_out : bool
        Whether lenses are drawn, and residuals taken, without it.
    """

    probability: float
    left_out: bool

    @property
    def words(self) -> str:
        """Which it is, how far it is off and how probably bad."""
        return f"{self.far}: {percent(self.probability)}"

    @property
    def far(self) -> str:
        """Which it is, and how far off where the best lens can say so."""
        far = f", off by {significant(self.size)} px" if math.isfinite(self.size) else ""
        return f"{self.name}{far}"
