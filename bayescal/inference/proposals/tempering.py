"""Weights of draws that a proposal is fitted to: tempered until enough are effective."""

from __future__ import annotations

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array

EFFECTIVE = 0.1  # share of draws that tempering keeps effective


def effective_fraction(log_w: Array) -> float:
    """(sum w)^2 / (n sum w^2)."""
    top = float(log_w.max())
    if not np.isfinite(top):
        return 0.0
    w = np.exp(log_w - top)
    return float(w.sum() ** 2 / (w @ w) / len(w))


def tempered(log_w: Array) -> tuple[Array, bool]:
    """Normalised weights, raised to the power at which enough are effective; then truncated."""
    power, cold = 1.0, True
    while effective_fraction(power * log_w) < EFFECTIVE and power > 1e-6:
        power, cold = 0.7 * power, False
    weights = np.asarray(softmax(power * log_w))
    limit = weights.mean() * np.sqrt(len(weights))
    weights = np.minimum(weights, limit)
    return weights / weights.sum(), cold


def moments(theta: Array, weights: Array) -> tuple[Array, Array]:
    """Mean ``(dimension,)`` and covariance of weighted draws."""
    mean = weights @ theta
    offset = theta - mean
    return mean, offset.T @ (weights[:, None] * offset)
