"""Least squares, and the M-estimate that forgives single points: where modes are looked for."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array

# Steps of the robust fit that starts are taken from, and the Cauchy weight's tuning
# constant (95 % efficient under Gaussian noise; Holland & Welsch 1977).
STEPS, CAUCHY = 50, 2.385
# The median absolute deviation of a normal, in sigma.
MAD = 0.6744897501960817


def plain_fits(x: Array, y: Array) -> list[tuple[Array, float]]:
    """Amplitudes and scale by least squares, and by Cauchy's M-estimator."""
    fits: list[tuple[Array, float]] = []
    root = np.ones(len(y))
    for step in range(STEPS):
        amplitudes = np.linalg.lstsq(x * root[:, None], y * root, rcond=None)[0]
        residual = y - x @ amplitudes
        if step == 0:
            fits.append((amplitudes, float(np.sqrt(np.mean(residual**2)))))
        scale = float(np.median(np.abs(residual))) / MAD
        if scale == 0:
            break
        root = 1 / np.sqrt(1 + (residual / (CAUCHY * scale)) ** 2)
    return [*fits, (amplitudes, scale)]
