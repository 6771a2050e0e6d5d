"""What the tests of radial distortion share: points by radius, the polynomial's terms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

EPS = np.finfo(float).eps
STEP = {"all": 1, "even": 2}


def hundredths(n):
    return n / 100


both = pytest.mark.parametrize("powers", ["all", "even"])
coefficients_of = arrays(float, st.integers(0, 6), elements=st.integers(-200, 200).map(hundredths))
# From 0 to 1 of the branch, the end included.
fractions_of = arrays(float, st.integers(0, 8), elements=st.floats(0, 1))


def on_radii(radii, angle=0.7):
    """Image points at given distances from the centre."""
    return np.asarray(radii)[:, None] * [math.cos(angle), math.sin(angle)]


def radii_of(image):
    return np.hypot(image[:, 0], image[:, 1])


def terms(k, radii, powers):
    """The terms 1, k_1 w, ... of f(w), ``(n, m + 1)``, and the factor each has in the slope."""
    degrees = STEP[powers] * np.arange(len(k) + 1)
    return np.append(1.0, k) * np.asarray(radii)[:, None] ** degrees, 1 + degrees


def coefficients_with_slope(roots, powers):
    """Coefficients whose slope is the product of 1 - t / root, t = w or w^2."""
    slope = np.array([1.0])
    for root in roots:
        slope = np.convolve(slope, [1, -1 / root])
    return slope.real[1:] / (1 + STEP[powers] * np.arange(1, len(slope)))
