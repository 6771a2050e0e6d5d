"""The two pixel axes: what each is a function of, and what is called after it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PixelAxis:
    """One of the two pixel axes.

    Attributes
    ----------
    column : int
        Of the axis among pixels (r, c), and of `across` among world coordinates.
    across : str
        World coordinate that is divided by z: ``"x"`` or ``"y"``.
    other : str
        The other axis.
    symbol : str
        Name of the coefficients.
    side : str
        Side of the image that the axis runs along.
    """

    column: int
    across: str
    other: str
    symbol: str
    side: str

    @property
    def regressor(self) -> str:
        """What the thesis's polynomials of the axis are a function of."""
        return f"{self.across}/z"


PIXEL_AXES = {
    "r": PixelAxis(0, "x", "c", "alpha", "width"),
    "c": PixelAxis(1, "y", "r", "beta", "height"),
}
