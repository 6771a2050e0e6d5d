"""A pixel axis explained by nested linear models: what every linear family hands on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array, IntArray, frozen
from bayescal.errors import InputError
from bayescal.points.pixel import SMALLEST_IMAGE, pixel_of
from bayescal.polynomials.basis import (
    Domain,
    MonomialMap,
    PolynomialMap,
    distinct_values,
    legendre_design,
)
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.plane import PlaneMap, plane_columns, plane_design, powers
from bayescal.polynomials.rows import ALL
from bayescal.polynomials.whole import Whole
from bayescal.rounding import counted

# Powers of ten that a product of two such numbers must leave room for.
DECADES = 60


@dataclass(frozen=True, eq=False)
class AxisData:
    """One pixel axis as a polynomial regression problem.

    Attributes
    ----------
    axis : str
        ``"r"``, ``"c"``, or ``"y"`` for a generic problem.
    regressor : str
        What the polynomial is a function of: ``"x/z"``, ``"y/z"``, ``"x"``.
    symbol : str
        Name of the coefficients: ``"alpha"`` for r, ``"beta"`` for c.
    x : Array
        Regressor values, ``(n_points,)``.
    t : Array
        Measured pixels, ``(n_points,)``, px.
    sd : Array or None
        Known standard deviations per point, ``(n_points,)``, px.
    labels : sequence of str
        A name per point.
    size : float
        Image size along the axis, or the span of t where it is not known, px.
    size_known : bool
        Whether `size` is an image size.
    source : str
        Where the points came from, for messages.
    x_sd : Array or None
        Standard deviations of the regressor, ``(n_points,)``, where the world
        coordinates have errors.
    other : Array or None
        The other regressor, ``(n_points,)``, where the polynomial is one of both.
    frame : tuple of Domain or None
        Domains of the basis where they are not those of these points: the basis stays
        when the camera moves.
    whole : Whole or None
        All points, reduced, where these are a sample of them.
    """

    axis: str
    regressor: str
    symbol: str
    x: Array
    t: Array
    sd: Array | None
    labels: Sequence[str]
    size: float
    size_known: bool
    source: str
    x_sd: Array | None = None
    other: Array | None = None
    frame: tuple[Domain, ...] | None = None
    whole: Whole | None = None

    def __len__(self) -> int:
        return len(self.x)

    @property
    def n(self) -> int:
        """Number of points that the likelihood has: all, where these are a sample."""
        return len(self) if self.whole is None else self.whole.n

    @property
    def distinct(self) -> int:
        """Values of the regressor that differ; no more than 64 are counted of a whole."""
        return distinct_values(self.x) if self.whole is None else self.whole.distinct

    @property
    def deviations(self) -> Array:
        """Standard deviations of the points, 1 where none are known, ``(n_points,)``."""
        return np.ones(len(self)) if self.sd is None else self.sd

    @property
    def middle(self) -> float:
        """Middle of the pixels, px."""
        return (Domain.of(self.t) if self.whole is None else self.whole.readings).middle

    @property
    def alone(self) -> AxisData:
        """These points as if they were all."""
        return self if self.whole is None else replace(self, whole=None)

    def sampled_from(self, whole: Whole) -> AxisData:
        """Give these points as a sample of the whole, whose domain and span they take."""
        span = self.size if self.size_known else span_of(whole.readings)
        return replace(self, whole=whole, frame=whole.frame, size=span)

    @property
    def generic(self) -> bool:
        """Whether this is y of any kind, and not an axis of an image."""
        return self.axis not in PIXEL_AXES

    @property
    def unit(self) -> str:
        """Unit of t, as a heading names it."""
        return "units of y" if self.generic else "px"

    @property
    def suffix(self) -> str:
        """Unit behind a number, with its space; none of a generic y."""
        return "" if self.generic else " px"

    @property
    def in_pixels(self) -> bool:
        """Whether t is surely in pixels: of a stated image that is more than a few pixels."""
        return self.size_known and self.size >= SMALLEST_IMAGE

    @property
    def pixel(self) -> float:
        """What stands for a pixel, in units of t."""
        return pixel_of(self.size, known=self.size_known)

    @property
    def domain(self) -> Domain:
        """Interval of the regressor that the basis is scaled to."""
        return Domain.of(self.x) if self.frame is None else self.frame[0]

    @property
    def across(self) -> Domain:
        """The same of the other regressor."""
        assert self.other is not None, "the polynomial is one of a single regressor"
        return Domain.of(self.other) if self.frame is None else self.frame[1]

    def columns(self, order: int) -> int:
        """Count the coefficients of an order."""
        return order + 1 if self.other is None else plane_columns(order)

    def degrees(self, order: int) -> tuple[int, ...]:
        """Total degree of every coefficient of an order."""
        if self.other is None:
            return tuple(range(order + 1))
        return tuple(i + j for i, j in powers(order))

    def weighted(self, order: int, part: slice = ALL) -> Array:
        """Give [design | pixels] over the deviations, ``(n_points, n_coefficients + 1)``."""
        both = np.column_stack([self.design(order, part), self.t[part]])
        return both if self.sd is None else both / self.sd[part, None]

    def design(self, order: int, part: slice | IntArray = ALL) -> Array:
        """Design matrix of an order in its Legendre basis, ``(n_points, columns)``.

        Parameters
        ----------
        part : slice or IntArray, optional
            Of which points.
        """
        s = self.domain.scale(self.x[part])
        if self.other is None:
            return legendre_design(s, order)
        return plane_design(s, self.across.scale(self.other[part]), order)

    def monomials(self, order: int) -> PolynomialMap:
        """From the basis's amplitudes to the coefficients that are reported."""
        if self.other is None:
            return MonomialMap(self.domain, order)
        return PlaneMap(self.domain, self.across, order)

    def check(self, order: int) -> None:
        """Refuse an order that these points can't determine.

        Raises
        ------
        InputError
            With the highest order that still works.
        """
        if self.other is None:
            self._check_line(order)
        else:
            self._check_plane(order)

    def _check_plane(self, order: int) -> None:
        p, works = plane_columns(order), 0
        while plane_columns(works + 1) <= self.n:
            works += 1
        if self.n < p:
            advice = f"the highest order that works is {works}" if works else "add points"
            raise InputError(
                f"{self.source}: axis {self.axis}: order {order} in {self.regressor} has {p} "
                f"coefficients for {counted(self.n, 'point')}; {advice}"
            )

    def _check_line(self, order: int) -> None:
        where = f"{self.source}: axis {self.axis}"
        widest = max(abs(self.domain.lower), abs(self.domain.upper))
        half = self.domain.half_range
        # Coefficients reach size * (widest / half)^order / half^order.
        if half > 0 and not (
            order * abs(math.log10(half)) < DECADES
            and order * max(math.log10(widest / half), 0) < DECADES
            and abs(math.log10(self.size)) < DECADES
        ):
            raise InputError(
                f"{where}: {self.regressor} spans {2 * half:.3g} and the pixels {self.size:.3g}: "
                f"coefficients of order {order} are beyond every double; use other units"
            )
        values = self.distinct
        works = min(values, self.n) - 1
        advice = (
            f"the highest order that works is {works}"
            if works >= 1
            else "no order works; add points"
        )
        if self.n < order + 1:
            raise InputError(
                f"{where}: order {order} has {order + 1} coefficients for "
                f"{counted(self.n, 'point')}; {advice}"
            )
        if values < order + 1:
            raise InputError(
                f"{where}: {self.regressor} takes {counted(values, 'distinct value')}, "
                f"order {order} needs {order + 1}; {advice}"
            )


def generic_axis(x: Array, y: Array, sd: Array | None = None, source: str = "x and y") -> AxisData:
    """Set up a generic one-axis problem: y as a polynomial of x.

    The span of y stands for the image size.

    Parameters
    ----------
    x, y : Array
        ``(n_points,)``; y in whatever unit it has.
    sd : Array, optional
        Known standard deviations of y, ``(n_points,)``.
    source : str, optional
        Where the numbers came from, for messages.

    Raises
    ------
    InputError
        Where shapes disagree or a number is not finite.
    """
    x, y = frozen(x), frozen(y)
    if x.ndim != 1 or x.shape != y.shape or len(x) == 0:
        raise InputError(
            f"x and y must be one-dimensional and equally long, not {x.shape} and {y.shape}"
        )
    if sd is not None:
        sd = frozen(np.broadcast_to(sd, y.shape))
        if not ((sd > 0) & np.isfinite(sd)).all():
            raise InputError("standard deviations must be positive and finite")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise InputError("x and y must be finite")
    labels = tuple(str(i + 1) for i in range(len(x)))
    return AxisData("y", "x", "beta", x, y, sd, labels, pixel_span(y), False, source)


def pixel_span(t: Array) -> float:
    """Span of the pixels, px; 1 where they are all the same."""
    return span_of(Domain.of(t))


def span_of(readings: Domain) -> float:
    """Span of smallest to largest pixel, px; 1 where they are the same."""
    return readings.upper - readings.lower or 1.0
