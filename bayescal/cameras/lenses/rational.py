"""Rational radial distortion: k1, k2, k3 over k4, k5, k6, and p1, p2; opencv8."""

from __future__ import annotations

from bayescal.cameras.lenses.planar import Planar
from bayescal.errors import InputError

LARGEST_ORDER = 3


def rational(order: int = 3, tangential: bool = True) -> Planar:
    """Ratio of polynomials in w^2, three coefficients above the line and `order` below it.

    Raises
    ------
    InputError
        Where the order is not 1 to 3.
    """
    if not 1 <= order <= LARGEST_ORDER:
        raise InputError(f"order {order} of lens rational: use 1 to {LARGEST_ORDER}")
    return Planar("rational", 3, order, tangential)
