r"""The thesis's own models: polynomials in monomials, as written and as coded.

``as-written`` is the text: r in powers of x/z (eq. 35, 50, 52), c in powers of y/z
(eq. 36, 51, 53; the x/z and the repeated cube that eq. 53 prints are taken for the
misprints they are). ``as-coded`` is the listing of Appendix B, which builds the
third and higher powers of the *r* model from y/z::

    W1 = x./z;  W2 = (x./z).^2;  W3 = (y./z).^3;  W4 = (y./z).^4;  W5 = (y./z).^5;

For c, and for r up to order 2, the two are the same model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.polynomials.pixel_axis import PIXEL_AXES

AS_WRITTEN, AS_CODED = "as-written", "as-coded"
VARIANTS = (AS_WRITTEN, AS_CODED)
# The first power of the r model that the listing takes from y/z.
FIRST_SLIPPED_POWER = 3


@dataclass(frozen=True)
class ThesisModel:
    """One order of one axis, in one of the two variants.

    Attributes
    ----------
    variant : str
        ``"as-written"`` or ``"as-coded"``.
    axis : str
        ``"r"`` or ``"c"``.
    order : int
        Polynomial degree, at least 1; the thesis stops at 5.
    """

    variant: str
    axis: str
    order: int

    def __post_init__(self) -> None:
        if self.variant not in VARIANTS:
            raise InputError(f"variant must be {' or '.join(VARIANTS)}, not {self.variant!r}")
        if self.axis not in PIXEL_AXES:
            raise InputError(f"axis must be r or c, not {self.axis!r}")
        if self.order < 1:
            raise InputError(f"order must be at least 1, not {self.order}")

    @property
    def regressors(self) -> tuple[str, ...]:
        """What each power 0, 1, ... is a power of: ``"x/z"`` or ``"y/z"``."""
        own = PIXEL_AXES[self.axis].regressor
        slipped = self.variant == AS_CODED
        return tuple(
            "y/z" if slipped and power >= FIRST_SLIPPED_POWER else own
            for power in range(self.order + 1)
        )

    @property
    def monomials(self) -> tuple[str, ...]:
        """The columns of the design in words: ``("1", "x/z", "(x/z)^2", ...)``."""
        words = ["1", self.regressors[1]]
        words += [f"({name})^{power}" for power, name in enumerate(self.regressors) if power > 1]
        return tuple(words)

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Names of the coefficients: alpha_0, alpha_1, ... of r, beta_j of c."""
        symbol = PIXEL_AXES[self.axis].symbol
        return tuple(f"{symbol}_{power}" for power in range(self.order + 1))

    @property
    def slipped(self) -> bool:
        """Whether the listing's slip makes this another model than the text's."""
        return self.regressors != ThesisModel(AS_WRITTEN, self.axis, self.order).regressors

    def design(self, w: Array, u: Array) -> Array:
        """Design matrix in the listing's monomials, ``(n_points, order + 1)``.

        Parameters
        ----------
        w, u : Array
            x/z and y/z after the camera position is subtracted, ``(n_points,)``.
        """
        values = {"x/z": np.asarray(w, dtype=float), "y/z": np.asarray(u, dtype=float)}
        columns = [values[name] ** power for power, name in enumerate(self.regressors)]
        return np.column_stack(columns)
