"""A defended comparison from end to end: what it holds, and inputs that would break it.

Warnings are errors throughout. Truths: definitions, refits and closed forms.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import bayescal as bc
from bayescal.linear.closed_form import exact_posterior
from tests.helpers.cases import (
    all_but,
    camera_points,
    not_a_number,
    printed,
    refitted_evidence,
    result_document,
)
from tests.helpers.problems import make_model


@pytest.fixture(scope="module")
def thesis(thesis_defended) -> bc.comparison.results.Comparison:
    """Both axes of the thesis, defended."""
    return thesis_defended


def whole(result) -> str:
    """What is printed, after what every defended comparison must satisfy."""
    text = printed(result)
    assert not_a_number(text) == []
    assert "…" not in text  # no cell is cut off
    assert max(len(line) for line in text.splitlines()) <= 100
    result_document(result)  # refuses NaN
    for axis in result.axes.values():
        for order in axis.orders:
            if order.probability is not None:
                assert 0 <= order.probability <= 1
    return text


def test_tables_are_at_most_100_columns_wide_and_hold_numbers(thesis):
    text = whole(thesis)
    for word in ("elpd", "PSIS", "k max", "by group", "points resampled", "joint, r"):
        assert word in text


def test_best_elpd_less_each_equals_the_differences(thesis):
    """Paired standard errors; the best order's own are zero."""
    for axis in thesis.axes.values():
        found = axis.defence.prediction
        best = max(found, key=lambda k: found[k].loo.elpd)
        for one in found.values():
            d = one.loo.pointwise - found[best].loo.pointwise
            assert one.difference == pytest.approx(d.sum(), abs=1e-9)
            assert one.difference_se == pytest.approx(math.sqrt(57) * d.std(ddof=1), abs=1e-9)
        assert (found[best].difference, found[best].difference_se) == (0, 0)


def test_exact_sum_equals_that_of_the_draws(thesis):
    """PSIS sums within 5 of their standard errors where no point has a bad k."""
    for axis in thesis.axes.values():
        for one in axis.defence.prediction.values():
            assert one.psis.pareto_k.shape == (57,)
            if one.psis.reliable:
                assert abs(one.psis.elpd - one.loo.elpd) < 5 * one.psis.mcse


def test_a_bad_pareto_k_is_said(thesis):
    """Thesis r has points above 0.7, and the print says what that means."""
    worst = max(p.psis.largest_k for p in thesis.axes["r"].defence.prediction.values())
    assert worst > 0.7
    text = " ".join(printed(thesis).split())
    assert "Pareto k above 0.7" in text
    assert f"{worst:.2f}" in text


def test_influential_points_are_named(thesis):
    """Every point of bad Pareto k at the recommended order has its label in print."""
    text = " ".join(printed(thesis).split())
    lists = [
        sorted(found.split(", "))
        for found in re.findall(r"Pareto k above 0.7 at order \d: points? ([\d, ]+);", text)
    ]
    expected = []
    for axis in thesis.axes.values():
        k = axis.defence.prediction[axis.verdict.order].psis.pareto_k
        expected.append(sorted(axis.data.labels[i] for i in np.flatnonzero(k > 0.7)))
    assert any(expected)
    assert lists == [labels for labels in expected if labels]


def test_leave_one_group_out_equals_refitting_without_each_plane(thesis):
    """Sum over the nine planes z of ln p(plane | all other points)."""
    axis = thesis.axes["r"]
    z = thesis.points.world[:, 2]
    assert axis.defence.group_source == "plane z"
    options = (axis.noise, axis.prior)
    for order in (1, 4):
        full = refitted_evidence(axis.data, order, np.arange(57), *options)
        planes = [np.flatnonzero(z == value) for value in np.unique(z)]
        rest = [
            refitted_evidence(axis.data, order, all_but(57, plane), *options) for plane in planes
        ]
        found = axis.defence.prediction[order].group_elpd
        assert found == pytest.approx(sum(full - v for v in rest), abs=1e-6)


def test_worth_equals_the_difference_of_two_posterior_means(thesis):
    """Largest difference over 2001 regressors; the package looks at 401."""
    axis = thesis.axes["c"]
    chosen = axis.verdict.order
    s = np.linspace(-1, 1, 2001)

    def mean(k: int) -> np.ndarray:
        b = exact_posterior(make_model(axis.data, k)).mean
        return np.polynomial.legendre.legval(s, b)

    others = [k for k in axis.verdict.plausible if k != chosen]
    assert [w.order for w in axis.defence.worth] == others
    for worth in axis.defence.worth:
        truth = np.abs(mean(worth.order) - mean(chosen)).max()
        assert worth.largest == pytest.approx(truth, rel=1e-3)


def test_joint_choice_is_of_all_pairs(thesis):
    """25 pairs; independent axes, so the best pair is the pair of the best orders."""
    lines = printed(thesis).split("joint, r")[1].splitlines()
    rows = [line for line in lines if line.strip().startswith(("r order", "r=", ">", "r "))]
    assert len(rows) == 5
    assert all(row.count("%") == 5 for row in rows)


def test_the_same_seed_gives_the_same_defence():
    """And another seed other resamples."""
    points = camera_points(15, noise=3.0)
    one, again, other = (
        bc.compare(points, (1, 2), axis="r", defend=True, ess=100, seed=seed) for seed in (3, 3, 4)
    )
    shares = [r.axes["r"].defence.resampled for r in (one, again, other)]
    assert shares[0] == shares[1]
    assert shares[0] != shares[2]
    assert printed(one) == printed(again)


def defended(points, orders, **options):
    return bc.compare(points, orders, axis="r", defend=True, ess=100, **options)


@pytest.mark.parametrize("prior", ["field", "flat"])
@pytest.mark.parametrize("spare", [0, 1, 2])
def test_few_points_give_statistics_or_words(spare, prior):
    """n = p, p + 1, p + 2 at order 2."""
    result = defended(camera_points(3 + spare), (1, 2), prior=prior)
    whole(result)
    axis = result.axes["r"]
    assert axis[2].goodness.dof == spare
    has_loo = prior == "field" or spare > 0
    assert (2 in axis.defence.prediction) == has_loo
    if spare == 0:
        assert axis[2].goodness.chi2_reduced is None


@pytest.mark.parametrize("spare", [0, 1, 2])
def test_groups_that_hold_most_points_under_a_flat_prior_give_statistics_or_words(spare):
    """Without a group fewer points than coefficients are left: no evidence, so no elpd."""
    n = 3 + spare
    result = defended(camera_points(n, groups=("a",) * 2 + ("b",) * (n - 2)), (1, 2), prior="flat")
    whole(result)
    found = result.axes["r"].defence.prediction.get(2)
    assert found is None or found.group_elpd is None


def test_two_points_of_a_straight_line():
    whole(defended(camera_points(2), (1,)))


@pytest.mark.parametrize(("n", "sigma"), [(3, 1e-5), (5, 1e-5), (20, 0.1), (3, 1e4), (20, 1e9)])
def test_sigma_far_too_small_or_too_large_gives_statistics_or_words(n, sigma):
    """Known sigma from a hundred-thousandth to a billion of px, noise of 1 px."""
    result = defended(camera_points(n), (1, 2), sigma=sigma)
    whole(result)
    axis = result.axes["r"]
    for order in axis.orders:
        assert order.goodness.chi2 == pytest.approx(order.fit.rss / sigma**2, rel=1e-9)


def test_sigma_a_million_times_below_the_residuals_is_refused():
    """chi2 of 1e13 leaves no digit of the likelihood to compare orders by."""
    with pytest.raises(bc.InputError, match="times smaller than the residuals of order 2"):
        defended(camera_points(20), (1, 2), sigma=1e-6)


@pytest.mark.parametrize("sigma", [1e-200, 1e200, 0.0, -1.0, math.nan, math.inf])
def test_sigma_that_is_no_level_is_refused_in_one_line(sigma):
    with pytest.raises(bc.InputError, match="sigma") as error:
        defended(camera_points(8), (1,), sigma=sigma)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("noise", [0.0, 1e-9, 300.0])
def test_noise_at_and_beyond_sigmas_bounds_gives_statistics_or_words(noise):
    result = defended(camera_points(12, noise=noise), (1, 2))
    whole(result)
    if noise < 1e-3:
        assert any("bound" in c for c in result.axes["r"].verdict.caveats)


@pytest.mark.parametrize("width", [None, 1e6, 1e8])
def test_image_sizes_far_from_the_pixels_give_statistics_or_words(width):
    for orders in ((1, 2), (1, 2, 3)):
        whole(defended(camera_points(4, width=width), orders))


@pytest.mark.parametrize("z", [128.0, None])
def test_one_regressor_for_all_points_is_refused(z):
    """x/z is 0.1 throughout: exactly, and up to the rounding of x = 0.1 z."""
    rng = np.random.default_rng(0)
    depth = np.full(12, z) if z is not None else 100.0 + np.arange(12)
    world = np.column_stack([0.1 * depth, rng.uniform(-0.3, 0.3, 12) * depth, depth])
    points = bc.Correspondences.from_arrays(world, rng.uniform(0, 1000, (12, 2)))
    with pytest.raises(bc.InputError, match="x/z") as error:
        defended(points, (1,))
    assert "\n" not in str(error.value)
    assert "no order works" in str(error.value)


def test_planes_a_unit_apart_at_a_million_are_no_groups():
    """Twelve depths, all different: no two points share a plane."""
    points = camera_points(12, depth=1e6 + np.arange(12))
    _, names = points.causes()
    assert len(set(names)) == 12


def test_flat_prior_compares_prediction_alone():
    """No evidence: no verdict, no resamples; leave-one-out stays."""
    result = defended(camera_points(20), (1, 2), prior="flat")
    whole(result)
    axis = result.axes["r"]
    assert axis.verdict.order is None
    assert axis.defence.resampled == ()
    assert axis.defence.beyond is None
    assert set(axis.defence.prediction) == {1, 2}
