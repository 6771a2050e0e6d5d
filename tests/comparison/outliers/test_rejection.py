"""The elimination: its statistic, its level on clean data, and what it finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import bayescal as bc
from bayescal.comparison.outliers.rejection import RejectionRule, point_tests, reject
from bayescal.linear.design_fit import fit_design
from tests.helpers.listing import columns

N, P = 20, 3
DESIGN = np.vander(np.linspace(-1, 1, N), P)  # leverages from 0.1 to 0.4


def noise(seed: int, n: int = N) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=n)


def dropped_by_a_free_point(design: np.ndarray, t: np.ndarray, point: int) -> tuple[float, float]:
    """RSS without and with a column that gives one point a shift of its own."""
    shift = np.zeros(len(t))
    shift[point] = 1
    return tuple(
        float(np.linalg.lstsq(d, t, rcond=None)[1][0])
        for d in (design, np.column_stack([design, shift]))
    )


@given(st.integers(0, 10**6), st.integers(0, N - 1))
def test_statistic_is_the_f_or_chi_squared_test_of_a_shift_of_that_point(seed, point):
    """Independent derivation: the likelihood-ratio test of a mean-shift outlier."""
    t = noise(seed)
    before, after = dropped_by_a_free_point(DESIGN, t, point)
    f, chi2 = (before - after) / (after / (N - P - 1)), (before - after) / 0.7**2
    fit = fit_design(DESIGN, t)
    for sigma, truth, p_value in (
        (None, f, stats.f.sf(f, 1, N - P - 1)),
        (0.7, chi2, stats.chi2.sf(chi2, 1)),
    ):
        tests = point_tests(fit, sigma)
        assert tests.standardised[point] ** 2 == pytest.approx(truth, rel=1e-8, abs=1e-10)
        assert np.sign(tests.standardised[point]) == np.sign(fit.residuals[point])
        assert tests.p_values[point] == pytest.approx(p_value, rel=1e-8)


@pytest.mark.parametrize("sigma", [None, 1.0])
@pytest.mark.parametrize("level", [0.05, 0.05 / 57, 1e-12])
def test_threshold_is_where_the_p_value_is_the_level(sigma, level):
    tests = point_tests(fit_design(DESIGN, noise(1)), sigma)
    square = tests.threshold(level) ** 2
    p_value = stats.chi2.sf(square, 1) if sigma else stats.f.sf(square, 1, N - P - 1)
    assert p_value == pytest.approx(level, rel=1e-9)


def false_alarms(sigma: float | None, rule: RejectionRule, repeats: int) -> float:
    """How often something is removed from data that is right, with noise of 1."""
    rng = np.random.default_rng(20)
    found = 0
    for t in rng.normal(size=(repeats, N)):
        tests = point_tests(fit_design(DESIGN, t), sigma)
        found += bool((tests.p_values <= rule.level(N)).any())
    return found / repeats


@pytest.mark.parametrize("level", [0.05, 0.2])
@pytest.mark.parametrize("sigma", [None, 1.0])
def test_clean_data_loses_a_point_as_often_as_the_level_says(sigma, level):
    """Truth between level - level^2 and level (Bonferroni), to 4 binomial errors."""
    repeats = 4000
    rate = false_alarms(sigma, RejectionRule(level, sigma=sigma), repeats)
    error = np.sqrt(level * (1 - level) / repeats)
    assert level - level**2 - 4 * error < rate < level + 4 * error


def test_a_wrong_sigma_breaks_that_level():
    """Negative control: sigma stated 20 % too small."""
    rate = false_alarms(0.8, RejectionRule(0.05, sigma=0.8), 1000)
    assert rate > 0.05 + 10 * np.sqrt(0.05 * 0.95 / 1000)


@pytest.mark.parametrize("sigma", [None, 1.0])
def test_one_clean_point_is_called_bad_as_often_as_the_level_per_point(sigma):
    """Exact at every leverage; one point a data set, so that the trials are independent."""
    repeats, level = 4000, 0.05
    data = np.random.default_rng(21).normal(size=(repeats, N))
    for point in (0, N // 2):
        hits = sum(point_tests(fit_design(DESIGN, t), sigma).p_values[point] < level for t in data)
        assert abs(hits / repeats - level) < 4 * np.sqrt(level * (1 - level) / repeats)


def test_chi_squared_with_sigma_from_the_same_residuals_could_never_reject_here():
    """Negative control: e^2 / (s^2 (1 - h)) can't exceed n - p, below chi-squared's threshold."""
    n, p = 8, 3
    design = np.vander(np.linspace(-1, 1, n), p)
    t = noise(3, n)
    t[4] += 1000
    fit = fit_design(design, t)
    internal = fit.residuals**2 / (fit.rss / fit.dof) / (1 - fit.leverages)
    assert internal.max() <= (n - p) * (1 + 1e-12) < stats.chi2.isf(0.05 / n, 1)
    assert reject(design, t).removed == (4,)


@pytest.mark.parametrize("sigma", [None, 1.0])
def test_a_planted_point_goes_first_wherever_it_is(sigma):
    rule = RejectionRule(1e-4, sigma=sigma)
    for point in range(N):
        t = noise(100 + point)
        t[point] += 15
        found = reject(DESIGN, t, rule)
        assert found.removed == (point,)
        step = found.steps[0]
        assert (step.n_points, step.level) == (N, 1e-4 / N)
        assert step.residual == found.before.residuals[point]
        assert found.stopped == "none significant"


@given(st.integers(0, 10**6), st.sampled_from([None, 0.5]), st.booleans())
def test_steps_add_up(seed, sigma, per_point):
    t = noise(seed)
    rule = RejectionRule(0.2, per_point=per_point, sigma=sigma)
    found = reject(DESIGN, t, rule)
    assert sorted([*found.removed, *found.kept]) == list(range(N))
    assert found.kept.tolist() == sorted(found.kept)
    again = fit_design(DESIGN[found.kept], t[found.kept])
    assert again.rss == pytest.approx(found.after.rss, rel=1e-9, abs=1e-12)
    assert found.before.rss == pytest.approx(fit_design(DESIGN, t).rss)
    for i, step in enumerate(found.steps):
        assert step.n_points == N - i
        assert step.level == (0.2 if per_point else 0.2 / (N - i))
        assert step.p_value <= step.level
    if found.stopped == "none significant":
        left = point_tests(found.after, sigma)
        assert left.p_values.min() > rule.level(len(found.kept))


def by_hand(variant: str, axis: str, order: int, *, per_point: bool) -> list[int]:
    """The elimination with lstsq and scipy, straight from its definition."""
    x, y, z = bc.thesis().camera_frame().T
    design, t = np.column_stack(columns(variant, axis, order, x, y, z)), bc.thesis().pixel(axis)
    kept, removed = list(range(len(t))), []
    while len(kept) - order - 2 >= 1:
        d, v, m = design[kept], t[kept], len(kept) - order - 2
        p_values = []
        for i in range(len(kept)):
            before, after = dropped_by_a_free_point(d, v, i)
            p_values.append(stats.f.sf((before - after) / (after / m), 1, m))
        best = int(np.argmin(p_values))
        if p_values[best] > (0.05 if per_point else 0.05 / len(kept)):
            break
        removed.append(kept.pop(best) + 1)
    return removed


@pytest.mark.parametrize(
    ("variant", "axis", "order", "per_point", "goes"),
    [
        ("as-written", "r", 1, False, [1, 2, 3, 6, 44, 4]),
        ("as-written", "r", 3, False, []),
        ("as-written", "r", 4, False, [44, 6]),
        ("as-coded", "r", 5, False, []),
        ("as-coded", "c", 1, False, [16, 19, 1]),
        ("as-written", "r", 4, True, [44, 6, 4, 1]),
    ],
)
def test_points_of_the_thesis_that_go_are_those_of_an_elimination_by_hand(
    variant, axis, order, per_point, goes
):
    x, y, z = bc.thesis().camera_frame().T
    design = np.column_stack(columns(variant, axis, order, x, y, z))
    found = reject(design, bc.thesis().pixel(axis), RejectionRule(per_point=per_point))
    assert [point + 1 for point in found.removed] == goes
    assert by_hand(variant, axis, order, per_point=per_point) == goes


def test_it_stops_where_too_few_points_are_left():
    design, t = np.vander(np.arange(3.0), 2), np.array([0.0, 1, 5])
    assert reject(design, t).stopped == "too few points"  # no residual but the point's own
    known = reject(design, t, RejectionRule(sigma=0.01))
    assert (len(known.removed), len(known.kept)) == (1, 2)
    assert known.stopped == "exact fit"  # two points on a line


def test_one_point_off_an_exact_line_goes_and_the_rest_is_left_alone():
    x = np.arange(9.0)
    t = 3 + 2 * x
    t[5] += 1
    found = reject(np.column_stack([np.ones(9), x]), t)
    assert (found.removed, found.stopped) == ((5,), "exact fit")


def test_a_point_that_alone_fixes_a_coefficient_is_never_removed():
    design = np.column_stack([np.ones(N), np.eye(N)[7]])
    t = noise(9)
    t[7] = 1e3
    t[2] = 50.0
    tests = point_tests(fit_design(design, t), None)
    assert np.isnan(tests.standardised[7])
    assert reject(design, t, RejectionRule(0.9, per_point=True)).removed[0] == 2
    assert 7 not in reject(design, t, RejectionRule(0.9, per_point=True)).removed


def test_residuals_of_an_exact_fit_are_not_tested():
    x = np.arange(9.0)
    assert point_tests(fit_design(np.column_stack([np.ones(9), x]), 3 + 2 * x), None) is None


@pytest.mark.parametrize("significance", [0.0, 1.0, -0.1, float("nan")])
def test_a_significance_that_is_no_probability_is_refused(significance):
    with pytest.raises(bc.InputError, match="between 0 and 1"):
        RejectionRule(significance)


@pytest.mark.parametrize("sigma", [0.0, -1.0, float("nan"), float("inf")])
def test_a_sigma_that_is_no_deviation_is_refused(sigma):
    with pytest.raises(bc.InputError, match="positive number of px"):
        RejectionRule(sigma=sigma)
