"""tau integrated out of its amplitudes: against quadrature, down to nothing and far out."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import integrate, stats

from bayescal.prior.strength import Strength

BOUNDS = (math.log(0.001), math.log(0.5))


def log_density_by_quadrature(q, size):
    """Mpmath's integral over ln tau, of any size of exponent."""

    def density(log_tau):
        return mpmath.exp(-size * (log_tau + mpmath.log(2 * mpmath.pi) / 2)) * mpmath.exp(
            -q / 2 * mpmath.exp(-2 * log_tau)
        )

    width = BOUNDS[1] - BOUNDS[0]
    near_the_end = [BOUNDS[1] - width * 2.0**-k for k in range(4, 22)]  # where a large q has it all
    nodes = sorted([BOUNDS[0] + width * i / 20 for i in range(21)] + near_the_end)
    return float(mpmath.log(mpmath.quad(density, nodes) / (BOUNDS[1] - BOUNDS[0])))


@pytest.mark.parametrize("size", [1, 2, 4, 19])
@pytest.mark.parametrize("q", [0.0, 1e-40, 1e-9, 1e-5, 0.003, 0.2, 4.0, 60.0, 249.0, 251.0, 1e5])
def test_log_density_is_the_integral_over_ln_tau(q, size):
    """Truth: mpmath; from no amplitude at all to thousands of images."""
    found = Strength(BOUNDS, size).log_density(np.array([q]))
    assert found[0] == pytest.approx(log_density_by_quadrature(q, size), rel=1e-11, abs=1e-11)


def test_density_of_one_amplitude_integrates_to_1():
    strength = Strength(BOUNDS, 1)

    def density(log_b):
        return 2 * math.exp(strength.log_density(np.array([math.exp(2 * log_b)]))[0] + log_b)

    total, _ = integrate.quad(density, -30, 3, limit=200)
    assert total == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize(("q", "size"), [(1e-8, 1), (0.003, 3), (0.2, 3), (4.0, 5), (400.0, 2)])
def test_draws_of_tau_follow_its_conditional(q, size):
    """Kolmogorov-Smirnov against the conditional, integrated on a grid; and wrong ones fail."""
    drawn = Strength(BOUNDS, size).draw(np.full(5000, q), np.random.default_rng(1))
    grid = np.linspace(*BOUNDS, 200_001)
    log_density = -size * grid - q / 2 * np.exp(-2 * grid)
    below = integrate.cumulative_simpson(np.exp(log_density - log_density.max()), x=grid, initial=0)
    below /= below[-1]
    assert stats.kstest(np.interp(drawn, grid, below), "uniform").pvalue > 1e-4
    wrong = Strength(BOUNDS, size + 4).draw(np.full(5000, q / 3), np.random.default_rng(1))
    assert stats.kstest(np.interp(wrong, grid, below), "uniform").pvalue < 1e-4


def test_amplitudes_beyond_every_image_leave_tau_at_its_upper_bound():
    drawn = Strength(BOUNDS, 3).draw(np.array([1e6, 1e12]), np.random.default_rng(1))
    assert drawn == pytest.approx(BOUNDS[1], abs=1e-5)


# sigma of many residuals is a strength too; noiseless pixels leave it at its lower bound.
SIGMA = (math.log(0.01), math.log(1000))


@pytest.mark.parametrize("size", [57, 300, 2000])
@pytest.mark.parametrize("rms", [1e-13, 1e-6, 1e-3, 0.3, 990.0, 5e3])
def test_many_residuals_far_below_or_above_the_bounds_of_sigma(size, rms):
    """Truth: Simpson's rule over ln sigma, fine at the end that holds everything."""
    q = size * rms**2
    end, other = SIGMA if rms < 1 else SIGMA[::-1]
    grid = np.sort(end + (other - end) * np.linspace(0, 1, 200_001) ** 2)
    log_density = -size * grid - q / 2 * np.exp(-2 * grid)
    top = log_density.max()
    below = integrate.cumulative_simpson(np.exp(log_density - top), x=grid, initial=0)
    strength = Strength(SIGMA, size)
    expected = top + math.log(below[-1] / (SIGMA[1] - SIGMA[0])) - size / 2 * math.log(2 * math.pi)
    assert strength.log_density(np.array([q]))[0] == pytest.approx(expected, rel=1e-9)
    drawn = strength.draw(np.full(2000, q), np.random.default_rng(1))
    at = np.interp(drawn, grid, below / below[-1])
    assert stats.kstest(at, "uniform").pvalue > 1e-4
