"""The thesis's procedure: its sums, its elimination, and the warnings it lacks."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import bayescal as bc
from bayescal.linear.least_squares import factorise
from bayescal.polynomials.separable import axis_data
from tests.helpers.listing import MODELS, ORDERS, columns, listing

VARIANTS = ("as-written", "as-coded")
RSS = {
    ("as-written", "r"): [3074.6, 1571.3, 1023.8, 737.9, 736.7],
    ("as-coded", "r"): [3074.6, 1571.3, 1524.2, 1522.6, 1461.3],
    ("as-written", "c"): [644.7, 626.3, 623.3, 599.1, 599.0],
    ("as-coded", "c"): [644.7, 626.3, 623.3, 599.1, 599.0],
}


@pytest.fixture(scope="module")
def found():
    return bc.reproduce(bc.thesis())


@pytest.fixture(scope="module")
def on_common():
    return bc.reproduce(bc.thesis(), common=True)


def design(variant: str, axis: str, order: int) -> np.ndarray:
    return np.column_stack(columns(variant, axis, order, *bc.thesis().camera_frame().T))


@pytest.mark.parametrize(("variant", "axis"), RSS)
def test_sums_of_squares_are_the_known_ones(found, variant, axis):
    sums = [round(order.before.rss, 1) for order in found[variant][axis].orders]
    assert sums == RSS[variant, axis]


@pytest.mark.parametrize(("variant", "axis", "order"), MODELS)
def test_every_number_before_elimination_follows_from_the_listings_residuals(
    found, variant, axis, order
):
    _, residuals = listing(variant, axis, order)
    fit = found[variant][axis][order].before
    rss = float(residuals @ residuals)
    # -2 ln L at the maximum, 2 pi and sigma counted; K = coefficients and sigma.
    bic = 57 * (math.log(2 * math.pi * rss / 57) + 1) + (order + 2) * math.log(57)
    assert np.abs(fit.residuals - residuals).max() < 1e-9
    assert np.abs(fit.squared_errors - residuals**2).max() < 1e-7
    assert fit.rms == pytest.approx(math.sqrt(rss / 57), rel=1e-10)
    assert fit.bic == pytest.approx(bic, rel=1e-10)
    assert fit.kept.tolist() == list(range(57))


@pytest.mark.parametrize(("variant", "axis", "order"), MODELS)
def test_after_elimination_is_a_refit_of_what_is_left_judged_on_all_points(
    found, variant, axis, order
):
    result = found[variant][axis][order]
    t, matrix = bc.thesis().pixel(axis), design(variant, axis, order)
    kept = result.rejection.kept
    solution = np.linalg.lstsq(matrix[kept], t[kept], rcond=None)[0]
    assert np.abs(result.after.residuals - (t - matrix @ solution)).max() < 1e-8
    assert result.after.rss == pytest.approx(((t - matrix @ solution)[kept] ** 2).sum(), rel=1e-9)
    # Least squares on all points is what predicts them best: elimination can't.
    assert (result.after.squared_errors.sum() >= result.before.rss * (1 - 1e-12)).all()


def test_order_five_as_coded_hardly_helps_and_as_written_order_four_is_where_it_stays(found):
    written, coded, c = found["as-written"]["r"], found["as-coded"]["r"], found["as-written"]["c"]
    assert [model.best.order for model in (written, coded, c)] == [4, 2, 1]
    for model, order, gain in ((written, 4, 0.0017), (coded, 2, 0.070), (c, 1, 0.071)):
        measured, by_chance = model.gain_beyond(order)
        assert measured == pytest.approx(gain, rel=0.02)
        assert by_chance == (5 - order) / (57 - order - 1)


def test_chance_takes_the_stated_share_off_a_sum_of_squares():
    """Noise about order 1 of c, 2000 times: the mean share that orders 2 to 5 take."""
    low, high = (np.linalg.qr(design("as-written", "c", k))[0] for k in (1, 5))
    noise = np.random.default_rng(5).normal(size=(2000, 57))
    rss = [(noise**2).sum(axis=1) - ((noise @ q) ** 2).sum(axis=1) for q in (low, high)]
    shares = 1 - rss[1] / rss[0]
    assert abs(shares.mean() - 4 / 55) < 4 * shares.std() / math.sqrt(2000)


def test_models_that_differ_are_listed_once(found):
    assert [model.name for model in found.models] == ["r as written", "r as coded", "c"]
    low = bc.reproduce(bc.thesis(), orders=[1, 2])
    assert [(m.variant, m.axis) for m in low.models] == [("as-written", "r"), ("as-written", "c")]
    assert found.orders == ORDERS


def test_orders_on_different_points_are_warned_of_and_common_points_end_it(found, on_common):
    assert not found["as-written"]["r"].same_points
    assert found["as-written"]["c"].same_points
    assert [w.split(":")[0] for w in found.warnings] == ["r as written", "r as coded"]
    assert "(51, 57, 57, 55, 55 of 57)" in found.warnings[0]
    assert on_common.warnings == ()


def test_common_points_are_those_no_order_eliminates(on_common):
    for variant in VARIANTS:
        for axis in "rc":
            model = on_common[variant][axis]
            gone = {p for order in model.orders for p in order.rejection.removed}
            assert model.common_kept.tolist() == [i for i in range(57) if i not in gone]
            for order in model.orders:
                assert np.array_equal(order.common.kept, model.common_kept)
                kept, t = model.common_kept, bc.thesis().pixel(axis)
                matrix = design(variant, axis, order.order)[kept]
                rss = np.linalg.lstsq(matrix, t[kept], rcond=None)[1]
                assert order.common.rss == pytest.approx(float(rss[0]), rel=1e-9)


def test_elimination_turns_the_choice_of_order_around(found, on_common):
    """Without the six points that order 1 can't follow, BIC sees no non-linearity in r."""
    assert found["as-written"]["r"].best.order == 4
    assert on_common["as-written"]["r"].best_on_common.order == 1
    assert found["as-written"]["r"].best_on_common is None  # not asked for


def test_a_known_sigma_tests_by_chi_squared_and_counts_one_parameter_less(found):
    known = bc.reproduce(bc.thesis(), sigma=2.5)["as-written"]["r"][4]
    rss = found["as-written"]["r"][4].before.rss
    minus_2_log_l = rss / 2.5**2 + 57 * math.log(2 * math.pi * 2.5**2)
    assert known.before.bic == pytest.approx(minus_2_log_l + 5 * math.log(57), rel=1e-10)
    assert known.rejection.rule.sigma == 2.5
    assert known.tests.dof is None


def test_per_point_elimination_runs_away_on_the_thesis_data():
    """At 5 % per point c of order 5 loses points until what is left fits exactly."""
    model = bc.reproduce(bc.thesis(), per_point=True, common=True)["as-written"]["c"]
    assert [len(order.after.kept) for order in model.orders] == [38, 32, 20, 36, 20]
    assert model[5].rejection.stopped == "exact fit"
    assert model[5].after.bic is None
    assert model.best_on_common is None
    assert model[5].common is None


def test_common_points_that_do_not_determine_an_order_are_warned_of():
    found = bc.reproduce(bc.thesis(), per_point=True, common=True)
    assert "c: the points that all orders keep, 19, do not determine order 5" in found.warnings


def test_deviations_of_the_points_are_said_to_go_unused(found):
    points = dataclasses.replace(bc.thesis(), sigma={"r": np.full(57, 2.0)})
    other = bc.reproduce(points)
    assert "sigma_r" in other.warnings[0]
    assert other["as-written"]["r"][3].before.rss == found["as-written"]["r"][3].before.rss


def test_points_on_an_exact_line_leave_bic_without_a_choice():
    world = [[float(i), float(i % 3), 2.0 + i % 2] for i in range(9)]
    points = bc.Correspondences.from_arrays(world, [[x / z, y / z] for x, y, z in world])
    model = bc.reproduce(points, orders=[1, 2])["as-written"]["r"]
    assert model[1].before.fit.exact
    assert model[1].tests is None
    assert model.best is None


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"significance": 2.0}, "between 0 and 1"),
        ({"sigma": "guessed"}, "'inferred' or a number"),
        ({"sigma": -1.0}, "positive number"),
        ({"orders": []}, "no order"),
        ({"orders": [0]}, "out of range"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, complaint):
    with pytest.raises(bc.InputError, match=complaint):
        bc.reproduce(bc.thesis(), **settings)


def test_an_order_beyond_the_points_is_refused():
    world = [[float(i), float(i * i), 2.0] for i in range(4)]
    points = bc.Correspondences.from_arrays(world, [[float(i), 0] for i in range(4)])
    with pytest.raises(bc.InputError, match="the highest order that works is 3"):
        bc.reproduce(points)


def test_an_order_that_was_not_fitted_is_named(found):
    with pytest.raises(KeyError, match="order 6 was not fitted; orders: 1, 2, 3, 4, 5"):
        found["as-coded"]["r"][6]


def test_repr_says_what_there_is(found):
    assert "r as coded: RSS 3074.6, 1571.3, 1524.2, 1522.6, 1461.3" in repr(found)
    assert repr(found["as-coded"]["r"][3].before) == (
        "<ThesisFit: r as-coded, order 3, 57 points, RSS 1524.2 px^2>"
    )


@pytest.mark.parametrize("axis", ["r", "c"])
def test_orders_far_beyond_the_thesis_agree_with_the_legendre_factorisation(axis):
    """Another basis, another factorisation; the monomials' condition costs 1e-11 at order 15."""
    orders = (5, 10, 15)
    factors = factorise(axis_data(bc.thesis(), axis), 15)
    model = bc.reproduce(bc.thesis(), orders)["as-written"][axis]
    for order in orders:
        assert model[order].before.rss == pytest.approx(factors.rss(order), rel=1e-9)
