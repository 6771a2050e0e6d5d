"""A place of the image, and how sure the projection is there."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Uncertainty of the projection at a place of the image, px.

    Attributes
    ----------
    infinity, near : float or None
        Standard deviation, root mean square of r and c, of a point at infinity and of one at the
        target's distance; None where the lens sees nothing there.
    jackknife, halves : float or None
        The same at infinity from the spread over views: each left out in turn, and by how much
        more than their own posteriors allow the fits to two halves of the views lie apart.
    """

    name: str
    pixel: tuple[float, float]
    infinity: float | None
    near: float | None
    jackknife: float | None
    halves: float | None
