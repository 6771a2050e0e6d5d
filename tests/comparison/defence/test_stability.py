"""Removals, resamples and orders beyond, each against doing it to the actual points.

The truth is one exact posterior per altered data set, factorised from scratch in
Bonnet's basis on the domain, and with the prior, of all points.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bayescal.comparison.criteria.leave_one_out import leave_one_out
from bayescal.comparison.defence.stability import (
    bootstrap,
    joint_probabilities,
    removals,
    without_groups,
)
from bayescal.comparison.orders.beyond import beyond
from bayescal.linear.closed_form import exact_posterior
from bayescal.noise.level import NoiseLevel
from tests.helpers.cases import all_but, curve, refitted_evidence
from tests.helpers.problems import AXES, ORDERS, field_rule, make_axis, make_model, thesis_axis

INFERRED = NoiseLevel.inferred()
# Two evidences from COARSE rules may be off by this against each other, nat.
TIE = 0.1


def evidences(data, orders, rows) -> dict[int, float]:
    """Log evidence of every order on some rows."""
    return {k: refitted_evidence(data, k, rows, INFERRED, field_rule(data)) for k in orders}


def planes(n: int, count: int) -> np.ndarray:
    """Membership of groups of neighbours."""
    return (np.arange(n) * count // n == np.arange(count)[:, None]).astype(float)


def check_bootstrap(data, orders, members=None, resamples=60, seed=5) -> None:
    """Shares equal winners by brute force, but for resamples too close to call."""
    models = {k: make_model(data, k) for k in orders}
    found = bootstrap(data, models, np.random.default_rng(seed), members, resamples)
    units = len(data) if members is None else len(members)
    drawn = np.random.default_rng(seed).multinomial(units, np.full(units, 1 / units), resamples)
    counts = drawn if members is None else drawn @ members.astype(int)
    wins, ties = dict.fromkeys(orders, 0), 0
    for row in counts:
        z = evidences(data, orders, np.repeat(np.arange(len(data)), row))
        best = sorted(z, key=z.get)[-1]
        wins[best] += 1
        ties += z[best] - sorted(z.values())[-2] < TIE
    assert found.resamples == resamples
    assert found.unit == ("point" if members is None else "group")
    assert sum(found.share.values()) == pytest.approx(1)
    assert ties < resamples / 2
    for k in orders:
        assert abs(found.share[k] * resamples - wins[k]) < ties + 0.5


@pytest.mark.parametrize("axis", AXES)
def test_refitted_resamples_of_points_equal_bootstrap_shares(axis):
    check_bootstrap(thesis_axis(axis), (1, 3, 5))


@pytest.mark.parametrize("axis", AXES)
def test_refitted_resamples_of_groups_equal_bootstrap_shares(axis):
    data = thesis_axis(axis)
    check_bootstrap(data, (1, 4), planes(len(data), 9), 40)


def test_refitted_resamples_of_few_points_equal_bootstrap_shares():
    """Six points: one resample in three has fewer distinct ones than order 3 has coefficients."""
    check_bootstrap(curve(6, [480, 300, 20], 1.0), (1, 2, 3), resamples=80)


def test_a_straight_line_of_many_points_wins_its_resamples():
    """Truth order 1 of 10 000 points without a curve: a peak in ln sigma 0.007 wide.

    Order 2 wins where twice the gain in ln L exceeds about ln n = 9.2. Over resamples that
    gain is (z + N(0, 1))^2, z the data's own deviate; |z| < 2 leaves P(N > 1) = 16 %, and
    40 resamples rarely 20 % (3 of them).
    """
    data = curve(10_000, [480, 300], 1.3)
    models = {k: make_model(data, k) for k in (1, 2)}
    found = bootstrap(data, models, np.random.default_rng(0), resamples=40)
    assert found.share[1] > 0.8


def test_the_same_seed_gives_the_same_shares():
    data = thesis_axis("c")
    models = {k: make_model(data, k) for k in (1, 2)}
    one, again, other = (
        bootstrap(data, models, np.random.default_rng(seed), resamples=200) for seed in (1, 1, 2)
    )
    assert one == again
    assert one.share != other.share


def test_one_group_that_holds_everything_repeats_the_verdict():
    """Closed form: resampling a single group gives back the data."""
    data = thesis_axis("r")
    models = {k: make_model(data, k) for k in (3, 4)}
    found = bootstrap(data, models, np.random.default_rng(0), np.ones((1, len(data))), 50)
    assert found.share == {3: 0.0, 4: 1.0}


@pytest.mark.parametrize("axis", AXES)
def test_refitting_without_each_group_equals_its_removal(axis):
    data = thesis_axis(axis)
    members = planes(len(data), 9)
    models = {k: make_model(data, k) for k in ORDERS}
    found = without_groups(data, models, members)
    for g in range(0, 9, 2):
        truth = evidences(data, ORDERS, np.flatnonzero(members[g] == 0))
        for k in ORDERS:
            assert found[k][g] == pytest.approx(truth[k], abs=1e-7)


def outlying(size: float):
    """A straight line of 20 points whose last is off: it feigns a curve."""
    data = curve(20, [480, 300], 1.0, 8)
    t = data.t.copy()
    t[-1] += size
    return dataclasses.replace(data, t=t, labels=tuple(f"P{i}" for i in range(20)))


@pytest.mark.parametrize("size", [2.5, 3.5, 5.0])
def test_refitting_without_each_point_equals_the_points_that_matter(size):
    data, orders = outlying(size), (1, 2, 3)
    exact = {k: exact_posterior(make_model(data, k)) for k in orders}
    whole = {k: e.log_integral for k, e in exact.items()}
    chosen = max(whole, key=whole.get)
    without = {k: whole[k] - leave_one_out(data, e).pointwise for k, e in exact.items()}
    found = removals(data.labels, [1] * 20, without, chosen)
    truth = {}
    for i in range(20):
        z = evidences(data, orders, all_but(20, i))
        best = max(z, key=z.get)
        if best != chosen:
            truth[data.labels[i]] = (best, z[best] - z[chosen])
    assert {r.name: (r.order, r.log_bayes_factor) for r in found} == {
        name: (k, pytest.approx(b, abs=1e-7)) for name, (k, b) in truth.items()
    }
    factors = [r.log_bayes_factor for r in found]
    assert factors == sorted(factors, reverse=True)
    assert all(r.size == 1 and r.log_bayes_factor > 0 for r in found)


def test_removals_name_the_winner_and_its_lead():
    """By hand: two groups of 4 and 6 points; order 2 wins without b, by 0.5 nat."""
    without = {1: np.array([-10.0, -20.0]), 2: np.array([-11.0, -19.5])}
    (found,) = removals(["a", "b"], [4, 6], without, 1)
    assert (found.name, found.size, found.order) == ("b", 6, 2)
    assert found.log_bayes_factor == pytest.approx(0.5)
    assert removals(["a", "b"], [4, 6], {1: without[1]}, 1) == ()


@pytest.mark.parametrize("axis", AXES)
def test_comparing_more_orders_equals_orders_beyond(axis):
    data = thesis_axis(axis)
    rule = field_rule(data)
    z = {k: exact_posterior(make_model(data, k)).log_evidence for k in range(1, 9)}
    found = beyond(data, {k: z[k] for k in ORDERS}, INFERRED, rule)
    top = max(z.values())
    total = sum(np.exp(v - top) for v in z.values())
    assert list(found.probability) == list(range(1, 9))
    for k, chance in found.probability.items():
        assert chance == pytest.approx(np.exp(z[k] - top) / total, rel=1e-6)
    assert found.winner is None


def test_a_true_order_beyond_the_range_is_the_winner():
    data = curve(40, [480, 300, 0, 0, 0, 12], 1.0)
    z = {k: exact_posterior(make_model(data, k)).log_evidence for k in (1, 2)}
    found = beyond(data, z, INFERRED, field_rule(data))
    assert found.winner == 5
    assert found.probability[5] > 0.99


@pytest.mark.parametrize(("distinct", "highest"), [(3, 2), (4, 3), (5, 4), (9, 5)])
def test_orders_beyond_stop_at_what_the_points_determine(distinct, highest):
    """p distinct regressors determine order p - 1 at most; three orders beyond at most."""
    x = np.tile(np.linspace(-1, 1, distinct), 4)
    t = 500 + 300 * x + np.random.default_rng(0).standard_normal(len(x))
    data = make_axis(x, t)
    z = {k: exact_posterior(make_model(data, k)).log_evidence for k in (1, 2)}
    found = beyond(data, z, INFERRED, field_rule(data))
    assert max(found.probability) == highest


def test_joint_probabilities_are_products_that_sum_to_1():
    r = {1: 0.1, 2: 0.2, 4: 0.7}
    c = {1: 0.6, 3: 0.4}
    found = joint_probabilities(r, c)
    assert found.shape == (3, 2)
    assert found.sum() == pytest.approx(1, abs=1e-15)
    assert found[2, 0] == pytest.approx(0.42)
    np.testing.assert_allclose(found.sum(axis=1), list(r.values()))
    np.testing.assert_allclose(found.sum(axis=0), list(c.values()))
