"""A single order fitted says what a comparison of the same points says against it."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from scripts.validation.voice_cameras import Camera, Truth, separable

EFFORT = 200


def kinds(verdict) -> set[str]:
    return {found.kind for found in verdict.findings}


@pytest.fixture(scope="module")
def quintic() -> Camera:
    """Both axes of order 5."""
    return separable(Truth(5), np.random.default_rng([0, 8, 1]))


@pytest.fixture(scope="module")
def cubic() -> Camera:
    """Both axes of order 3, with 0.5 px of noise."""
    return separable(Truth(3), np.random.default_rng([0, 12, 0]))


def test_too_low_an_order_is_told_that_a_higher_one_would_win(quintic):
    compared = bc.compare(quintic.points, [1, 2, 3], ess=EFFORT, hint=False)
    orders = compared.orders
    fitted = bc.fit(quintic.points, orders["r"], orders["c"], ess=EFFORT)
    for name, order in orders.items():
        verdict = fitted.axes[name].verdict
        assert "edge" in kinds(compared.axes[name].verdict) & kinds(verdict)
        (found,) = [f for f in verdict.findings if f.kind == "edge"]
        assert found.text in verdict.caveats
        assert f"above order {order}, would win" in found.text
        assert found.because in verdict.headline
    joint = bc.fit_family(quintic.points, "separable", (orders["r"], orders["c"]), ess=EFFORT)
    assert "which was not compared, would win" in joint.verdict.headline


def test_the_true_order_is_not_told_so(quintic):
    fitted = bc.fit(quintic.points, 5, 5, ess=EFFORT)
    assert all("edge" not in kinds(axis.verdict) for axis in fitted.axes.values())
    joint = bc.fit_family(quintic.points, "separable", (5, 5), ess=EFFORT)
    assert "edge" not in kinds(joint.verdict)


def test_chi_squared_that_rejects_the_order_is_said(cubic):
    """Sigma stated five times too small: chi-squared per degree of freedom is about 25."""
    fitted = bc.fit(cubic.points, 3, 3, sigma=0.1, ess=EFFORT)
    for axis in fitted.axes.values():
        (said,) = [f for f in axis.verdict.findings if f.kind == "chi-squared"]
        value = axis[3].goodness.chi2_reduced
        assert value == pytest.approx(25, rel=4 * np.sqrt(2 / 56))
        assert f"rejects order 3 at the known sigma (chi2/dof {value:.3g})" in said.text
        assert axis.verdict.headline.count("to within the known sigma") == 1


def test_chi_squared_of_the_right_sigma_is_silent(cubic):
    fitted = bc.fit(cubic.points, 3, 3, sigma=0.5, ess=EFFORT)
    assert not any("chi-squared" in kinds(axis.verdict) for axis in fitted.axes.values())
