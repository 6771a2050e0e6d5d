"""What is said of other noise models: leads against their errors, and what sigma stands for."""

from __future__ import annotations

import pytest

import bayescal as bc
from bayescal.comparison.defence.other_noise import noise_words
from bayescal.comparison.judged import Judged
from bayescal.comparison.key import Key
from bayescal.report.views.orders.evidence import noises_note


def judged(noise, lead, error, warnings=()):
    """Order 2 of c under some noise, so much more probable than exp(-100)."""
    return Judged(
        key=Key.of_axis("c", 2, noise),
        log_evidence=-100.0 + lead,
        log_evidence_error=error,
        warnings=warnings,
    )


def other(lead, error, warnings=()):
    return judged("student-t", lead, error, warnings)


@pytest.mark.parametrize(
    ("lead", "error", "own_error", "said"),
    [
        (5.0, 0.01, 0.01, True),
        (0.9, 0.01, 0.01, False),  # 2 ln B below 2
        (1.5, 0.6, 0.0, False),  # within the other's error
        (1.5, 0.0, 0.6, False),  # within one's own
    ],
)
def test_a_lead_counts_beyond_the_errors_of_both(lead, error, own_error, said):
    text, caveat = noise_words(judged("outlier-mixture", 0.0, own_error), [other(lead, error)])
    assert (caveat is not None) == said
    assert bool(text) != said


def test_a_lead_that_rests_on_a_doubtful_evidence_says_so():
    _, caveat = noise_words(judged("gaussian", 0.0, 0.0), [other(9.0, 0.01, ("Pareto k",))])
    assert "should not be trusted" in caveat


@pytest.mark.parametrize(("sigma", "said"), [(2.0, True), (None, False)])
def test_a_known_sigma_is_no_standard_deviation_under_student_t(sigma, said):
    found = bc.compare(bc.thesis(), [1], axis="c", noise="student-t", sigma=sigma, ess=100)
    caveats = found.axes["c"].verdict.caveats
    assert any("taken as the scale of the t" in c for c in caveats) == said


def test_the_priors_of_other_noise_are_printed(thesis_comparison):
    """Gamma has two parametrisations, and an evidence without its prior says nothing."""
    student, mixture = other(1.0, 0.01), judged("outlier-mixture", 1.0, 0.01)
    line = noises_note(thesis_comparison.axes["c"], (student, mixture))
    assert "Gamma(shape 2, rate 0.1)" in line
    assert "log-uniform from 5 to 1000 px" in line
