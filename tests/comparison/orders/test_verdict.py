"""Probabilities, their words, the plausible set and the verdict."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import softmax

from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.evidence import plausible_set, probabilities, strength
from bayescal.comparison.finding import limits, overturns, wrong_model
from bayescal.comparison.orders.sufficiency import Difference, Sufficiency
from bayescal.comparison.orders.verdict import judge

log_evidences = st.lists(st.floats(-1e5, 1e5), min_size=1, max_size=20)


def criteria_of(aic, bic, aicc=None):
    return Criteria(3, -aic / 2, {"aic": aic, "aicc": aicc, "bic": bic})


@given(log_evidences)
def test_probabilities_are_the_softmax_of_the_log_evidences(values):
    """Independent tool: scipy's; and they sum to 1."""
    found = probabilities(values)
    np.testing.assert_allclose(found, softmax(values), rtol=1e-9, atol=1e-300)
    assert math.fsum(found) == pytest.approx(1, abs=1e-15 * len(values))


@given(log_evidences, st.floats(-1e5, 1e5))
def test_a_common_constant_changes_no_probability(values, constant):
    """Identity, to the rounding of the shifted values: 1e5 eps in the exponent."""
    shifted = [v + constant for v in values]
    np.testing.assert_allclose(probabilities(shifted), probabilities(values), rtol=1e-9, atol=1e-99)


def test_probabilities_of_three_odds_by_hand():
    found = probabilities([0.0, math.log(2), math.log(5)])
    np.testing.assert_allclose(found, [1 / 8, 2 / 8, 5 / 8], rtol=1e-15)


@pytest.mark.parametrize(
    ("twice_log_b", "words"),
    [
        (0.0, "not worth more than a bare mention"),
        (2.0, "not worth more than a bare mention"),
        (2.0001, "positive"),
        (6.0, "positive"),
        (6.0001, "strong"),
        (10.0, "strong"),
        (10.0001, "very strong"),
        (1e6, "very strong"),
        (math.inf, "very strong"),
    ],
)
def test_words_change_at_the_bounds_of_kass_and_raftery(twice_log_b, words):
    assert strength(twice_log_b / 2) == words


@pytest.mark.parametrize(
    ("probability", "chosen"),
    [
        ({1: 0.95, 2: 0.05}, (1,)),
        ({1: 0.94, 2: 0.06}, (1, 2)),
        ({1: 0.05, 2: 0.15, 3: 0.8}, (3, 2)),
        ({1: 0.2, 2: 0.2, 3: 0.2, 4: 0.2, 5: 0.2}, (1, 2, 3, 4, 5)),
        ({1: 0.48, 2: 0.04, 3: 0.48}, (1, 3)),
        ({7: 1.0}, (7,)),
    ],
)
def test_plausible_set_by_hand(probability, chosen):
    """Smallest set by falling probability that reaches 0.95; ties go to the lower order."""
    assert plausible_set(probability) == chosen


@given(st.lists(st.floats(0.001, 1), min_size=1, max_size=8))
def test_plausible_set_is_the_smallest_that_reaches_95_percent(weights):
    """By exhaustion: no set with fewer members holds 0.95, and every member is needed."""
    probability = {k: w / sum(weights) for k, w in enumerate(weights, 1)}
    chosen = plausible_set(probability)
    total = math.fsum(probability[k] for k in chosen)
    largest = sorted(probability.values(), reverse=True)
    assert total >= 0.95 - 1e-12
    assert math.fsum(largest[: len(chosen) - 1]) < 0.95
    assert list(largest[: len(chosen)]) == [probability[k] for k in chosen]


def verdict_of(log_evidence, criteria):
    chances = dict(zip(log_evidence, probabilities(list(log_evidence.values())), strict=True))
    return judge(chances, log_evidence, criteria, [limits("kind", "a caveat")])


def test_a_decided_verdict():
    found = verdict_of(
        {1: -100.0, 2: -90.0, 3: -94.0},
        {
            1: criteria_of(200, 205, 201),
            2: criteria_of(180, 187, 182),
            3: criteria_of(181, 189, 184),
        },
    )
    assert (found.order, found.plausible, found.decided) == (2, (2,), True)
    assert found.log_bayes_factor_to_next == pytest.approx(4)
    assert found.strength == "strong"
    assert (found.aicc_order, found.bic_order) == (2, 2)
    assert found.caveats == ("a caveat",)
    assert "decided at 95%" in found.text
    assert "AICc and BIC agree" in found.text


def test_an_undecided_verdict_names_the_others_and_the_disagreement():
    found = verdict_of(
        {1: -90.0, 2: -90.5},
        {1: criteria_of(181, 184, 182), 2: criteria_of(179, 185, 180)},
    )
    assert (found.order, found.plausible, found.decided) == (1, (1, 2), False)
    assert found.strength == "not worth more than a bare mention"
    assert "not decided: order 2" in found.text
    assert "AICc prefers order 2, BIC order 1" in found.text


def even_verdict():
    """Two orders, 62 % and 38 %."""
    return verdict_of(
        {1: -90.0, 2: -90.5},
        {1: criteria_of(181, 184, 182), 2: criteria_of(179, 185, 180)},
    )


@pytest.mark.parametrize(
    ("largest", "outcome", "words"),
    [
        (0.1, "suffices", "and suffices: order 2 (38%) can't be excluded at 95%, but differs"),
        (0.3, "undecided", "undecided, and it matters: order 2 (38%) can't be excluded at 95%"),
    ],
)
def test_orders_that_differ_by_less_than_the_tolerance_do_not_matter(largest, outcome, words):
    enough = Sufficiency(0.25, stated=True, differences=(Difference(2, largest),))
    found = replace(even_verdict(), enough=enough)
    assert found.outcome == outcome
    assert words in found.text
    standing = (
        "suffices: order 2 within 0.10 px" if outcome == "suffices" else "order 2 not excluded"
    )
    assert found.standing == f"62% probable; {standing}"
    assert f"{largest:.2f} px" in found.text
    assert "tolerance of 0.25 px (as stated)" in found.text


@pytest.mark.parametrize("make", [overturns, wrong_model])
def test_what_overturns_withholds_the_word_decided(make):
    """Truth: 98.2 % alone in the plausible set, and a finding that says why not."""
    sure = verdict_of(
        {1: -100.0, 2: -90.0}, {1: criteria_of(200, 205, 201), 2: criteria_of(180, 187, 182)}
    )
    assert (sure.decided, sure.outcome) == (True, "decided")
    found = sure.with_findings([make("kind", "a long sentence", "the model misses")], "More.")
    assert (found.order, found.plausible) == (2, (2,))
    assert (found.decided, found.outcome) == (False, "best compared")
    assert found.caveats == ("a long sentence", "a caveat")
    assert found.text.startswith("Order 2 is the best of those compared, >99.9%; not decided: the ")
    assert "decided at 95%" not in found.text
    assert found.text.endswith("More.")
    assert found.standing == ">99.9% probable among those compared; not decided"
    assert sure.standing == ">99.9% probable; decided at 95%"


def test_findings_are_ordered_by_severity_and_said_once():
    found = even_verdict().with_findings(
        [
            overturns("a", "second", "x"),
            wrong_model("b", "first", "y"),
            overturns("c", "third", "x"),
        ]
    )
    again = found.with_findings([overturns("a", "second", "x")])
    assert again.caveats == ("first", "second", "third", "a caveat")
    assert again.withheld == ("y", "x")


def test_aic_stands_in_where_aicc_is_not_defined_for_every_order():
    found = verdict_of(
        {1: -90.0, 2: -95.0},
        {1: criteria_of(179, 185, 180), 2: criteria_of(178, 186)},
    )
    assert found.aicc_order == 2
    assert "AIC prefers order 2" in found.text


def test_a_flat_prior_recommends_nothing():
    found = judge(None, None, {1: criteria_of(180, 184, 181), 2: criteria_of(178, 185, 180)}, [])
    assert (found.order, found.plausible, found.decided) == (None, (), False)
    assert (found.log_bayes_factor_to_next, found.strength) == (None, None)
    assert (found.aicc_order, found.bic_order) == (2, 1)
    assert "flat prior has no evidence" in found.text


def test_a_single_order_has_no_runner_up():
    found = verdict_of({3: -90.0}, {3: criteria_of(180, 184, 181)})
    assert (found.order, found.plausible, found.decided) == (3, (3,), True)
    assert (found.log_bayes_factor_to_next, found.strength) == (None, None)


def test_an_exact_fit_leaves_no_preference_by_criteria():
    exact = Criteria(3)
    found = verdict_of({1: -90.0, 2: -50.0}, {1: criteria_of(180, 184, 181), 2: exact})
    assert found.order == 2
    assert (found.aicc_order, found.bic_order) == (None, None)
    assert "fits exactly" in found.text
