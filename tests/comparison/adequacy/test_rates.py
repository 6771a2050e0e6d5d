"""False alarms on null data in the thesis's layout, and power on planted faults.

Every rate is of 5 % tests; its tolerance is 4 binomial standard errors.
"""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.coordinate import other_coordinate, other_coordinate_within
from bayescal.comparison.adequacy.groups import shared_errors
from bayescal.comparison.adequacy.heteroscedasticity import heteroscedasticity
from bayescal.comparison.adequacy.level import chi_squared
from bayescal.comparison.adequacy.normality import normality
from bayescal.comparison.adequacy.null import simulated_residuals
from bayescal.comparison.adequacy.outcome import AdequacyTest
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.replicates import lack_of_fit, lack_of_fit_scatter
from bayescal.comparison.adequacy.sequence import runs_test, wald_wolfowitz
from bayescal.linear.least_squares import factorise, solve
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import thesis_axis

LAYOUTS = [("r", 4), ("c", 1)]
REPEATS = 800
SIGMA = 3.0


@cache
def template(axis: str, order: int):
    """An axis and a fit of it: the checks take only its order and dof from the fit."""
    data = thesis_axis(axis)
    return data, solve(factorise(data, order), order)


def null_problem(axis: str, order: int, error) -> Problem:
    data, fit = template(axis, order)
    data = dataclasses.replace(data, t=900 + 1200 * data.x + error)
    return Problem.of(data, fit, NoiseLevel.known(SIGMA))


@cache
def layout(axis: str):
    other = thesis_axis("c" if axis == "r" else "r").x
    return other, bc.thesis().camera_frame()[:, 2]


@cache
def rejections(axis: str, order: int) -> dict[str, float]:
    """Share of null data sets with p below 5 %, by test."""
    rng = np.random.default_rng(20)
    other, depth = layout(axis)
    null = simulated_residuals(null_problem(axis, order, np.zeros(57)).q, rng, 999)
    counts: dict[str, int] = {}
    for _ in range(REPEATS):
        problem = null_problem(axis, order, rng.normal(size=57) * SIGMA)
        found = [
            chi_squared(problem),
            lack_of_fit_scatter(problem, other),
            other_coordinate(problem, other),
            other_coordinate_within(problem, other),
            runs_test(problem, rng, 399),
            heteroscedasticity(problem, depth, null),
            normality(problem),
            shared_errors(problem, None, depth),
        ]
        for test in found:
            counts[test.name] = counts.get(test.name, 0) + (test.p_value < 0.05)
    return {name: count / REPEATS for name, count in counts.items()}


@pytest.mark.parametrize(("axis", "order"), LAYOUTS)
def test_five_per_cent_of_null_data_are_rejected(axis, order):
    tolerance = 4 * np.sqrt(0.05 * 0.95 / REPEATS)
    for name, rate in rejections(axis, order).items():
        assert rate < 0.05 + tolerance, name
        if not name.startswith("runs"):  # discrete: its size is below 5 %
            assert rate > 0.05 - tolerance, name


def test_replicates_reject_at_their_level():
    rng = np.random.default_rng(3)
    other, _ = layout("r")
    data = thesis_axis("r")
    x, u = np.tile(data.x, 2), np.tile(other, 2)
    doubled = dataclasses.replace(data, x=x, t=np.tile(data.t, 2), labels=data.labels * 2)
    fit, hits = solve(factorise(doubled, 4), 4), 0
    for _ in range(REPEATS):
        doubled = dataclasses.replace(doubled, t=900 + 1200 * x + rng.normal(size=114))
        test = lack_of_fit(Problem.of(doubled, fit, NoiseLevel.inferred()), u)
        assert test.dof == (52, 57)
        hits += test.p_value < 0.05
    assert abs(hits / REPEATS - 0.05) < 4 * np.sqrt(0.05 * 0.95 / REPEATS)


def test_wald_wolfowitz_itself_is_not_calibrated_here():
    """Negative control: why runs are simulated. 22 places, 5 coefficients."""
    rng = np.random.default_rng(1)
    noise = rng.standard_normal((4000, 22))
    q = np.linalg.qr(np.vander(np.linspace(-1, 1, 22), 5))[0]
    fitted, independent = (_runs_scores(e) for e in (noise - (noise @ q) @ q.T, noise))
    assert abs(independent.mean()) < 4 / np.sqrt(4000)
    assert fitted.mean() > 0.4  # fitting makes signs alternate
    # Too few runs, the mark of a misfit, are met at less than half the stated rate.
    assert (fitted < -1.645).mean() < (independent < -1.645).mean() / 2


def _runs_scores(residuals) -> np.ndarray:
    signs = residuals > 0
    runs = 1 + (signs[:, 1:] != signs[:, :-1]).sum(axis=1)
    moments = [wald_wolfowitz(int(s.sum()), int((~s).sum())) for s in signs]
    return np.array([(r - m) / s for r, (m, s) in zip(runs, moments, strict=True)])


def plant(kind: str, rng, other, depth, x) -> np.ndarray:
    noise = rng.normal(size=57) * SIGMA
    if kind == "groups":
        planes = np.unique(depth, return_inverse=True)[1]
        return noise + rng.normal(size=9)[planes] * 2 * SIGMA
    if kind == "cross term":
        return noise + 120 * x * other
    if kind == "depth":
        return noise * (300 / depth) * 4
    if kind == "outliers":
        return np.where(rng.random(57) < 0.1, 6, 1) * noise
    assert kind == "bend"
    return noise + 8 * np.cos(6 * x)


POWER = {
    "groups": "shared errors in groups",
    "cross term": "other coordinate",
    "depth": "uneven noise",
    "outliers": "normality",
    "bend": "runs along the regressor",
}


@pytest.mark.parametrize("kind", POWER)
def test_planted_faults_are_found(kind):
    rng = np.random.default_rng(30)
    other, depth = layout("r")
    x = thesis_axis("r").x
    hits, repeats = 0, 60
    for _ in range(repeats):
        problem = null_problem("r", 1, plant(kind, rng, other, depth, x))
        found = {
            "shared errors in groups": lambda p: shared_errors(p, None, depth),
            "other coordinate": lambda p: other_coordinate(p, other),
            "uneven noise": lambda p: heteroscedasticity(
                p, depth, simulated_residuals(p.q, rng, 499)
            ),
            "normality": normality,
            "runs along the regressor": lambda p: runs_test(p, rng, 499),
        }[POWER[kind]](problem)
        assert isinstance(found, AdequacyTest)
        hits += found.p_value < 0.05
    assert hits / repeats > 0.7


def test_the_planted_cross_term_is_named_and_measured():
    rng = np.random.default_rng(0)
    other, _ = layout("r")
    x = thesis_axis("r").x
    test = other_coordinate(null_problem("r", 2, 200 * x * other + rng.normal(size=57)), other)
    assert "strongest alone is x/z * y/z" in test.meaning


def test_the_shared_error_is_recovered_on_average():
    """Between and within variances are unbiased (Henderson), truncation at 0 apart."""
    from bayescal.comparison.adequacy.groups import group_effects
    from bayescal.linear.replicates import clusters

    rng = np.random.default_rng(12)
    other, depth = layout("r")
    x, group = thesis_axis("r").x, clusters(depth)
    found = [
        group_effects(null_problem("r", 4, plant("groups", rng, other, depth, x)), group)
        for _ in range(600)
    ]
    for values, truth in (([f.between for f in found], 36.0), ([f.within for f in found], 9.0)):
        assert abs(np.mean(values) - truth) < 4 * np.std(values) / np.sqrt(600)


def test_false_concerns_of_a_whole_block_are_below_five_per_cent():
    rng = np.random.default_rng(40)
    other, depth = layout("r")
    hits, repeats = 0, 150
    for _ in range(repeats):
        problem = null_problem("r", 4, rng.normal(size=57) * SIGMA)
        tests = adequacy(problem.data, template("r", 4)[1], problem.noise, other, depth, rng=rng)
        hits += any(test.concern for test in tests)
    assert hits / repeats < 0.05 + 4 * np.sqrt(0.05 * 0.95 / repeats)
