"""Log density of each pixel under draws of a linear model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bayescal.arrays import LOG_2PI, Array
from bayescal.linear.closed_form import ExactPosterior
from bayescal.polynomials.axis_data import AxisData


def gaussian_density(data: AxisData, exact: ExactPosterior) -> Callable[[Array], Array]:
    """Log density of each pixel given draws of a linear model, ``(n_draws, n_points)``."""
    model = exact.model
    design, sd = data.design(model.order), data.deviations

    def density(theta: Array) -> Array:
        if model.infers_sigma:
            log_sigma = theta[:, model.size, None]
        else:
            log_sigma = np.full((len(theta), 1), np.log(exact.sigma[0]))
        z = (data.t - theta[:, : model.size] @ design.T) / sd * np.exp(-log_sigma)
        return np.asarray(-(z**2 + LOG_2PI) / 2 - log_sigma - np.log(sd))

    return density
