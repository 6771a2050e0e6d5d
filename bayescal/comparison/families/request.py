"""What is asked for of joint models."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

from bayescal.comparison.key import FREE, PINHOLE, STATED
from bayescal.comparison.settings import checked_orders
from bayescal.polynomials import separable

if TYPE_CHECKING:
    from bayescal.cameras.pinhole import Radial


@dataclass(frozen=True)
class FamilyRequest:
    """Which models of r and c are wanted.

    Attributes
    ----------
    families : tuple of str
        Of ``"separable"``, ``"bivariate"``, ``"pinhole"``.
    orders : tuple of int
        Polynomial degrees, ascending; every pair of them in the separable family.
    positions : tuple of str or None
        ``"stated"``, ``"free"`` or both; None: stated, and free for a pinhole, whose
        position is part of its pose.
    radial : str
        Powers of the radius in the pinhole's distortion, ``"even"`` or ``"all"``.
    radial_orders : tuple of int
        Numbers of radial coefficients of the pinhole.
    pairs : tuple of tuple of int, or None
        The only pairs of orders, of r and c, to take in the separable family.
    """

    families: tuple[str, ...]
    orders: tuple[int, ...]
    positions: tuple[str, ...] | None = None
    radial: Radial = "even"
    radial_orders: tuple[int, ...] = (0,)
    pairs: tuple[tuple[int, int], ...] | None = None

    @classmethod
    def of_one(
        cls, family: str, orders: tuple[int, ...], position: str | None, radial: Radial
    ) -> FamilyRequest:
        """Ask for one model: its orders are of r and c in the separable family, else one.

        Raises
        ------
        InputError
            Where there is no such order.
        """
        positions = None if position is None else (position,)
        if family == PINHOLE:
            return cls((family,), (1,), positions, radial, checked_orders(orders, lowest=0))
        pairs = ((orders[0], orders[-1]),) if family == separable.NAME else None
        return cls((family,), checked_orders(orders), positions, radial, pairs=pairs)

    def positions_of(self, family: str) -> tuple[str, ...]:
        """Treatments of the position wanted of a family."""
        default = FREE if family == PINHOLE else STATED
        return tuple(dict.fromkeys(self.positions or (default,)))

    def orders_of(self, family: str) -> list[tuple[int, ...]]:
        """List the orders wanted of a family."""
        if family != separable.NAME:
            return [(k,) for k in (self.radial_orders if family == PINHOLE else self.orders)]
        return list(self.pairs if self.pairs is not None else product(self.orders, self.orders))

    @property
    def n_models(self) -> int:
        """Number of models."""
        return sum(len(self.orders_of(f)) * len(self.positions_of(f)) for f in self.families)

    @property
    def moves(self) -> bool:
        """Whether a model has a position or a pose of its own, which no closed form has."""
        return any(f == PINHOLE or FREE in self.positions_of(f) for f in self.families)
