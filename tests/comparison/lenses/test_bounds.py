"""Sigma and tau of lenses at the bounds of their priors are said, and what tau's bound decides."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import bayescal as bc
from bayescal.calibration.model import lens_model
from bayescal.comparison.findings.bounds import PILE
from bayescal.comparison.lenses.caveats.bounds import LOWEST, lift
from bayescal.comparison.lenses.results import LensComparison
from tests.helpers import boards


def found(k1: float, sigma: float, *lenses: str, independent: bool = True) -> LensComparison:
    world, pixels = boards.pictures(
        np.random.default_rng(1), 8, k=(k1, 0.0, 0.0, 0.0, 0.0), sigma=sigma
    )
    width, height = map(int, boards.SIZE)
    views = bc.Views.from_arrays([world] * 8, list(pixels), width=width, height=height)
    return bc.calibrate(views, lenses=lenses, independent=independent, ess=100)


@pytest.fixture(scope="module")
def faint() -> LensComparison:
    """Compare lenses on a distortion of 0.1 px at the corner, a sixth of tau's lower bound."""
    return found(-0.0005, 0.02, "pinhole", "radial 1")


def said(result: LensComparison) -> dict[str, tuple[str, bool]]:
    return {f.kind: (f.text, f.withholds) for f in result.verdict.findings}


def test_a_lower_bound_that_chooses_the_lens_withholds_the_verdict(faint: LensComparison) -> None:
    text, withholds = said(faint)["tau-bound"]
    assert faint.best.name == "pinhole"
    assert withholds
    assert "radial 1 would win over pinhole" in text
    assert faint.verdict.status == "best compared"


def test_what_another_bound_would_do_is_what_it_does(
    faint: LensComparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Truth: the evidence under that prior, by its own importance draws."""
    monkeypatch.setattr(lens_model, "WIDE", (LOWEST / boards.SIZE[0], 0.5))
    again = found(-0.0005, 0.02, "pinhole", "radial 1")
    before, after = faint["radial 1"], again["radial 1"]
    error = math.hypot(before.log_evidence_error, after.log_evidence_error)
    gain = after.log_evidence - before.log_evidence
    assert lift(before) == pytest.approx(gain, abs=4 * error + 0.1)  # Laplace, 1000 draws
    assert gain > 1
    assert again.best.name == "radial 1"
    assert "tau-bound" not in said(again)


def test_a_bound_that_lowers_the_evidence_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Truth: the evidence under the other bound, by its own importance draws."""
    result = found(-0.0007, 0.01, "pinhole", "radial 1")
    text, withholds = said(result)["tau-bound"]
    assert result.best.name == "radial 1"
    assert not withholds
    lift = re.search(
        r"radial 1: tau \(radial\) lies at its lower bound, 0.64 px; were that 0.010 px, the "
        r"evidence would be (\d\.\d) nat higher",
        text,
    )
    assert lift
    monkeypatch.setattr(lens_model, "WIDE", (LOWEST / boards.SIZE[0], 0.5))
    again = found(-0.0007, 0.01, "radial 1").best
    error = math.hypot(result.best.log_evidence_error, again.log_evidence_error)
    gain = again.log_evidence - result.best.log_evidence
    assert float(lift[1]) == pytest.approx(gain, abs=0.05 + 4 * error + 0.1)


@pytest.mark.parametrize("k1", [-0.28, -0.004])
def test_a_strength_whose_bound_costs_nothing_is_no_caveat(k1: float) -> None:
    """Negative control: at -0.004 some mass lies at the bound, and a lower one would cost more."""
    result = found(k1, 0.05, "radial 1")
    (group,) = [g for g in result.best.evidence.problem.model.groups if g.name == "radial"]
    assert (result.drawn.posterior.at_bounds("tau radial", group.bounds)[0] > PILE) == (k1 > -0.1)
    assert "tau-bound" not in said(result)


def test_a_flat_target_is_no_caveat() -> None:
    """Every lens has the same bow: how small it is chooses none."""
    result = found(-0.28, 0.05, "radial 1", "radial 2", independent=False)
    (bow,) = [g for g in result.best.evidence.problem.model.groups if g.name == "bow"]
    assert result.drawn.posterior.at_bounds("tau bow", bow.bounds)[0] > PILE
    assert "tau-bound" not in said(result)


def test_noise_below_all_that_the_prior_allows_withholds_the_verdict() -> None:
    text, withholds = said(found(-0.28, 0.002, "radial 1", "radial 2"))["sigma-bound"]
    assert withholds
    assert "100% of sigma's posterior lies at its lower bound, 0.01 px" in text
