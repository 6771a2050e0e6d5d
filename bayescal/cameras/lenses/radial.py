"""Radial and tangential distortion: Brown-Conrady, opencv4 and opencv5."""

from __future__ import annotations

from bayescal.cameras.lenses.planar import Planar
from bayescal.errors import InputError

LARGEST_ORDER = 6


def radial(order: int = 2, tangential: bool = True, step: int = 2) -> Planar:
    """Polynomial in w^2 of `order` coefficients (in w for step 1); p1 and p2 if `tangential`.

    Raises
    ------
    InputError
        Where the order is not 0 to 6.
    """
    if not 0 <= order <= LARGEST_ORDER:
        raise InputError(f"order {order} of lens radial: use 0 to {LARGEST_ORDER}")
    return Planar("radial", order, 0, tangential, step=step)
