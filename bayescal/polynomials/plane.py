"""Polynomials of two regressors, nested by total degree, in a Legendre product basis.

The columns of total degree d are P_d(s) P_0(t), P_{d-1}(s) P_1(t), ... P_0(s) P_d(t),
s and t the two regressors scaled to their domains; those of an order k are all with
d <= k, so that a lower order's lead a higher one's.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from bayescal.arrays import Array
from bayescal.polynomials.basis import (
    Domain,
    MonomialMap,
    apply_exactly,
    legendre_design,
    legendre_rows,
)


def powers(order: int) -> tuple[tuple[int, int], ...]:
    """Degrees in the two regressors of every column, by total degree.

    Examples
    --------
    >>> powers(2)
    ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    """
    return tuple((d - j, j) for d in range(order + 1) for j in range(d + 1))


def plane_columns(order: int) -> int:
    """Count the monomials of total degree up to an order."""
    return (order + 1) * (order + 2) // 2


def plane_design(s: Array, t: Array, order: int) -> Array:
    """Design matrix of Legendre products, ``(n_points, (order + 1)(order + 2) / 2)``.

    Parameters
    ----------
    s, t : Array
        The two scaled regressors, ``(n_points,)``.
    order : int
        Highest total degree.
    """
    first, second = np.array(powers(order)).T
    return legendre_design(s, order)[:, first] * legendre_design(t, order)[:, second]


def plane_rows(s: Array, t: Array, order: int) -> Array:
    """Give the design's columns one after the other in memory, as `legendre_rows`."""
    first, second = np.array(powers(order)).T
    return np.asarray(legendre_rows(s, order)[first] * legendre_rows(t, order)[second])


def plane_change(one: Array, other: Array, order: int) -> Array:
    """Matrix of ``design on new = design on old @ T``, of those of each regressor.

    Upper triangular as they are (`bayescal.polynomials.basis.basis_change`): no product's degrees
    rise, so that a column is made of itself and of those of lower total degree.
    """
    first, second = np.array(powers(order)).T
    return np.asarray(one[np.ix_(first, first)] * other[np.ix_(second, second)])


@dataclass(frozen=True)
class PlaneMap:
    """The linear map from product amplitudes to coefficients of w^i u^j.

    The exact map of each regressor's polynomials (`MonomialMap`), multiplied.

    Attributes
    ----------
    first, second : Domain
        Of the two regressors.
    order : int
        Highest total degree.
    """

    first: Domain
    second: Domain
    order: int

    @cached_property
    def exact(self) -> list[list[Fraction]]:
        """Exact matrix, square in the number of columns."""
        one, other = (MonomialMap(d, self.order).exact for d in (self.first, self.second))
        pairs = powers(self.order)
        return [[one[i][k] * other[j][m] for k, m in pairs] for i, j in pairs]

    @cached_property
    def matrix(self) -> Array:
        """The map rounded to doubles."""
        return np.array([[float(entry) for entry in row] for row in self.exact])

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Powers of the two regressors: ``("00", "10", "01", ...)``."""
        joint = "," if self.order > 9 else ""
        return tuple(f"{i}{joint}{j}" for i, j in powers(self.order))

    def columns(self, order: int) -> int:
        """Count the coefficients of an order."""
        return plane_columns(order)

    def apply(self, amplitudes: Array) -> Array:
        """Coefficients of one set of amplitudes, rounded once at the end, px.

        Parameters
        ----------
        amplitudes : Array
            ``(p,)``, or ``(p, m)`` column by column, px.
        """
        return apply_exactly(self.exact, amplitudes)

    def lead(self, order: int) -> Array:
        """Matrix of a lower order: the leading block."""
        p = plane_columns(order)
        return self.matrix[:p, :p]
