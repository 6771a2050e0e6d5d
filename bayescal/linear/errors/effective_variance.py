r"""Errors of the world coordinates, carried to pixels by the local slope.

Where the regressor x_i has an error of its own with deviation sd(x_i), the pixel's
*effective variance* is sigma_i^2 + (f'(x_i) sd(x_i))^2, f the fitted polynomial
(Orear 1982, Am. J. Phys. 50, 912); the slope and the fit are found in turn.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from bayescal.noise.world_errors import WorldErrors
from bayescal.polynomials.axis_data import AxisData

# Grid of ln sigma on which the slopes are found where sigma is inferred.
GRID = 185
ITERATIONS = 100
SETTLED = 1e-10  # largest relative change of a deviation


def with_effective_deviations(data: AxisData, sigma: Array, order: int) -> AxisData:
    """Give an axis the deviations that its pixels and world coordinates make together.

    Parameters
    ----------
    data : AxisData
        With the regressor's deviations `x_sd`.
    sigma : Array
        Deviations of the pixels alone, ``(n_points,)``, px.
    order : int
        The order whose slope carries the errors: the highest compared, so that all
        orders are judged on the same data with the same deviations.

    Raises
    ------
    InputError
        Where fit and slope do not settle.
    """
    assert data.x_sd is not None, "only where the regressor has deviations"
    sd = sigma
    for _ in range(ITERATIONS):
        weighted = dataclasses.replace(data, sd=frozen(sd))
        fit = solve(factorise(weighted, order), order, 1.0)
        domain = data.domain
        derivative = np.polynomial.legendre.legder(fit.amplitudes) / domain.half_range
        slope = np.polynomial.legendre.legval(domain.scale(data.x), derivative)
        new = np.hypot(sigma, slope * data.x_sd)
        if np.max(np.abs(new / sd - 1)) < SETTLED:
            return dataclasses.replace(data, sd=frozen(new))
        sd = new
    raise InputError(
        f"{data.source}: axis {data.axis}: the errors of the world coordinates change the fit of "
        f"order {order} so much that it does not settle; lower the order or the errors"
    )


def world_errors(data: AxisData, level: NoiseLevel, order: int) -> WorldErrors:
    """Noise of an inferred sigma beside the world's errors, whose slopes follow that sigma.

    Parameters
    ----------
    data : AxisData
        With the regressor's deviations `x_sd`, and its own where sigma is a factor on them.
    level : NoiseLevel
        Inferred.
    order : int
        As in `with_effective_deviations`.

    Raises
    ------
    InputError
        Where fit and slope do not settle.
    """
    grid = np.linspace(*level.log_bounds, GRID)
    own = data.deviations
    variance = []
    for sigma in np.exp(grid):
        found = with_effective_deviations(data, sigma * own, order).sd
        assert found is not None, "it has just been given"
        variance.append(np.maximum(found**2 - (sigma * own) ** 2, 0.0))
    return WorldErrors(frozen(grid), frozen(np.array(variance)))
