"""Which candidate: the one name that a model's draws and random numbers belong to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.noise import NAMES
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.world_errors import WorldErrors
from bayescal.points.setup import AXES
from bayescal.polynomials import bivariate, separable

STATED, FREE = "stated", "free"
PINHOLE = "pinhole"  # the family without a closed form
POLYNOMIAL = "polynomial"  # of y over x, without any camera
# Their places here, and those of the noise models, are part of the random numbers' seeds.
FAMILIES = (separable.NAME, bivariate.NAME, PINHOLE)
_NOISES = (*NAMES[:3], WorldErrors.name, *NAMES[3:])  # in the order that they came in


@dataclass(frozen=True)
class Key:
    """Which model of the observations, wherever it is shown.

    Attributes
    ----------
    orders : tuple of int
        Of r and of c in the separable family, else one.
    position : str
        ``"stated"`` or ``"free"``.
    noise : str
        Name of the noise model.
    axis : str or None
        Of one axis; None: joint, of r and c.
    """

    family: str
    orders: tuple[int, ...]
    position: str = STATED
    noise: str = GAUSSIAN.name
    axis: str | None = None

    @classmethod
    def of_axis(cls, axis: str, order: int, noise: str, family: str = separable.NAME) -> Key:
        """Name one order of one axis at the stated position."""
        return cls(family if axis in AXES else POLYNOMIAL, (order,), STATED, noise, axis)

    @property
    def order(self) -> str:
        """The order in words: ``"4, 1"`` or ``"2"``."""
        return ", ".join(str(k) for k in self.orders)

    def file(self, usual: str = GAUSSIAN.name) -> str:
        """Name of its draws in a run, which leaves out a noise that is `usual` there."""
        orders = [str(k) for k in self.orders]
        noise = [] if self.noise == usual else [self.noise]
        if self.axis is None:
            return "-".join([self.family, *orders, self.position, *noise])
        family = [] if self.family in (separable.NAME, POLYNOMIAL) else [self.family]
        return "-".join([self.axis, *family, *noise, "order", *orders])

    def rng(self, seed: int, *further: int) -> np.random.Generator:
        """Random numbers of its own, which no other candidate changes; `further` ones beside."""
        place = self._place + further
        if self.noise != GAUSSIAN.name:
            place = (9 + _NOISES.index(self.noise), *place)
        return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=place))

    @property
    def _place(self) -> tuple[int, ...]:
        """Place of its random numbers in the tree that grows from a seed."""
        axis = AXES.index(self.axis) if self.axis in AXES else 0
        if self.family in (separable.NAME, POLYNOMIAL) and self.axis is not None:
            return axis, *self.orders
        family = 2 + FAMILIES.index(self.family)
        if self.axis is not None:
            return family, 2 + axis, *self.orders
        return family, int(self.position == FREE), *self.orders

    def __str__(self) -> str:
        if self.axis is not None:
            return f"order {self.order}"
        order = f"({self.order})" if len(self.orders) > 1 else self.order
        return f"{self.family} {order}, position {self.position}"
