"""Quantities that are log-uniform between bounds, as samplers see them: a probit, without edges.

The probit of where the logarithm lies between its bounds is standard normal a priori.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr, ndtri

from bayescal.arrays import LOG_2PI, Array

Bounds = tuple[float, float]


def log_value(probit: Array, log_bounds: Bounds) -> Array:
    """Logarithm at probits, of their shape."""
    low, high = log_bounds
    return np.asarray(low + (high - low) * ndtr(probit))


def probit_of(log_value: float, log_bounds: Bounds, least: float = 0.001) -> float:
    """Probit of a logarithm, kept off the bounds: from the share `least` of their distance."""
    low, high = log_bounds
    share = (log_value - low) / (high - low)
    return float(ndtri(min(max(share, least), 0.99)))


def log_prior(probit: Array) -> Array:
    """Log density of the standard normal, of the probits' shape."""
    return np.asarray(-(probit**2 + LOG_2PI) / 2)
