"""Hypothesis strategies: well-spread points with generated pixels."""

from __future__ import annotations

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from bayescal.polynomials.axis_data import AxisData
from tests.helpers.problems import make_axis


def settings_for(examples: int):
    """The same examples at every run, none timed."""
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow],
    )


@st.composite
def axes(draw, max_order: int = 5, spare: int = 4) -> tuple[AxisData, int]:
    """Points of a noisy polynomial, and an order they determine well.

    Regressors are jittered Chebyshev points, for which the condition number of the
    Legendre columns stays below about 100.
    """
    order = draw(st.integers(1, max_order))
    n = draw(st.integers(order + 1 + spare, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    s = -np.cos(np.pi * (np.arange(n) + 0.5 + rng.uniform(-0.3, 0.3, n)) / n)
    lower = draw(st.floats(-3, 3))
    width = draw(st.floats(0.01, 10))
    noise = 10 ** draw(st.floats(-1, 2))
    truth = rng.normal(0, 1, order + 1) * np.r_[300, 300, np.full(order - 1, 10)]
    t = 500 + np.polynomial.legendre.legval(s, truth) + noise * rng.standard_normal(n)
    return make_axis(lower + width * (s + 1) / 2, t), order
