"""What all points of an axis say, where they were read in chunks and only a sample is held."""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.arrays import Array
from bayescal.polynomials.basis import Domain


@dataclass(frozen=True, eq=False)
class Triangle:
    """R of a QR factorisation [design | pixels] = Q R at the highest order reduced.

    Attributes
    ----------
    r : Array
        Upper triangle of the design's columns, ``(p, p)``.
    qt : Array
        Q't, ``(p,)``.
    tail : float
        Residual norm of the highest order.
    largest : float
        Largest pixel in size, over its deviation where there are deviations.
    """

    r: Array
    qt: Array
    tail: float
    largest: float

    def rss(self, amplitudes: Array) -> float:
        """Sum of squares that amplitudes of the first columns leave, ``(k,)``."""
        left = self.qt - self.r[:, : len(amplitudes)] @ amplitudes
        return float(left @ left) + self.tail**2


@dataclass(frozen=True, eq=False)
class Whole:
    """All points of an axis, reduced to numbers whose count does not grow with theirs.

    Attributes
    ----------
    n : int
        Number of points.
    order : int
        Highest order of the design.
    domain : Domain
        Of the regressor; its Legendre basis is the design's.
    readings : Domain
        Smallest and largest pixel.
    distinct : int
        Values of the regressor that differ, as far as they were counted.
    plain : Triangle
        Of the pixels as they are.
    weighted : Triangle or None
        Divided by the points' deviations; None where they have none.
    log_sd : float
        Sum of ln sd over points with deviations; 0 without them.
    across : Domain or None
        Of the other regressor, where the design is one of both.
    """

    n: int
    order: int
    domain: Domain
    readings: Domain
    distinct: int
    plain: Triangle
    weighted: Triangle | None = None
    log_sd: float = 0.0
    across: Domain | None = None

    @property
    def frame(self) -> tuple[Domain, ...]:
        """Domains of the design's basis."""
        return (self.domain,) if self.across is None else (self.domain, self.across)

    @property
    def used(self) -> Triangle:
        """Divided by the points' deviations where they have them."""
        return self.plain if self.weighted is None else self.weighted
