"""Thin-prism distortion, s1 to s4, over radial or rational terms; opencv12."""

from __future__ import annotations

from bayescal.cameras.lenses.planar import Planar
from bayescal.cameras.lenses.radial import LARGEST_ORDER
from bayescal.errors import InputError


def thin_prism(order: int = 2, tangential: bool = True, rational: bool = False) -> Planar:
    """Thin prism over `order` radial coefficients, with k4, k5, k6 below the line if `rational`.

    Raises
    ------
    InputError
        Where the order is not 0 to 6, or not 3 if `rational`.
    """
    if not 0 <= order <= LARGEST_ORDER or (rational and order != 3):
        allowed = "3" if rational else f"0 to {LARGEST_ORDER}"
        raise InputError(f"order {order} of lens thin-prism: use {allowed}")
    return Planar("thin-prism", order, 3 if rational else 0, tangential, prism=True)
