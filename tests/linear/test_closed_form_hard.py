"""Evidence where scales differ: many points, as many as coefficients, conflict, bounds.

The truth is the brute-force grid of `normal_grid`, with panels as fine as the case
needs; `brute_error` allows for its rounding, some tens of eps of the log evidence.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import lu_solve, matrix, mp, mpf, workdps
from numpy.polynomial.legendre import legval

from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.polynomials.axis_data import AxisData
from tests.helpers.brute_force import Grid, normal_grid
from tests.helpers.exact_least_squares import DIGITS
from tests.helpers.problems import legendre_columns, make_axis, make_model, prior_deviations


def points(n: int, amplitudes, noise: float, seed: int = 5) -> AxisData:
    """A Legendre polynomial with Gaussian noise, on a 1000 px image."""
    rng = np.random.default_rng(seed)
    s = np.sort(rng.uniform(-1, 1, n))
    s[0], s[-1] = -1, 1
    return make_axis(s, legval(s, amplitudes) + noise * rng.standard_normal(n))


def check(exact: ExactPosterior, grid: Grid) -> None:
    """To 1e-6 nat, and within the claimed error."""
    difference = abs(exact.log_evidence - grid.log_evidence)
    brute_error = 1e-9 + 1e-14 * abs(grid.log_evidence)
    assert difference < 1e-6
    assert difference < exact.log_evidence_error + brute_error


@pytest.mark.parametrize(("order", "level"), [(1, 2.6), (3, 1.3)])
def test_a_hundred_thousand_points(order, level):
    """The peak in ln sigma is 0.002 wide; the grid spans a hundred widths about it."""
    data = points(100_000, [480, 300, 5, 1], 1.3)
    model = make_model(data, order)
    near = (np.log(level) - 0.5, np.log(level) + 0.5)
    check(exact_posterior(model), normal_grid(model, data, 0.004, near))


def test_a_hundred_thousand_points_at_any_noise_level():
    """Wherever the narrow peak lies between the first nodes, it must be found."""
    n = 100_000
    x = np.linspace(-1, 1, n)
    z = np.random.default_rng(1).standard_normal(n)
    for noise in np.exp(np.linspace(np.log(0.3), np.log(6), 60)):
        data = make_axis(x, 500 + 300 * x + noise * z)
        model = make_model(data, 1)
        near = (np.log(noise) - 0.03, np.log(noise) + 0.03)
        check(exact_posterior(model), normal_grid(model, data, 0.004, near))


@pytest.mark.parametrize("tau", [None, 0.05])
@pytest.mark.parametrize("n", [2, 4, 6, 9])
def test_as_many_points_as_coefficients(n, tau):
    """No residual is left: only the prior and sigma's lower bound hold sigma up."""
    data = points(n, [480, 300, 5, 1], 0.5)
    model = make_model(data, n - 1, tau=tau)
    check(exact_posterior(model), normal_grid(model, data))


def test_order_10():
    data = points(60, [480, 300, 20, 10, 5, 5, 4, 3, 2, 1, 1], 0.5)
    model = make_model(data, 10)
    check(exact_posterior(model), normal_grid(model, data))


@pytest.mark.parametrize("order", [15, 20])
def test_highest_orders_with_tau_well_determined(order):
    """14 and 19 amplitudes of 20 px leave ln tau a peak a fifth of a unit wide."""
    rng = np.random.default_rng(8)
    data = points(60, [480, 300, *rng.normal(0, 20, order - 1)], 0.5)
    model = make_model(data, order)
    check(exact_posterior(model), normal_grid(model, data, sigma_range=(-3, 3)))


@pytest.mark.parametrize("amplitude", [6.0, 11.0, 12.5, 14.0, 40.0])
def test_prior_in_conflict_with_the_data(amplitude):
    """tau fixed at 0.001 (1 px) against a true b_2 of 6 to 40 px."""
    data = points(20, [500, 300, amplitude], 0.1)
    model = make_model(data, 2, tau=0.001)
    check(exact_posterior(model), normal_grid(model, data, 0.05))


def test_two_modes_in_sigma_are_both_weighed():
    """At b_2 = 12 px both readings stand: tiny noise, or noise that hides the curve."""
    data = points(20, [500, 300, 12.0], 0.1)
    model = make_model(data, 2, tau=0.001)
    grid = normal_grid(model, data, 0.02)
    low = grid.weights.sum(axis=0)[grid.log_sigma < 0].sum()
    assert 1e-4 < low < 1 - 1e-4  # the case is what it says
    exact = exact_posterior(model)
    ((sigma, mass),) = exact.hyperparameters
    check(exact, grid)
    assert mass[sigma < 1].sum() == pytest.approx(low, rel=1e-6)


def marginal_in_80_digits(model: LinearModel, data: AxisData, sigma: float, tau: float) -> float:
    """ln N(t; X m, sigma^2 I + X S X'), everything formed from the doubles in mpmath."""
    with workdps(DIGITS):
        lower, upper = mpf(float(data.x.min())), mpf(float(data.x.max()))
        s = [(2 * mpf(float(v)) - lower - upper) / (upper - lower) for v in data.x]
        scale = [mpf(float(v)) for v in prior_deviations(model.prior, tau)]
        scaled = matrix(len(s), model.size)
        for i, v in enumerate(s):
            for j in range(model.size):
                scaled[i, j] = scale[j] * mp.legendre(j, v)
        covariance = scaled * scaled.T
        for i in range(len(s)):
            covariance[i, i] += mpf(sigma) ** 2
        root = mp.cholesky(covariance)
        offset = matrix([mpf(float(t)) - mpf(float(model.prior.mean[0])) for t in data.t])
        z = lu_solve(root, offset)
        log_det = mp.fsum(mp.log(root[i, i]) for i in range(len(s)))
        return float(-mp.fdot(z, z) / 2 - log_det - len(s) * mp.log(2 * mp.pi) / 2)


@pytest.mark.parametrize("sigma", [0.05, 2.0, 400.0])
@pytest.mark.parametrize("tau", [0.0003, 0.05])
def test_clumped_points_keep_the_digits_that_normal_equations_lose(sigma, tau):
    """Columns of condition above 1e4; the truth has 80 digits, so only the package rounds.

    Where it matters it rounds like eps of the largest term, the misfit over sigma^2.
    """
    rng = np.random.default_rng(3)
    x = np.append(np.linspace(0, 0.3, 23), 1.0)
    data = make_axis(x, 500 + 300 * x + 900 * x**2 + rng.normal(0, 2, 24))
    model = make_model(data, 7, sigma=sigma, tau=tau)
    assert np.linalg.cond(legendre_columns(data, 7)) > 1e4  # the case is what it says
    truth = marginal_in_80_digits(model, data, sigma, tau)
    found = exact_posterior(model).log_evidence
    assert found == pytest.approx(truth, abs=1e-9, rel=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 0.0099, 0.011])
def test_sigma_at_its_lower_bound(noise):
    """Noise below, or just above, the 0.01 px that sigma may have."""
    data = points(57, [480, 300, 5, 1], noise)
    model = make_model(data, 3)
    lower = np.log(0.01)
    check(exact_posterior(model), normal_grid(model, data, 0.01, (lower, lower + 1.5)))


@pytest.mark.parametrize(("noise", "span"), [(900.0, 2.0), (5e3, 0.1)])
def test_sigma_at_its_upper_bound(noise, span):
    """Noise near, or above, the 1000 px that sigma may have."""
    data = points(57, [480, 300, 5, 1], noise)
    model = make_model(data, 3)
    upper = np.log(1000)
    grid = normal_grid(model, data, span / 50, (upper - span, upper))
    check(exact_posterior(model), grid)


@pytest.mark.parametrize(("noise", "side"), [(0.0, 0), (5e3, 1)])
def test_mass_at_a_bound_is_measured(noise, side):
    """Posterior mass within 5 % of a bound, by brute force up to that edge."""
    data = points(57, [480, 300, 5, 1], noise)
    model = make_model(data, 3)
    bound = np.log(model.noise.bounds[side])
    edge = bound + (1 - 2 * side) * np.log(1.05)
    inner, outer = min(bound, edge), max(bound, edge)
    whole = (bound, bound + 1) if side == 0 else (bound - 1, bound)
    near = normal_grid(model, data, 0.01, (inner, outer)).log_evidence
    total = normal_grid(model, data, 0.01, whole).log_evidence
    found = exact_posterior(model).sigma_at_bounds()
    # The rule's mass up to a node: half a node's weight, 5 % / 13 of the edge's mass.
    assert found[side] == pytest.approx(np.exp(near - total), rel=0.02)
    assert found[1 - side] < 1e-12
