"""Lenses whose posterior is no normal: hopeless ones bounded, rivals weighed again, or named."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import bayescal as bc
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.evidence import adapted, ceiling, weighed
from bayescal.calibration.judging.judge import UNMET
from bayescal.comparison.lenses.results import LensComparison
from tests.helpers import boards


def calibrated(k: tuple[float, ...], *lenses: str) -> LensComparison:
    world, pixels = boards.pictures(np.random.default_rng(2), 10, k=k)
    width, height = map(int, boards.SIZE)
    views = bc.Views.from_arrays([world] * 10, list(pixels), width=width, height=height)
    return bc.calibrate(views, lenses=lenses, ess=100)


@pytest.fixture(scope="module")
def straight() -> LensComparison:
    """A pinhole, which a double sphere can be along a ridge."""
    return calibrated((0.0,) * 5, "pinhole", "double-sphere")


def test_an_adapted_proposal_has_the_same_evidence_as_draws_about_the_mode(
    straight: LensComparison,
) -> None:
    """Truth: importance draws where they are good."""
    problem = straight["pinhole"].evidence.problem
    first, _, _ = weighed(problem, np.random.default_rng(0))
    again = adapted(problem, np.random.default_rng(1), 2000)
    error = math.hypot(first.error, again.error)
    assert again.effective_fraction > 0.5
    assert again.log_evidence == pytest.approx(first.log_evidence, abs=4 * error)
    assert first.log_evidence < ceiling(problem)


def test_a_rival_along_a_ridge_is_weighed(straight: LensComparison) -> None:
    """Truth: twice as many draws, of another adaptation."""
    rival = straight["double-sphere"]
    assert rival.evidence.estimate.effective_fraction > 0.03  # of 0.005 before; 0.05 to 0.5 by seed
    assert rival.log_evidence_error < 0.15
    again = adapted(rival.evidence.problem, np.random.default_rng(5), 4000)
    error = math.hypot(rival.evidence.estimate.error, again.error)
    assert rival.evidence.estimate.log_evidence == pytest.approx(again.log_evidence, abs=4 * error)
    assert straight.verdict.status == "decided"
    assert straight.best.name == "pinhole"


@pytest.fixture(scope="module")
def wide() -> LensComparison:
    """A fisheye of 150 degrees, which radial lenses fold long before."""
    targets, pixels = zip(*boards.wide_pictures(np.random.default_rng(11)), strict=True)
    width, height = map(int, boards.SIZE)
    views = bc.Views.from_arrays(targets, pixels, width=width, height=height)
    return bc.calibrate(views, lenses=["pinhole", "radial 3", "fisheye 2"], ess=100)


def test_hopeless_lenses_spoil_no_comparison(wide: LensComparison) -> None:
    assert wide.best.name == "fisheye 2"
    assert wide.best.probability > 0.999
    assert not wide.failures
    lost = [j for j in wide.lenses if j.warnings]
    assert lost
    assert all(j.probability < 1e-100 for j in lost)


def test_what_is_said_of_a_posterior_that_was_not_found_is_an_upper_bound(
    wide: LensComparison,
) -> None:
    """The smallest sum of squares of the lens bounds its likelihood."""
    (lost,) = [j for j in wide.lenses if j.name == "pinhole"]
    assert lost.warnings == (UNMET,)
    assert math.isinf(lost.log_evidence_error)
    problem = lost.evidence.problem
    assert lost.log_evidence == ceiling(problem)
    assert lost.rms > 5  # px


@pytest.mark.parametrize("further", [0.02, 0.2])
def test_far_poses_are_followed_until_they_fit(straight: LensComparison, further: float) -> None:
    """Truth: poses linearised anew at each of ten steps, the lens held."""
    problem: Problem = straight["pinhole"].evidence.problem
    x = problem.x + np.array([further, *np.zeros(len(problem.x) - 1)])  # of ln f
    there = dataclasses.replace(problem, x=x, poses=problem.poses_at(x))
    for _ in range(10):
        there = dataclasses.replace(there, poses=there.poses_at(x))
    (truth,) = there.squares(x[None])
    assert truth > 1.05 * problem.squares(problem.x[None])
    assert problem.squares(x[None]) == pytest.approx(truth, rel=0.02)
