r"""Priors of the Legendre amplitudes, in pixels.

``field`` (the default): b_0 ~ N(size/2, (size/2)^2), b_1 ~ N(0, (size/2)^2) and,
for j >= 2, b_j ~ N(0, (tau size)^2), with tau log-uniform from 0.01 px / size to 0.5,
common to the coefficients of a model and inferred, or fixed. ``flat``: uniform and
improper, so that there is no evidence. ``stated``: the user's own normal prior
of each amplitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.points.pixel import FLOOR
from bayescal.points.setup import StatedPrior

# Largest inferred tau, as a fraction of the image.
LARGEST_TAU = 0.5
# What a fixed tau may be.
FIXED_TAU = (1e-9, 1e9)


def tau_bounds(size: float, pixel: float = 1.0) -> tuple[float, float]:
    """Bounds of an inferred tau, as fractions of the image; ln tau is uniform between them.

    The lower one is that of sigma: a tau that starts higher takes a distortion between the
    noise and that start for none at all, and is sure of it.

    Parameters
    ----------
    size : float
        Image size along the axis, or the span that stands for it.
    pixel : float, optional
        What stands for a pixel.
    """
    return FLOOR * pixel / size, LARGEST_TAU


def check_tau(tau: float) -> None:
    """Refuse a fixed strength that leaves no distortion, or no prior.

    Raises
    ------
    InputError
    """
    low, high = FIXED_TAU
    if not low <= tau <= high:
        raise InputError(f"tau must be from {low:g} to {high:g} of the image, not {tau:g}")


@dataclass(frozen=True, eq=False)
class CoefficientPrior:
    """Independent normal priors of the amplitudes b_0 ... b_k, or a flat one.

    Attributes
    ----------
    name : str
        ``"field"``, ``"stated"`` or ``"flat"``.
    mean : Array
        Means, ``(n_coefficients,)``, px.
    sd : Array
        Standard deviations, ``(n_coefficients,)``, px; where `scaled` is true,
        of tau = 1.
    scaled : Array of bool
        Which standard deviations are multiplied by tau.
    size : float
        Image size along the axis (or the span that stands for it), px.
    tau : float or None
        tau where it is fixed; None where it is inferred or has no part.
    pixel : float
        What stands for a pixel (`bayescal.points.pixel`): the lower bound of an inferred tau
        is a hundredth of it.
    """

    name: str
    mean: Array
    sd: Array
    scaled: NDArray[np.bool_]
    size: float
    tau: float | None = None
    pixel: float = 1.0

    @property
    def proper(self) -> bool:
        """Whether the prior integrates to 1, so that an evidence exists."""
        return self.name != "flat"

    @property
    def infers_tau(self) -> bool:
        """Whether tau is a parameter of the model."""
        return bool(self.scaled.any()) and self.tau is None

    @property
    def log_tau_bounds(self) -> tuple[float, float]:
        """Bounds of ln tau."""
        lower, upper = tau_bounds(self.size, self.pixel)
        return math.log(lower), math.log(upper)

    def deviations(self, log_tau: Array) -> Array:
        """Give the standard deviations at each tau, ``(n_tau, n_coefficients)``, px.

        Parameters
        ----------
        log_tau : Array
            ln tau, ``(n_tau,)``; ignored by coefficients it does not scale.
        """
        deviations: Array = np.where(self.scaled, np.exp(log_tau)[:, None] * self.sd, self.sd)
        return deviations

    def log_tau_density(self) -> float:
        """Log density of ln tau inside its bounds; 0 where tau is no parameter."""
        if not self.infers_tau:
            return 0.0
        lower, upper = self.log_tau_bounds
        return -math.log(upper - lower)


@dataclass(frozen=True)
class PriorRule:
    """Makes the prior of any order on one axis.

    Attributes
    ----------
    name : str
        ``"field"``, ``"stated"`` or ``"flat"``.
    size : float
        Image size along the axis, or the span that stands for it, px.
    centre : float
        Mean of b_0 under ``field``, px.
    tau : float or None
        tau where it is fixed.
    stated : StatedPrior or None
        The user's own means and deviations.
    pixel : float
        What stands for a pixel (`bayescal.points.pixel`).
    """

    name: str
    size: float
    centre: float
    tau: float | None = None
    stated: StatedPrior | None = None
    pixel: float = 1.0

    def __post_init__(self) -> None:
        if self.name not in ("field", "stated", "flat"):
            raise InputError(f"prior must be field, stated or flat, not {self.name!r}")
        if self.name == "stated" and self.stated is None:
            raise InputError(
                "no prior is stated for this axis; add [prior.r] and [prior.c] to the setup file"
            )
        if self.tau is not None:
            if not self.scaled:
                raise InputError(f"tau belongs to the field prior; the prior here is {self.name}")
            check_tau(self.tau)

    @property
    def proper(self) -> bool:
        """Whether its priors integrate to 1, so that an evidence exists."""
        return self.name != "flat"

    @property
    def scaled(self) -> bool:
        """Whether tau is a part of it."""
        return self.name == "field"

    @property
    def reach(self) -> int | None:
        """Highest order of one regressor that it has a prior of; None: any."""
        if self.name != "stated" or self.stated is None:
            return None
        return len(self.stated.mean) - 1

    @property
    def tau_bounds(self) -> tuple[float, float]:
        """Bounds of an inferred tau, fractions of the image."""
        return tau_bounds(self.size, self.pixel)

    def of_order(self, order: int) -> CoefficientPrior:
        """Prior of the amplitudes of one order of a polynomial of one regressor.

        Raises
        ------
        InputError
            Where a stated prior does not reach the order.
        """
        return self.of_degrees(tuple(range(order + 1)))

    def of_degrees(self, degrees: tuple[int, ...]) -> CoefficientPrior:
        """Prior of amplitudes of given total degrees, ascending.

        Raises
        ------
        InputError
            Where a stated prior has fewer entries.
        """
        size, order = len(degrees), degrees[-1]
        none = np.zeros(size, dtype=bool)
        if not self.proper:
            return CoefficientPrior(
                "flat", frozen(np.zeros(size)), frozen(np.full(size, np.inf)), none, self.size
            )
        if self.stated is not None and self.name == "stated":
            if len(self.stated.mean) < size:
                raise InputError(
                    f"the stated prior has {len(self.stated.mean)} entries but order {order} has "
                    f"{size} coefficients; state one for each in the setup's [prior.r], [prior.c]"
                )
            return CoefficientPrior(
                "stated",
                frozen(self.stated.mean[:size]),
                frozen(self.stated.sd[:size]),
                none,
                self.size,
            )
        mean = np.zeros(size)
        mean[0] = self.centre
        sd = np.full(size, self.size)
        strong = np.array(degrees) >= 2
        sd[~strong] = self.size / 2
        return CoefficientPrior(
            "field", frozen(mean), frozen(sd), strong, self.size, self.tau, self.pixel
        )
