"""Models of the joint data on one scale: probabilities, the verdict, weak combinations."""

from dataclasses import replace

import numpy as np
import pytest

from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.verdict import judge_families
from bayescal.comparison.finding import limits
from bayescal.comparison.judged import with_probabilities
from bayescal.comparison.key import Key
from bayescal.inference.correlation import weak_combinations


def joint(family, orders, position, evidence):
    return JointModel(
        key=Key(family, orders, position),
        log_evidence=evidence,
        log_evidence_error=0.01,
        criteria=Criteria(5),
        position=np.zeros(3),
        residuals=np.zeros((2, 1)),
    )


def probabilities(models):
    return [m.probability for m in with_probabilities(models)]


def judged(models, findings=()):
    """Judge models, the most probable first."""
    found = sorted(with_probabilities(models), key=lambda m: -m.probability)
    return judge_families(found, findings)


def test_a_family_gains_nothing_by_offering_more_orders():
    """Equal evidences: half each, whatever the number of models."""
    models = [joint("separable", (k, m), "stated", -5.0) for k in (1, 2) for m in (1, 2)]
    models += [joint("separable", (1, 1), "free", -5.0), joint("pinhole", (0,), "free", -5.0)]
    assert probabilities(models) == pytest.approx([1 / 16] * 4 + [1 / 4, 1 / 2])


def test_verdict_sums_families_and_positions():
    models = [joint("pinhole", (1,), "free", -1.0), joint("separable", (4, 1), "stated", -9.0)]
    verdict = judged(models, [limits("test", "a caveat")])
    assert verdict.best == models[0].key
    assert verdict.decided
    assert verdict.log_bayes_factor == pytest.approx(8.0)
    assert verdict.families["pinhole"] == pytest.approx(1 / (1 + np.exp(-8)))
    assert verdict.positions["stated"] == pytest.approx(1 / (1 + np.exp(8)))
    assert "2 ln B of pinhole against separable = 16.0, very strong" in verdict.text
    assert "free camera position" not in verdict.text  # it is the family under another name


def test_families_are_judged_by_all_of_their_models():
    """The best of nine pairs leads the only pinhole, and the nine together do not."""
    pairs = [(k, m) for k in (1, 2, 3) for m in (1, 2, 3)]
    models = [joint("separable", pairs[0], "stated", -5.0)]
    models += [joint("pinhole", (0,), "free", -6.0)]
    models += [joint("separable", pair, "stated", -50.0) for pair in pairs[1:]]
    verdict = judged(models)
    assert verdict.families["pinhole"] == pytest.approx(1 / (1 + np.e / 9))
    factor = 2 * (np.log(9) - 1)
    assert f"2 ln B of pinhole against separable = {factor:.1f}, positive" in verdict.text


def test_both_positions_of_a_family_are_summed():
    models = [joint("separable", (1, 1), "free", -1.0), joint("separable", (1, 1), "stated", -9.0)]
    verdict = judged(models)
    assert "free camera position has >99.9%" in verdict.text


def test_an_evidence_from_poor_weights_is_not_sound():
    """Though nothing was sampled, and so no chain can have failed."""
    poor = replace(joint("separable", (4, 1), "free", -1.0), warnings=("too few draws",))
    assert not poor.sound
    assert poor.warnings == ("too few draws",)
    assert joint("separable", (4, 1), "free", -1.0).sound


def test_weak_combinations_of_a_known_matrix():
    """Two of three move as one (correlation 0.99); without correlations nothing is said."""
    matrix = np.array([[1, -0.99, 0], [-0.99, 1, 0], [0, 0, 1.0]])
    ((names, shares),) = weak_combinations(("a", "b", "c"), matrix)
    assert set(names) == {"a", "b"}
    assert shares == pytest.approx((np.sqrt(0.5), -np.sqrt(0.5)))
    assert weak_combinations(("a", "b", "c"), np.eye(3)) == ()
