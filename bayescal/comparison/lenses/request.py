"""What is asked for of lens models."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LensRequest:
    """Which lens models are compared, and what else is held.

    Attributes
    ----------
    lenses : tuple of str or None
        As the user names them; None to have them found.
    independent : bool
        Whether noise is taken as independent and the target as exact.
    square, centred : bool
        Whether fx = fy; whether the principal point stays in the middle.
    draws : int
        Importance draws of each lens.
    per_view : bool
        Whether each view has a noise level of its own, settled before a lens is judged.
    """

    lenses: tuple[str, ...] | None = None
    independent: bool = False
    square: bool = False
    centred: bool = False
    draws: int = 2000
    per_view: bool = False
