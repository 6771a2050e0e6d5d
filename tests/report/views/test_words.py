"""What could be wrong stands beside an answer in large type, the gravest first."""

from __future__ import annotations

from bayescal.comparison.finding import limits, overturns, wrong_model
from bayescal.report.views.words import doubts
from tests.report.views.test_remember import verdict

PINHOLE = wrong_model("another-model", "pinhole is better", "another model is very strongly better")
BAD = overturns("misfit: normality", "Skewness 3", "the noise is not normal")
MILD = limits("convergence", "too few draws")


def test_a_wrong_model_is_told_before_what_is_not_excluded():
    open_ = verdict(MILD, plausible=(2, 3), chances=(0.6, 0.4)).with_findings((BAD, PINHOLE))
    assert doubts(open_) == (
        "another model is very strongly better",
        "the noise is not normal",
        "order 3 not excluded",
        "1 more caveat below",
    )


def test_an_answer_that_stands_has_its_caveats_alone():
    assert doubts(verdict(MILD)) == ("1 caveat below",)
    assert doubts(verdict()) == ()
