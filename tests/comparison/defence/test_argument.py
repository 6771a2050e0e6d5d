"""The words of a verdict: simulated cases whose truth is known, and what the text says.

Every number looked for is computed here, from a refit or from the criteria, not read
off the text.
"""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.defence.argument import argue
from bayescal.comparison.finding import overturns
from bayescal.comparison.findings.edge import UNSEEN
from bayescal.comparison.results import AxisComparison
from bayescal.points.setup import StatedPrior
from bayescal.rounding import percent
from tests.helpers.cases import (
    all_but,
    camera_points,
    defended,
    refitted_evidence,
)

LINE = (960.0, 700.0)


def criteria(axis: AxisComparison, name: str) -> dict[int, float]:
    """A criterion from its definition: n ln(2 pi RSS / n) + n + penalty."""
    out = {}
    n = len(axis.data)
    for result in axis.orders:
        value = axis.noise.value
        rss, k = result.fit.rss, result.order + 1 + (value is None)
        if value is None:
            fit = n * (math.log(2 * math.pi * rss / n) + 1)
        else:
            fit = rss / value**2 + n * math.log(2 * math.pi * value**2)
        penalty = {
            "aic": 2 * k,
            "aicc": 2 * k + 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else math.inf,
            "bic": k * math.log(n),
        }
        out[result.order] = fit + penalty[name]
    return out


def smallest(values: dict[int, float]) -> int:
    return min(values, key=values.__getitem__)


def elpd(axis: AxisComparison) -> dict[int, np.ndarray]:
    """Pointwise leave-one-out of each order, by refitting."""
    n, out = len(axis.data), {}
    for result in axis.orders:
        options = (axis.noise, axis.prior)
        whole = refitted_evidence(axis.data, result.order, np.arange(n), *options)
        rest = [
            refitted_evidence(axis.data, result.order, all_but(n, i), *options) for i in range(n)
        ]
        out[result.order] = whole - np.array(rest)
    return out


def test_aicc_against_bic_is_said_with_what_each_asks(weak_curve):
    """AICc order 2, BIC order 1: from K = 3 to 4 of 200, 2.1 against ln 200 = 5.3."""
    text = weak_curve.verdict.text
    assert smallest(criteria(weak_curve, "aicc")) == 2
    assert smallest(criteria(weak_curve, "bic")) == 1
    assert "AICc prefers order 2, BIC order 1" in text
    assert "from order 1 to 2 AICc asks 2.1 of twice the log likelihood, BIC 5.3" in text


def test_leave_one_out_against_evidence_is_said_with_its_lead(weak_curve):
    """Evidence order 1, elpd order 2: lead and paired standard error by refitting."""
    terms = elpd(weak_curve)
    d = terms[2] - terms[1]
    ahead, se = d.sum(), math.sqrt(len(d)) * d.std(ddof=1)
    assert weak_curve.verdict.order == 1
    assert 0.1 < ahead < 4
    text = weak_curve.verdict.text
    assert f"Leave-one-out puts order 2 ahead by {ahead:.1f} (SE {se:.1f}" in text
    assert "below 4, predictions are similar" in text
    assert "the evidence also how much of the prior" in text
    assert not any("clearly prefers" in c for c in weak_curve.verdict.caveats)


def test_aic_against_bic_at_known_sigma_names_aic():
    """There is no AICc where sigma is known, so it can't disagree."""
    axis = defended(camera_points(100, (*LINE, 0.6), 1.0, 0), (1, 2), sigma=1.0)
    assert smallest(criteria(axis, "aic")) == 2
    assert smallest(criteria(axis, "bic")) == 1
    text = axis.verdict.text
    assert "AIC prefers order 2, BIC order 1" in text
    assert "AICc" not in text
    assert "from order 1 to 2 AIC asks 2.0 of twice the log likelihood, BIC 4.6" in text


def test_aicc_that_asks_for_more_than_bic_is_not_said_to_ask_for_little():
    """7 points: K from 3 to 4 adds 2 + 20 - 8 = 14 to AICc and ln 7 = 1.9 to BIC."""
    axis = defended(camera_points(7, (*LINE, 2.0), 1.0, 0), (1, 2))
    assert smallest(criteria(axis, "aicc")) == 1
    assert smallest(criteria(axis, "bic")) == 2
    text = axis.verdict.text
    assert "AICc prefers order 1, BIC order 2" in text
    assert "little more than 2" not in text
    assert "14" in text


def test_a_clear_contradiction_by_leave_one_out_is_a_caveat():
    """A prior of 1e6 px on b_2 lets evidence refuse a curve that predicts better."""
    points = camera_points(60, (*LINE, 1.0), 1.0, 1)
    stated = StatedPrior((960.0, 0.0, 0.0), (900.0, 900.0, 1e6))
    setup = dataclasses.replace(points.setup, priors={"r": stated})
    axis = defended(dataclasses.replace(points, setup=setup), (1, 2))
    terms = elpd(axis)
    d = terms[2] - terms[1]
    ahead, se = d.sum(), math.sqrt(60) * d.std(ddof=1)
    assert axis.verdict.order == 1
    assert ahead > max(4, 2 * se)
    (caveat,) = [c for c in axis.verdict.caveats if "leave-one-out clearly prefers order 2" in c]
    assert f"{ahead:.1f}" in caveat
    assert f"{se:.1f}" in caveat


def test_a_dead_heat_of_predictions_is_not_called_agreement():
    """c of the thesis: orders 1 and 2 are within 0.1 of elpd, SE 1.1."""
    axis = defended(bc.thesis(), (1, 2), axis="c")
    terms = elpd(axis)
    assert abs((terms[1] - terms[2]).sum()) < 0.1
    assert "similar" in axis.verdict.text


def test_an_inadequate_family_is_a_caveat_that_names_the_other_coordinate():
    """r depends on (y/z)^2, worth 1.6 px rms about what x/z explains, under 1 px of noise."""
    axis = defended(camera_points(40, LINE, 1.0, 1, shift=lambda _, o: 60 * o**2), (1, 2))
    (test,) = [t for t in axis.adequacy if t.name == "other coordinate"]
    assert test.concern
    (caveat,) = [c for c in axis.verdict.caveats if c.startswith("other coordinate:")]
    assert "strongest alone is (y/z)²" in caveat
    assert re.search(r"worth 1\.\d px rms", caveat)


def test_an_adequate_family_has_no_such_caveat():
    axis = defended(camera_points(40, LINE, 1.0, 1), (1, 2))
    assert not [c for c in axis.verdict.caveats if c.startswith("other coordinate")]


def test_a_group_that_drives_the_choice_is_named(one_bad_group):
    """Without it the truth, order 1, wins by what a refit says; other groups don't matter."""
    axis = one_bad_group
    chosen = axis.verdict.order
    assert chosen != 1
    z = {
        k: refitted_evidence(axis.data, k, np.arange(35), axis.noise, axis.prior) for k in (1, 2, 3)
    }
    assert max(z, key=z.get) == 1
    wanted = f"ithout group h (5 points) order 1 would win (ln B {z[1] - z[chosen]:.1f})"
    assert wanted in axis.verdict.text
    assert axis.verdict.text.count("ithout group") == 1


def test_a_defence_adds_caveats_and_takes_none_back(one_bad_group):
    """The tests of a plain comparison are among those of its defence, with the same p-values."""
    names = tuple("abcdefgh"[i // 5] for i in range(40))
    points = camera_points(40, LINE, 1.0, 1, shift=3.0 * (np.array(names) == "h"), groups=names)
    plain = bc.compare(points, (1, 2, 3), axis="r", ess=400).axes["r"].verdict
    assert plain.caveats
    assert [text for text in plain.caveats if text not in one_bad_group.verdict.caveats] == []
    assert plain.withheld == one_bad_group.verdict.withheld


def test_shares_of_resamples_are_those_of_the_bootstrap(one_bad_group):
    points, groups = one_bad_group.defence.resampled
    chosen = one_bad_group.verdict.order
    text = one_bad_group.verdict.text
    assert f"It wins in {percent(points.share[chosen])} of 1000 resamples of the points" in text
    assert f"{percent(groups.share[chosen])} of 1000 resamples of the groups" in text
    assert groups.share[chosen] < points.share[chosen]


def test_an_outlier_that_drives_the_choice_is_named():
    """A straight line; P19, at the end, is 4 px off under 1 px of noise: it feigns a curve."""
    shift = np.zeros(20)
    shift[-1] = 4.0
    labels = tuple(f"P{i}" for i in range(20))
    axis = defended(camera_points(20, LINE, 1.0, 0, shift=shift, labels=labels))
    chosen = axis.verdict.order
    assert chosen != 1
    z = {
        k: refitted_evidence(axis.data, k, np.arange(19), axis.noise, axis.prior) for k in (1, 2, 3)
    }
    assert max(z, key=z.get) == 1
    factor = z[1] - z[chosen]
    assert f"ithout point P19 order 1 would win (ln B {factor:.1f})" in axis.verdict.text


def test_an_order_beyond_that_would_win_is_a_caveat():
    """Truth order 5 compared up to 2: its probability among 1 to 5 from five refits."""
    axis = defended(camera_points(40, (*LINE, 0, 0, 0, 12), 1.0, 1), (1, 2))
    z = [refitted_evidence(axis.data, k, range(40), axis.noise, axis.prior) for k in range(1, 6)]
    chance = np.exp(z - np.logaddexp.reduce(z))
    assert chance[4] > 0.99
    (caveat,) = [c for c in axis.verdict.caveats if "order 5" in c and "beyond" in c]
    assert f"{percent(chance[4])} with orders 3, 4, 5 compared too" in caveat
    assert "compare more orders" in caveat
    assert "would take its place" not in axis.verdict.text


def test_an_order_left_out_between_is_not_said_to_lose():
    """Truth order 2, compared 1 and 3 only: order 2 would win, whatever is beyond."""
    axis = defended(camera_points(60, (*LINE, 60), 1.0, 1), (1, 3))
    options = (axis.data, 2, range(60), axis.noise, axis.prior)
    assert refitted_evidence(*options) > axis[3].log_evidence + 1
    assert axis.verdict.order == 3
    assert "No order up to" not in axis.verdict.text


def test_an_order_alone_is_not_said_to_win():
    """Nothing else was fitted; orders beyond it were tried and are named."""
    axis = defended(camera_points(40, (*LINE, 60), 1.0, 1), (2,))
    assert not re.search(r"\bwins?\b|removal|resamples", axis.verdict.text)
    assert axis.defence.beyond.orders == (3, 4, 5)
    assert "orders 3, 4, 5 were tried" in axis.verdict.text


@pytest.mark.parametrize(("order", "said"), [(3, ["order 4, which was not"]), (4, [])])
def test_an_order_alone_says_the_same_of_higher_ones_defended_or_not(order, said):
    """Truth: of r order 4 has 84 % of orders 1 to 5, which is named against 3 alone."""
    alone = bc.compare(bc.thesis(), [order], axis="r", ess=400)["r"]
    for axis in (alone, defended(bc.thesis(), (order,))):
        edge = [f.because for f in axis.verdict.findings if f.kind == "edge"]
        assert [text[:22] for text in edge] == said
        assert "can't be excluded" not in axis.verdict.text


def test_what_the_defence_has_seen_takes_the_place_of_what_was_unseen():
    axis = defended(bc.thesis(), (3, 4))
    unseen = overturns(UNSEEN, "nobody looked beyond order 4", "higher orders were not compared")
    verdict = axis.verdict.with_findings([unseen])
    assert "higher orders were not compared" in verdict.text
    criteria = {r.order: r.criteria for r in axis.orders}
    argued = argue(verdict, axis.defence, criteria, 1920.0)
    assert argued.findings == axis.verdict.findings


def test_a_straight_winner_at_every_tau_is_said(weak_curve):
    """The text's borders of tau are those of the curve, in per cent and px."""
    r = defended(bc.thesis(), (3, 4))
    words = r"It wins at every strength tau that these data leave possible, (\S+)% to (\S+)% of the"
    shares = [float(share) for share in re.search(words, r.verdict.text).groups()]
    tau, evidence = r.defence.tau.tau, r.defence.tau.log_evidence.max(axis=0)
    kept = tau[evidence > evidence.max() - 5]  # 2 ln B up to 10
    assert shares == pytest.approx([100 * kept[0], 100 * kept[-1]], rel=0.05)
    border = weak_curve.defence.tau.wins[0].upper
    assert [w.order for w in weak_curve.defence.tau.wins] == [2, 1]
    found = re.findall(
        r"order (\d) from ([\d.]+)% to ([\d.]+)% of the image", weak_curve.verdict.text
    )
    assert [k for k, *_ in found] == ["2", "1"]
    assert float(found[0][2]) == pytest.approx(100 * border, rel=0.05)
    assert float(found[1][1]) == pytest.approx(100 * border, rel=0.05)
