"""Modes of densities whose modes and curvatures are known."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.inference.optimum import find_modes
from tests.helpers.known_densities import LOG_Z, HalfSpace, Known, Normal, TwoModes


@pytest.mark.parametrize("dimension", [1, 2, 6, 12])
def test_laplace_of_a_normal_is_exact(dimension):
    model = Normal(dimension)
    (mode,) = find_modes(model.log_prob, model.starts())
    z = np.linalg.solve(model.root, mode.theta - model.mean)
    assert np.abs(z).max() < 1e-3
    # A quadratic's finite differences are exact but for rounding, about eps |log p| / DROP.
    np.testing.assert_allclose(
        np.linalg.solve(model.root, mode.root @ mode.root.T) @ np.linalg.inv(model.root.T),
        np.eye(dimension),
        atol=1e-6,
    )
    assert mode.log_mass == pytest.approx(LOG_Z, abs=1e-5)


def test_two_modes_are_found_once_each_the_higher_first():
    model = TwoModes(3)
    starts = np.random.default_rng(0).uniform(-6, 6, (12, 3))
    high, low = find_modes(model.log_prob, np.concatenate([starts, model.starts()]))
    np.testing.assert_allclose(high.theta, 4, atol=1e-3)
    np.testing.assert_allclose(low.theta, -4, atol=1e-3)
    assert high.value - low.value == pytest.approx(np.log(4), abs=1e-6)


def test_a_mode_of_no_mass_is_left_out():
    class Lopsided(TwoModes):
        def log_prob(self, theta):
            right, left = self.log_normal(theta - 4), self.log_normal(theta + 4)
            return np.logaddexp(right, left - 40)

    modes = find_modes(Lopsided(2).log_prob, Lopsided(2).starts())
    assert [m.theta[0] > 0 for m in modes] == [True]


def test_a_mode_at_the_edge_of_the_support():
    modes = find_modes(HalfSpace(2).log_prob, np.array([[0.7, -1.0]]))
    assert 0 < modes[0].theta[0] < 0.1
    assert abs(modes[0].theta[1]) < 1e-2


def test_starts_outside_the_support_are_passed_over():
    starts = np.array([[-1.0, 0.0], [1.0, 0.0]])
    assert len(find_modes(HalfSpace(2).log_prob, starts)) == 1
    assert find_modes(HalfSpace(2).log_prob, starts[:1]) == ()


def test_a_direction_without_curvature_gets_a_finite_width():
    class Ridge(Known):
        def log_prob(self, theta):
            return -((theta[:, 0] - 3) ** 2) / 2

    (mode,) = find_modes(Ridge(2).log_prob, Ridge(2).starts())
    assert mode.theta[0] == pytest.approx(3, abs=1e-3)
    assert np.isfinite(mode.root).all()
    assert mode.root[0, 0] == pytest.approx(1, rel=1e-5)
