"""Three lines close a defence: what is recommended, what stands against it, what to do next."""

from __future__ import annotations

from bayescal.comparison.finding import limits, overturns
from bayescal.comparison.orders.verdict import AxisVerdict
from bayescal.report.views.remember import remembered


def verdict(*findings, plausible=(2,), chances=(0.97,), compared=3):
    return AxisVerdict(
        order=2,
        compared=compared,
        plausible=plausible,
        chances=chances,
        log_bayes_factor_to_next=3.0,
        strength="strong",
        aicc_order=2,
        bic_order=2,
        findings=findings,
        sentences=(),
    )


def lines(**verdicts):
    (listing,) = remembered(verdicts).blocks
    return listing.items


def test_nothing_against_it():
    assert lines(r=verdict()) == (
        "Recommended: r: order 2 (97.0%).",
        "Against it: nothing that was looked for.",
        "Next: nothing: use it.",
    )


def test_an_order_alone_has_no_probability_to_remember():
    alone = lines(r=verdict(chances=(1.0,), compared=1))
    assert alone[0] == "Recommended: r: order 2 (the only one compared)."


def test_the_gravest_finding_says_what_to_do_and_axes_are_named_where_they_differ():
    bad = overturns("misfit: normality", "Skewness 3", "the noise is not normal")
    mild = limits("convergence", "too few draws")
    assert lines(r=verdict(mild, bad), c=verdict(plausible=(2, 3), chances=(0.6, 0.4)))[1:] == (
        "Against it: the noise is not normal (r); order 3 not excluded (c).",
        "Next: bayescal outliers.",
    )


def test_what_limits_a_verdict_is_not_nothing():
    ahead = limits("leave-one-out", "leave-one-out clearly prefers order 5")
    near = limits("misfit: neighbours", "residuals of neighbours are alike")
    assert lines(r=verdict(ahead))[1:] == (
        "Against it: caveats on leave-one-out.",
        "Next: read the caveats.",
    )
    assert (
        "caveats on leave-one-out, neighbours (r)" in lines(r=verdict(ahead, near), c=verdict())[1]
    )


def test_what_is_open_asks_for_points():
    assert lines(r=verdict(plausible=(2, 3), chances=(0.6, 0.4)))[1:] == (
        "Against it: order 3 not excluded.",
        "Next: more or better points.",
    )
