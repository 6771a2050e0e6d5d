r"""The Legendre basis on a domain, and its exact map to monomials.

Coefficients are worked with as Legendre amplitudes b_j (px at the edge of the
domain) and reported as monomial coefficients alpha_j of regressor^j. The map
between the two is linear. It is computed here in rational arithmetic, because in
doubles it costs several digits (NIST's Filip: 13.8 correct digits become 7.4 when
raw monomials are solved for).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from operator import mul
from typing import Protocol

import numpy as np

from bayescal.arrays import Array

# Regressors closer than this fraction of the domain count as the same value.
SAME_REGRESSOR = 1e-9


@dataclass(frozen=True)
class Domain:
    """The interval [lower, upper] of a regressor, mapped to s in [-1, 1]."""

    lower: float
    upper: float

    @classmethod
    def of(cls, x: Array) -> Domain:
        """Domain that the values `x`, ``(n_points,)``, span."""
        return cls(float(x.min()), float(x.max()))

    @property
    def middle(self) -> float:
        """Centre of the domain, where s = 0."""
        return self.lower + (self.upper - self.lower) / 2

    @property
    def half_range(self) -> float:
        """Half the domain's width."""
        return (self.upper - self.lower) / 2

    def scale(self, x: Array) -> Array:
        """Map regressor values to s; values beyond the domain go beyond [-1, 1]."""
        return (x - self.middle) / self.half_range


def distinct_values(x: Array) -> int:
    """Count the regressor values that differ by more than 1e-9 of the domain."""
    ordered = np.sort(x)
    width = ordered[-1] - ordered[0]
    rounding = 8 * np.finfo(float).eps * float(np.abs(ordered[[0, -1]]).max())
    return 1 + int((np.diff(ordered) > max(SAME_REGRESSOR * width, rounding)).sum())


def legendre_design(s: Array, order: int) -> Array:
    """Design matrix of Legendre polynomials, ``(n_points, order + 1)``.

    Parameters
    ----------
    s : Array
        Scaled regressor, ``(n_points,)``; complex numbers pass, for complex steps.
    order : int
        Highest polynomial degree.
    """
    return np.asarray(np.polynomial.legendre.legvander(s, order))


def legendre_rows(s: Array, order: int) -> Array:
    """Give the design's columns one after the other in memory, ``(order + 1, n_points)``.

    Twice as fast as `legendre_design`, which lays them out point by point.
    """
    rows = np.empty((order + 1, len(s)))
    rows[0] = 1.0
    if order:
        rows[1] = s
    for k in range(1, order):
        # Bonnet's recursion: (k + 1) P_{k+1} = (2k + 1) s P_k - k P_{k-1}.
        np.multiply(rows[k], s, out=rows[k + 1])
        rows[k + 1] *= (2 * k + 1) / (k + 1)
        rows[k + 1] -= k / (k + 1) * rows[k - 1]
    return rows


def basis_change(old: Domain, new: Domain, order: int) -> Array:
    """Matrix T of ``design on new = design on old @ T``, ``(order + 1, order + 1)``.

    Upper triangular. Where `new` holds `old` no entry is larger than its column's degree asks:
    the polynomials of a wider domain stay within 1 on the narrower one.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order + 1)
    wider = new.scale(old.middle + old.half_range * nodes)
    projected = legendre_rows(nodes, order) * weights @ legendre_rows(wider, order).T
    return np.triu((2 * np.arange(order + 1)[:, None] + 1) / 2 * projected)


class PolynomialMap(Protocol):
    """From the amplitudes of a nested polynomial basis to coefficients of monomials."""

    @property
    def order(self) -> int:
        """The highest order mapped."""
        ...

    @property
    def suffixes(self) -> tuple[str, ...]:
        """What follows a coefficient's symbol: its powers, column by column."""
        ...

    def columns(self, order: int) -> int:
        """Count the coefficients of an order, which lead those of any higher one."""
        ...

    def apply(self, amplitudes: Array) -> Array:
        """Coefficients of one set of amplitudes, or of sets in columns, px."""
        ...

    def lead(self, order: int) -> Array:
        """Matrix of an order up to the highest, ``(columns, columns)``."""
        ...


@dataclass(frozen=True)
class MonomialMap:
    """The linear map from Legendre amplitudes on a domain to monomial coefficients.

    ``alpha = matrix @ b``: alpha_j multiplies regressor^j.
    """

    domain: Domain
    order: int

    @cached_property
    def exact(self) -> list[list[Fraction]]:
        """Exact matrix, ``(order + 1, order + 1)``: row j, column k is d alpha_j / d b_k."""
        half = Fraction(self.domain.half_range)
        s = [-Fraction(self.domain.middle) / half, 1 / half]  # s as a polynomial of x
        columns = [[Fraction(1)], s]
        for k in range(1, self.order):
            # Bonnet's recursion: (k + 1) P_{k+1} = (2k + 1) s P_k - k P_{k-1}.
            rise = _product(s, columns[k])
            previous = columns[k - 1] + [Fraction(0)] * 2
            columns.append(
                [((2 * k + 1) * a - k * b) / (k + 1) for a, b in zip(rise, previous, strict=True)]
            )
        size = self.order + 1
        padded = [column + [Fraction(0)] * (size - len(column)) for column in columns[:size]]
        return [[padded[k][j] for k in range(size)] for j in range(size)]

    @cached_property
    def matrix(self) -> Array:
        """The map rounded to doubles, ``(order + 1, order + 1)``."""
        return np.array([[float(entry) for entry in row] for row in self.exact])

    def apply(self, amplitudes: Array) -> Array:
        """Monomial coefficients of one set of amplitudes, rounded once at the end.

        Parameters
        ----------
        amplitudes : Array
            b_0 to b_k, ``(k + 1,)`` or ``(k + 1, m)`` column by column, px.

        Returns
        -------
        Array
            alpha_0 to alpha_k, of the same shape, px.
        """
        return apply_exactly(self.exact, amplitudes)

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Powers of the regressor: ``("0", "1", ...)``."""
        return tuple(str(j) for j in range(self.order + 1))

    def columns(self, order: int) -> int:
        """Count the coefficients of an order."""
        return order + 1

    def lead(self, order: int) -> Array:
        """Matrix of a lower order: the leading block, ``(order + 1, order + 1)``."""
        return self.matrix[: order + 1, : order + 1]


def apply_exactly(exact: list[list[Fraction]], amplitudes: Array) -> Array:
    """Multiply by the leading block of an exact matrix, rounding once at the end.

    Parameters
    ----------
    exact : list of list of Fraction
        At least as large as the amplitudes are many.
    amplitudes : Array
        ``(p,)``, or ``(p, m)`` column by column.
    """
    size = len(amplitudes)
    rows = [_integers(row[:size]) for row in exact[:size]]
    columns = [_integers(column) for column in np.reshape(amplitudes, (size, -1)).T.tolist()]
    # Sums of integers, divided once: Python rounds a quotient of integers correctly.
    mapped = [
        [sum(map(mul, row, column)) / (whole * part) for row, whole in rows]
        for column, part in columns
    ]
    return np.array(mapped).T.reshape(amplitudes.shape)


def _integers(numbers: Sequence[float | Fraction]) -> tuple[list[int], int]:
    """Numerators of numbers over a common denominator, and it."""
    ratios = [number.as_integer_ratio() for number in numbers]
    whole = math.lcm(*(below for _, below in ratios))
    return [above * (whole // below) for above, below in ratios], whole


def _product(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return out
