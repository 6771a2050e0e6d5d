"""What the thesis data says: sums of squares, probabilities, scatter and verdicts."""

from __future__ import annotations

import math
from collections import defaultdict
from fractions import Fraction

import pytest

import bayescal as bc
from tests.helpers.brute_force import normal_grid
from tests.helpers.problems import ORDERS, THESIS_MODELS, make_model, thesis_axis

# Sums of squares in px^2 as an independent least-squares fit gives them, to 0.05.
RSS = {
    "r": (3074.6, 1571.3, 1023.8, 737.9, 736.7),
    "c": (644.7, 626.3, 623.3, 599.1, 599.0),
}


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_sums_of_squares(thesis_comparison, axis, order):
    found = thesis_comparison.axes[axis][order].rss_px2
    assert found == pytest.approx(RSS[axis][order - 1], abs=0.05)


@pytest.mark.parametrize("axis", ["r", "c"])
def test_probabilities_are_those_of_brute_force_evidences(thesis_comparison, axis):
    """Independent of the package's quadrature: normal_grid over sigma and tau."""
    data = thesis_axis(axis)
    logs = [normal_grid(make_model(data, k), data).log_evidence for k in ORDERS]
    weights = [math.exp(z - max(logs)) for z in logs]
    for k, weight in zip(ORDERS, weights, strict=True):
        found = thesis_comparison.axes[axis][k].probability
        assert found == pytest.approx(weight / sum(weights), abs=1e-6)


def test_r_is_of_order_4_or_else_5(thesis_comparison):
    chances = [r.probability for r in thesis_comparison.axes["r"].orders]
    assert chances[3:] == pytest.approx([0.84, 0.16], abs=0.005)
    assert sum(chances[:3]) < 0.005
    verdict = thesis_comparison.axes["r"].verdict
    assert (verdict.order, verdict.plausible, verdict.decided) == (4, (4, 5), False)
    assert verdict.strength == "positive"


def test_c_is_of_order_1_most_probably(thesis_comparison):
    chances = [r.probability for r in thesis_comparison.axes["c"].orders]
    assert chances == pytest.approx([0.33, 0.19, 0.16, 0.165, 0.155], abs=0.005)
    verdict = thesis_comparison.axes["c"].verdict
    assert (verdict.order, verdict.decided) == (1, False)
    assert verdict.plausible == (1, 2, 4, 3, 5)


@pytest.mark.parametrize("axis", ["r", "c"])
def test_probabilities_sum_to_one(thesis_comparison, axis):
    total = math.fsum(r.probability for r in thesis_comparison.axes[axis].orders)
    assert total == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize(("axis", "sigma", "dof"), [("r", 2.51, 35), ("c", 1.09, 26)])
def test_scatter_within_equal_regressors(thesis_comparison, axis, sigma, dof):
    """By hand: groups of equal exact quotients, pooled about their means."""
    column, offset = (0, 330) if axis == "r" else (1, 57)
    groups = defaultdict(list)
    for world, t in zip(bc.thesis().world.tolist(), thesis_axis(axis).t.tolist(), strict=True):
        groups[Fraction(int(world[column]) - offset, int(world[2]))].append(t)
    spread = sum(sum((t - sum(g) / len(g)) ** 2 for t in g) for g in groups.values())
    found = thesis_comparison.axes[axis].scatter
    assert found[1] == dof == 57 - len(groups)
    assert found[0] == pytest.approx(math.sqrt(spread / dof), rel=1e-12)
    assert found[0] == pytest.approx(sigma, abs=0.005)


@pytest.mark.parametrize("axis", ["r", "c"])
def test_reference_sigma_is_the_highest_orders(thesis_comparison, axis):
    """There are no true replicates and sigma is not known."""
    result = thesis_comparison.axes[axis]
    assert (result.reference.source, result.reference.dof) == ("highest-order", 51)
    assert result.reference.value == pytest.approx(math.sqrt(RSS[axis][4] / 51), rel=1e-4)


def test_every_order_is_sound_and_the_misfit_is_said(thesis_comparison):
    """Points that share a regressor scatter less than the residuals, and y/z matters to r."""
    assert thesis_comparison.sound
    for axis in thesis_comparison.axes.values():
        assert axis.verdict.outcome == "best compared"
        kinds = {finding.kind for finding in axis.verdict.findings if finding.withholds}
        assert "misfit: lack of fit, scatter" in kinds
    assert any("other coordinate" in kind for kind in kinds)


@pytest.mark.parametrize("tau", [0.001, 0.01, 0.1, 1.0])
def test_r_stays_of_order_4_at_every_fixed_tau(tau):
    result = bc.compare(bc.thesis(), axis="r", tau=tau, ess=100)
    assert result.orders == {"r": 4}


def test_chi_squared_rejects_every_order_at_the_scatters_sigma():
    """The family is too small: even order 5 of c is beyond chance at 1.09 px."""
    result = bc.compare(bc.thesis(), axis="c", sigma=1.09, ess=100)
    assert all(r.goodness.p_value < 1e-6 for r in result.axes["c"].orders)
