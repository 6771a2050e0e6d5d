"""Whether the recommended order is enough: how far those that stay plausible lie from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bayescal.arrays import Array
from bayescal.linear.differences import amplitude_draws, largest_differences
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData

if TYPE_CHECKING:
    from bayescal.comparison.orders.result import OrderResult

PROBABILITY = 0.95
# Where no tolerance is stated: this share of the noise level.
QUARTER = 0.25


@dataclass(frozen=True)
class Difference:
    """Largest difference of another order's curve from the recommended one's.

    Attributes
    ----------
    largest : float
        With 95 % probability no more than this anywhere in the domain, px.
    """

    order: int
    largest: float


@dataclass(frozen=True)
class Sufficiency:
    """How far the orders that can't be excluded lie from the recommended one.

    Attributes
    ----------
    tolerance : float
        What is small enough, px.
    stated : bool
        Whether the user stated it; else it is a quarter of the noise level.
    differences : tuple of Difference
        Of the other orders of the plausible set, the most probable first.
    suffix : str
        Unit behind a number, with its space.
    """

    tolerance: float
    stated: bool
    differences: tuple[Difference, ...]
    suffix: str = " px"

    @property
    def largest(self) -> float:
        """Of all differences the largest, px; 0 where no other order is plausible."""
        return max((d.largest for d in self.differences), default=0.0)

    @property
    def enough(self) -> bool:
        """Whether no plausible order differs by more than the tolerance."""
        return self.largest <= self.tolerance


def sufficiency(
    data: AxisData,
    noise: NoiseLevel,
    results: Sequence[OrderResult],
    plausible: Sequence[int],
    *,
    tolerance: float | None,
    triangle: Array,
) -> Sufficiency | None:
    """Compare the curves of the plausible orders with the recommended one's.

    Of two orders the larger one's posterior says how far the smaller is from it, once the
    smaller is fitted to the larger one's curve at the same points.

    Parameters
    ----------
    plausible : sequence of int
        Orders of the plausible set, the recommended one first.
    tolerance : float or None
        As stated, px.
    triangle : Array
        R of the weighted design at the highest plausible order or above.

    Returns
    -------
    Sufficiency or None
        None where no order is recommended.
    """
    if not plausible:
        return None
    known = {r.order: r for r in results}
    best, *others = plausible
    found = []
    for order in others:
        large, small = known[max(best, order)], min(best, order)
        sizes = largest_differences(triangle, _amplitudes(large), small)
        found.append(Difference(order, float(np.quantile(sizes, PROBABILITY))))
    level = noise_of(data, noise, known[best])
    enough = QUARTER * level if tolerance is None else tolerance
    return Sufficiency(enough, tolerance is not None, tuple(found), data.suffix)


def noise_of(data: AxisData, noise: NoiseLevel, result: OrderResult) -> float:
    """Noise level of an order: known, the points' median one, or the posterior's mean, px."""
    points = 1.0 if data.sd is None else float(np.median(data.sd))
    if noise.value is not None:
        return noise.value * points
    if result.exact is not None:
        means, _ = result.exact.summary
        return points * float(means[result.exact.model.names.index(noise.parameter)])
    return points * result.posterior[noise.parameter].mean


def _amplitudes(result: OrderResult) -> Array:
    """Draws of the Legendre amplitudes: from the closed form, else from the chain, px."""
    if result.exact is not None:
        return amplitude_draws(result.exact, np.random.default_rng(result.order))
    theta = result.posterior.chain.theta
    return np.asarray(theta.reshape(-1, theta.shape[-1])[:, : result.order + 1])
