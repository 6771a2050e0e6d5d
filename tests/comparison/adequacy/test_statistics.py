"""Each adequacy statistic against a dense refit, a published closed form or scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from bayescal.comparison.adequacy.coordinate import other_coordinate, other_coordinate_within
from bayescal.comparison.adequacy.groups import effective_points, group_effects, shared_errors
from bayescal.comparison.adequacy.heteroscedasticity import heteroscedasticity
from bayescal.comparison.adequacy.level import chi_squared, whole_pixels
from bayescal.comparison.adequacy.normality import normality, shapiro_wilk
from bayescal.comparison.adequacy.null import simulated_residuals
from bayescal.comparison.adequacy.outcome import holm
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.replicates import lack_of_fit, lack_of_fit_scatter
from bayescal.comparison.adequacy.sequence import runs_test, wald_wolfowitz
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.replicates import clusters, pure_error
from bayescal.noise.level import NoiseLevel
from tests.helpers.problems import make_axis
from tests.helpers.residual_problems import problem


def refit(columns, t, sd=None) -> tuple[float, int, np.ndarray]:
    """RSS, rank and fitted values by lstsq on raw columns."""
    w = np.ones(len(t)) if sd is None else 1 / np.asarray(sd)
    columns = np.column_stack(columns)
    beta, _, rank, _ = np.linalg.lstsq(columns * w[:, None], t * w, rcond=1e-12)
    return float(((t - columns @ beta) ** 2 * w**2).sum()), int(rank), columns @ beta


@pytest.fixture(params=[False, True], ids=["plain", "weighted"])
def case(request):
    """40 points, 10 places, 5 planes; dependent on everything a little."""
    rng = np.random.default_rng(2)
    x = np.repeat(np.linspace(-0.5, 0.6, 10), 4)
    other = np.tile([-0.3, 0.1, 0.1, 0.4], 10)
    sd = rng.uniform(0.5, 2, 40) if request.param else None
    t = 900 + 1200 * x + 3 * other + 2 * x * other + rng.normal(size=40) * 1.3
    depth = rng.choice([300.0, 450, 600, 750, 900], 40)
    return x, other, t, sd, depth


def powers(x, order):
    return [x**j for j in range(order + 1)]


def test_nested_f_tests_equal_dense_refits(case):
    x, u, t, sd, _ = case
    fitted = problem(x, t, 2, sd)
    test = other_coordinate(fitted, u)
    base, p, base_fit = refit(powers(x, 2), t, sd)
    added = [[u], [u**2], [x * u], [u, u**2, x * u]]
    for found, extra in zip([*test.parts, test], added, strict=True):
        rss, rank, fit = refit(powers(x, 2) + extra, t, sd)
        dof = (rank - p, 40 - rank)
        f = (base - rss) / dof[0] / (rss / dof[1])
        assert found.dof == dof
        np.testing.assert_allclose(found.value, f, rtol=1e-7)
        np.testing.assert_allclose(found.p_value, stats.f.sf(f, *dof), rtol=1e-6)
        worth = np.sqrt(np.mean((fit - base_fit) ** 2))
        assert f"{worth:.2g} px" in (found.meaning if found is not test else test.meaning)


def test_dependence_at_equal_regressor_equals_a_fit_with_a_mean_per_place(case):
    x, u, t, sd, _ = case
    test = other_coordinate_within(problem(x, t, 2, sd), u)
    dummies = list((x[:, None] == np.unique(x)).T.astype(float))
    base, p, _ = refit(dummies, t, sd)
    rss, rank, _ = refit([*dummies, u, u**2, x * u], t, sd)
    assert test.dof == (rank - p, 40 - rank)
    np.testing.assert_allclose(test.value, (base - rss) / 3 / (rss / (40 - rank)), rtol=1e-7)


def test_pure_error_and_lack_of_fit_follow_their_definition(case):
    x, u, t, sd, _ = case
    w = np.ones(40) if sd is None else 1 / sd**2
    cells = [(x == a) & (u == b) for a in np.unique(x) for b in np.unique(u)]
    sspe = sum(float((w[c] * (t[c] - np.average(t[c], weights=w[c])) ** 2).sum()) for c in cells)
    sigma, dof = pure_error(x, u, t, sd)
    assert dof == 10
    np.testing.assert_allclose(sigma, np.sqrt(sspe / 10), rtol=1e-10)
    rss, _, _ = refit(powers(x, 2), t, sd)
    test = lack_of_fit(problem(x, t, 2, sd), u)
    assert test.dof == (27, 10)
    np.testing.assert_allclose(test.value, (rss - sspe) / 27 / (sspe / 10), rtol=1e-7)
    assert lack_of_fit_scatter(problem(x, t, 2, sd), u).dof == (7, 30)


def test_pure_error_by_hand():
    # Two readings 1 and 3 (mean 2, SS 2), three 5 5 8 (mean 6, SS 6), one alone.
    x, t = [0, 0, 1, 1, 1, 2], [1, 3, 5, 5, 8, 9]
    sigma, dof = pure_error(np.array(x, float), None, np.array(t, float))
    assert dof == 3
    assert sigma == pytest.approx(np.sqrt(8 / 3))
    assert pure_error(np.arange(3.0), None, np.arange(3.0)) == (None, 0)


def test_replicates_are_the_same_to_1e_9_of_the_domain_and_no_further():
    x = np.array([0, 0.5, 0.5 + 0.9e-9, 1, 1 - 1.1e-9])
    assert pure_error(x, None, x)[1] == 1
    assert pure_error(x, np.array([0, 1, 1 + 1e-6, 2, 2]), x)[1] == 0


def test_chi_squared_tails_are_those_of_scipy():
    rng = np.random.default_rng(0)
    x, t = np.linspace(-1, 1, 30), rng.normal(size=30) * 2
    found = chi_squared(problem(x, t, 1, sigma=1.2))
    chi2 = refit(powers(x, 1), t)[0] / 1.44
    np.testing.assert_allclose(found.value, chi2, rtol=1e-9)
    np.testing.assert_allclose(found.p_value, 2 * stats.chi2.sf(chi2, 28), rtol=1e-7)
    low = chi_squared(problem(x, t, 1, sigma=20.0))
    np.testing.assert_allclose(low.p_value, 2 * stats.chi2.cdf(low.value, 28), rtol=1e-7)
    assert "too large" in low.meaning


def test_koenker_is_n_r_squared_of_the_auxiliary_regression(case):
    x, _, t, sd, depth = case
    fitted = problem(x, t, 2, sd)
    test = heteroscedasticity(fitted, depth, None)
    squares = fitted.studentised**2
    total = float(((squares - squares.mean()) ** 2).sum())
    columns = [refit(powers(x, 2), t, sd)[2], np.abs(x), 1 / depth]
    for found, extra in zip([*test.parts, test], [*[[c] for c in columns], columns], strict=True):
        rss = refit([np.ones(40), *extra], squares)[0]
        lm = 40 * (1 - rss / total)
        np.testing.assert_allclose(found.value, lm, rtol=1e-6)
        np.testing.assert_allclose(found.p_value, stats.chi2.sf(lm, len(extra)), rtol=1e-6)


def test_group_effects_equal_dense_dummies_and_hendersons_method_three(case):
    x, _, t, sd, depth = case
    fitted = problem(x, t, 2, sd)
    group = clusters(depth)
    found = group_effects(fitted, group)
    w = np.ones(40) if sd is None else 1 / sd
    design = np.column_stack(powers(x, 2)) * w[:, None]
    dummies = (group[:, None] == np.arange(5)).astype(float)
    both = np.column_stack([design, dummies])
    y = t * w
    m = np.eye(40) - design @ np.linalg.pinv(design)
    m_both = np.eye(40) - both @ np.linalg.pinv(both)
    rank = np.linalg.matrix_rank(both) - 3
    assert (found.rank, found.dof) == (rank, 37 - rank)
    within = y @ m_both @ y / found.dof
    gain = y @ m @ y - y @ m_both @ y
    between = max(0, (gain - rank * within) / np.trace(dummies.T @ m @ dummies))
    np.testing.assert_allclose(
        [found.within, found.gain, found.between], [within, gain, between], rtol=1e-6, atol=1e-9
    )


def test_groups_of_a_constant_are_one_way_anova():
    """A regressor that no group mean depends on: F is scipy's on its residuals, near enough."""
    rng = np.random.default_rng(8)
    x = np.tile([-1.0, 1.0], 20)  # balanced within each of 4 groups of 10
    group = np.repeat(np.arange(4), 10)
    t = rng.normal(size=40) + np.repeat(rng.normal(size=4), 10)
    test = shared_errors(problem(x, t, 1), tuple("abcd"[g] for g in group), None)
    # The slope takes one dof from within: scipy's F on residuals has 36, ours 35.
    e = t - x * (x @ t / 40)
    f = stats.f_oneway(*(e[group == g] for g in range(4))).statistic * 35 / 36
    assert test.dof == (3, 35)
    np.testing.assert_allclose(test.value, f, rtol=1e-9)


def test_effective_points_at_the_ends():
    group = np.repeat(np.arange(5), 4)
    assert effective_points(group, 0.0) == 20
    assert effective_points(group, 1.0) == pytest.approx(5)
    uneven = np.repeat([0, 1], [1, 3])  # m0 = (4 - 10 / 4) / 1 = 1.5
    assert effective_points(uneven, 0.5) == pytest.approx(4 / 1.25)


def test_wald_wolfowitz_moments_by_enumeration():
    from itertools import combinations

    runs = []
    for chosen in combinations(range(9), 4):
        signs = np.isin(np.arange(9), chosen)
        runs.append(1 + (signs[1:] != signs[:-1]).sum())
    np.testing.assert_allclose(wald_wolfowitz(4, 5), (np.mean(runs), np.std(runs)), rtol=1e-12)


def test_simulated_runs_follow_a_plain_loop_of_refits():
    """Ties and weights included: polyfit on the points, signs of means, runs counted."""
    rng = np.random.default_rng(4)
    x = np.repeat(np.linspace(-1, 1, 8), [1, 3, 2, 1, 4, 2, 1, 3])
    sd = rng.uniform(0.5, 2, len(x))
    t = 5 * np.cos(2.5 * x)  # far from a line: few runs
    fitted = problem(x, t + rng.normal(size=len(x)) * 0.01, 1, sd)
    found = runs_test(fitted, rng, 20_000)
    counts = []
    for _ in range(2000):
        y = rng.normal(size=len(x)) * sd
        e = y - np.polyval(np.polyfit(x, y, 1, w=1 / sd), x)
        signs = [np.average(e[x == a], weights=1 / sd[x == a] ** 2) > 0 for a in np.unique(x)]
        counts.append(1 + sum(a != b for a, b in zip(signs[1:], signs[:-1], strict=True)))
    low, high = np.mean(np.array(counts) <= found.value), np.mean(np.array(counts) >= found.value)
    p = min(1, 2 * min(low, high))
    assert abs(found.p_value - p) < 4 * 2 * np.sqrt(p / 2 / 2000 + 1e-6)


def test_runs_of_many_places_take_the_normal_approximation():
    rng = np.random.default_rng(6)
    x, t = np.linspace(-1, 1, 900), rng.normal(size=900)
    fitted = problem(x, t, 1)
    found = runs_test(fitted, rng)
    signs = fitted.e > 0
    mean, sd = wald_wolfowitz(int(signs.sum()), int((~signs).sum()))
    np.testing.assert_allclose(found.p_value, 2 * stats.norm.sf(abs(found.value - mean) / sd))


def test_normality_is_scipys():
    rng = np.random.default_rng(7)
    x = np.linspace(-1, 1, 30)
    fitted = problem(x, rng.standard_t(3, 30), 2)
    w = stats.shapiro(fitted.studentised)
    found = normality(fitted)
    np.testing.assert_allclose((found.value, found.p_value), w, rtol=1e-6)
    x = np.linspace(-1, 1, 6000)
    fitted = problem(x, rng.normal(size=6000), 2)
    jb = stats.jarque_bera(fitted.studentised)
    np.testing.assert_allclose([normality(fitted).value], [jb.statistic], rtol=1e-9)
    np.testing.assert_allclose([normality(fitted).p_value], [jb.pvalue], rtol=1e-9)


@pytest.mark.parametrize("n", [3, 4, 5, 6, 11, 12, 57, 5000])
def test_w_is_scipys(n: int) -> None:
    rng = np.random.default_rng(n)
    for z in (
        rng.normal(size=n),
        rng.standard_t(2, n),
        np.arange(n) // 2 * 1.0,
        1e3 + rng.random(n),
    ):
        # Before 1.18 scipy holds its coefficients in single precision.
        np.testing.assert_allclose(shapiro_wilk(z), stats.shapiro(z), rtol=1e-6, atol=1e-8)


def test_studentised_residuals_have_the_textbook_scale():
    rng = np.random.default_rng(1)
    x, t = np.linspace(-1, 1, 12), rng.normal(size=12)
    fitted = problem(x, t, 2)
    design = np.column_stack(powers(x, 2))
    hat = design @ np.linalg.pinv(design)
    e = t - hat @ t
    scale = np.sqrt(e @ e / 9 * (1 - np.diag(hat)))
    np.testing.assert_allclose(fitted.studentised, e / scale, rtol=1e-9)


def test_simulated_residuals_have_the_covariance_of_residuals():
    q = np.linalg.qr(np.vander(np.linspace(-1, 1, 6), 3))[0]
    null = simulated_residuals(q, np.random.default_rng(0), 40_000)
    np.testing.assert_allclose(np.cov(null.T), np.eye(6) - q @ q.T, atol=5 * np.sqrt(2 / 40_000))
    assert simulated_residuals(np.zeros((1001, 1)), np.random.default_rng(0)) is None


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.6, 0.9]) == [1.0, 1.0]
    assert holm([]) == []


@pytest.mark.parametrize(("sigma", "concern"), [(0.3, True), (0.57, True), (0.6, False)])
def test_whole_pixels_matter_where_sigma_is_near_their_floor(sigma, concern):
    t = np.array([0.0, 3, 5, 9, 11, 16])
    found = whole_pixels(problem(np.arange(6.0), t, 1, sigma=sigma))
    assert found.concern is concern
    assert found.value == pytest.approx(sigma * np.sqrt(12))
    assert whole_pixels(problem(np.arange(6.0), t + 0.5, 1, sigma=sigma)).statistic is None


def test_rounding_has_the_deviation_claimed():
    t = np.random.default_rng(0).uniform(0, 1000, 200_000)
    assert np.std(t - np.round(t)) == pytest.approx(0.2887, abs=4 * 0.2887 / np.sqrt(4e5))


def test_sigma_from_replicates_gives_no_chi_squared_p():
    """Residuals contain the pure error: chi2 / sigma^2 is no chi2 variate."""
    rng = np.random.default_rng(0)
    x = np.repeat(np.linspace(-1, 1, 8), 2)
    data = make_axis(x, np.round(rng.normal(size=16) * 3))
    fit = solve(factorise(data, 1), 1)
    found = Problem.of(data, fit, NoiseLevel.replicates(*pure_error(x, None, data.t)))
    assert chi_squared(found).p_value is None
    assert "sigma of replicates" in whole_pixels(found).meaning


def test_an_inferred_scale_multiplies_the_deviations():
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 1, 30)
    data = make_axis(x, np.round(rng.normal(size=30) * 8), sd=np.full(30, 2.0))
    fit = solve(factorise(data, 1), 1)
    found = Problem.of(data, fit, NoiseLevel.scale())
    assert chi_squared(found).p_value is None
    expected = 2 * fit.sigma_hat * np.sqrt(12)
    assert whole_pixels(found).value == pytest.approx(expected)
