"""The block of adequacy tests: the thesis's data, and input at the edges."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.outcome import concerns
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.replicates import pure_error
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import generic_axis
from bayescal.report.document.defence import adequacy_rows
from tests.helpers.problems import make_axis, thesis_axis


def flat_draws(data, fit, rng, count=4000):
    """Exact draws of the posterior under a flat prior and one over sigma."""
    design = np.vander(data.x, fit.order + 1, increasing=True)
    sigma = np.sqrt(fit.rss / rng.chisquare(fit.dof, count))
    root = np.linalg.cholesky(np.linalg.inv(design.T @ design))
    noise = rng.normal(size=(count, fit.order + 1)) @ root.T
    return np.column_stack([fit.coefficients + sigma[:, None] * noise, sigma])


def thesis_block(axis, order):
    data, other = thesis_axis(axis), thesis_axis("c" if axis == "r" else "r").x
    fit, rng = solve(factorise(data, order), order), np.random.default_rng(1)
    tests = adequacy(
        data,
        fit,
        NoiseLevel.inferred(),
        other,
        bc.thesis().camera_frame()[:, 2],
        None,
        flat_draws(data, fit, rng),
        rng,
    )
    return {test.name: test for test in tests}


def test_thesis_r():
    """Scatter 2.51 px (35 dof), 1.90 after a cross term; planes share 2.6 px."""
    found = thesis_block("r", 4)
    scatter = found["lack of fit, scatter"]
    assert scatter.dof == (17, 35)
    assert scatter.value == pytest.approx(4.8365, abs=1e-3)
    assert "2.51 px (35 dof)" in scatter.meaning
    # Hidden in the misfit of the polynomial, plain among points that share x/z.
    cross = found["other coordinate"].parts[2]
    assert cross.p_value == pytest.approx(0.01926, abs=1e-4)
    assert not found["other coordinate"].concern
    within = found["other coordinate, equal x/z"]
    assert within.concern
    assert within.parts[2].value == pytest.approx(26.95, abs=0.01)
    assert "from 2.51 to 1.90 px" in within.parts[2].meaning
    groups = found["shared errors in groups"]
    assert groups.dof == (8, 44)
    assert groups.value == pytest.approx(4.8587, abs=1e-3)
    assert "correlation 0.44" in groups.meaning
    assert "about 18 independent" in groups.meaning
    assert found["whole-pixel readings"].statistic is not None
    assert not found["whole-pixel readings"].concern
    assert "no replicates" in found["lack of fit, replicates"].meaning


def test_thesis_c():
    found = thesis_block("c", 1)
    assert found["lack of fit, scatter"].dof == (29, 26)
    assert "1.09 px (26 dof)" in found["lack of fit, scatter"].meaning
    assert "point 16" in found["normality"].meaning
    assert found["normality"].concern
    assert found["posterior predictive, largest |z|"].concern
    assert found["shared errors in groups"].value == pytest.approx(3.1543, abs=1e-3)


def test_thesis_has_no_replicates():
    assert pure_error(thesis_axis("r").x, thesis_axis("c").x, thesis_axis("r").t) == (None, 0)


def test_concerns_say_multiplicity_and_what_shared_errors_do():
    lines = concerns(list(thesis_block("r", 4).values()))
    assert all("\n" not in line and not line.endswith(".") for line in lines)
    assert any("after Holm over 7 tests" in line for line in lines)
    assert [line.count("p = ") + line.count("p < ") for line in lines] == [1] * 4 + [0]
    assert lines[-1].startswith("the p-values of the other checks assume independent errors")


def test_no_concern_on_clean_data():
    rng = np.random.default_rng(11)
    x, u = rng.uniform(-0.5, 0.5, (2, 60))
    data = make_axis(x, 900 + 1000 * x + rng.normal(size=60))
    fit = solve(factorise(data, 1), 1)
    depth = rng.choice([300.0, 400, 500], 60)
    draws = flat_draws(data, fit, rng)
    tests = adequacy(data, fit, NoiseLevel.inferred(), u, depth, None, draws, rng)
    assert concerns(tests) == []


def sane(tests):
    """Every number finite or None, every p in [0, 1], words for all, JSON without NaN."""
    json.dumps(adequacy_rows(tests), allow_nan=False)
    for test in tests:
        assert test.meaning
        assert "nan" not in test.meaning
        for part in (test, *test.parts):
            assert part.p_value is None or 0 <= part.p_value <= 1
            assert part.value is None or math.isfinite(part.value)
    assert all(concerns(tests)) or concerns(tests) == []
    return {test.name: test for test in tests}


def block(data, order, noise=None, draws=True, **extra):
    noise = noise or (NoiseLevel.inferred() if data.sd is None else NoiseLevel.known(1.0))
    fit = solve(factorise(data, order), order, noise.value)
    sigma = [[fit.sigma_hat or 1.0]] if noise.value is None else [[]]
    flat = np.column_stack([np.tile(fit.coefficients, (50, 1)), np.tile(sigma, (50, 1))])
    rng = np.random.default_rng(0)
    return sane(adequacy(data, fit, noise, draws=flat if draws else None, rng=rng, **extra))


def extras(n, rng):
    return {
        "other": rng.uniform(-1, 1, n),
        "depth": rng.choice([300.0, 600.0], n),
        "groups": tuple(rng.choice(["a", "b", "c"], n)),
    }


@pytest.mark.parametrize(("n", "order"), [(n, k) for n in range(3, 14) for k in (1, 2, 4) if n > k])
@pytest.mark.parametrize("known", [False, True])
def test_few_points(n, order, known):
    rng = np.random.default_rng(n)
    x = np.sort(rng.uniform(-1, 1, n))
    noise = NoiseLevel.known(0.8) if known else None
    found = block(make_axis(x, rng.normal(size=n)), order, noise, **extras(n, rng))
    if n == order + 1:
        assert all(t.p_value is None for t in found.values())
    if n == order + 2:
        for name in ("normality", "uneven noise"):
            assert found[name].p_value is None


def test_exact_fit():
    x = np.linspace(-1, 1, 20)
    found = block(make_axis(x, 5 + 300 * x), 2, **extras(20, np.random.default_rng(0)))
    assert all(test.p_value is None for test in found.values())
    assert "exact" in found["normality"].meaning
    known = block(make_axis(x, 5 + 300 * x), 2, NoiseLevel.known(1.0))
    assert known["chi2, known sigma"].concern  # nothing measured is that good


def test_zero_readings():
    found = block(make_axis(np.arange(8.0), np.zeros(8)), 1)
    assert all(test.p_value is None for test in found.values())


def test_every_point_copied():
    rng = np.random.default_rng(0)
    x = np.tile(np.linspace(-1, 1, 10), 3)
    found = block(make_axis(x, np.tile(rng.normal(size=10), 3)), 1, other=x * 0 + x**2)
    assert found["lack of fit, replicates"].concern
    assert "copied" in found["lack of fit, replicates"].meaning


@pytest.mark.parametrize("other", [np.full(30, 0.3), np.full(30, 0.0)])
def test_constant_other(other):
    x = np.linspace(-1, 1, 30)
    data = make_axis(x, np.random.default_rng(0).normal(size=30))
    found = block(data, 1, other=other, depth=np.full(30, 300.0))
    assert "same for all" in found["other coordinate"].meaning
    assert "all points share z" in found["shared errors in groups"].meaning


def test_other_that_repeats_the_regressor():
    x = np.linspace(-1, 1, 30)
    found = block(make_axis(x, np.random.default_rng(0).normal(size=30)), 2, other=3 * x + 1)
    assert found["other coordinate"].p_value is None
    assert "can't be told" in found["other coordinate"].meaning


def test_an_effect_of_other_without_noise():
    rng = np.random.default_rng(0)
    x, u = rng.uniform(-1, 1, (2, 30))
    found = block(make_axis(x, x + u), 1, other=u)
    assert found["other coordinate"].p_value == pytest.approx(0, abs=1e-300)
    assert found["other coordinate"].concern


def test_groups_that_err_alike_to_the_last_digit():
    x = np.tile(np.linspace(-1, 1, 5), 4)
    t = np.repeat([0.0, 1, 0, 3], 5)
    found = block(make_axis(x, t), 1, groups=tuple(np.repeat(list("abcd"), 5)))
    groups = found["shared errors in groups"]
    assert (groups.value, groups.p_value, groups.concern) == (None, 0.0, True)


def test_group_for_each_point():
    x = np.arange(9.0)
    data = make_axis(x, np.random.default_rng(0).normal(size=9))
    found = block(data, 1, groups=tuple("abcdefghi"))
    assert "no two points" in found["shared errors in groups"].meaning


def test_weights_scale_as_they_should():
    """Deviations all equal to s: the tests are those of sigma = s, and s = 1 of no weights."""
    rng = np.random.default_rng(2)
    x, t = np.linspace(-1, 1, 25), rng.normal(size=25)
    more = extras(25, rng)
    weighted = block(make_axis(x, t, sd=np.full(25, 0.7)), 2, **more)
    known = block(make_axis(x, t), 2, NoiseLevel.known(0.7), **more)
    for name, test in known.items():
        if test.value is not None:
            assert weighted[name].value == pytest.approx(test.value, rel=1e-7), name


@pytest.mark.parametrize("scale", [1e-30, 1e90])
def test_extreme_units(scale):
    rng = np.random.default_rng(2)
    x, t = np.linspace(-1, 1, 25), rng.normal(size=25)
    more = extras(25, rng)
    base, far = block(make_axis(x, t), 2, **more), block(make_axis(x, t * scale), 2, **more)
    for name, test in base.items():
        if test.p_value is not None:
            assert far[name].p_value == pytest.approx(test.p_value, rel=1e-6), name


def test_regressor_far_off_centre():
    rng = np.random.default_rng(2)
    x = 1e6 + np.linspace(0, 1, 25)
    found = block(make_axis(x, rng.normal(size=25)), 3, **extras(25, rng))
    assert "too many digits" in found["posterior predictive"].meaning


def test_generic_problem():
    rng = np.random.default_rng(2)
    found = block(generic_axis(np.linspace(0, 5, 20), rng.normal(size=20)), 1, draws=False)
    assert "function of x alone" in found["other coordinate"].meaning
    assert "no group" in found["shared errors in groups"].meaning
    assert "no draws" in found["posterior predictive"].meaning


def test_a_hundred_thousand_points():
    rng = np.random.default_rng(0)
    n = 100_000
    x = rng.uniform(-1, 1, n)
    found = block(make_axis(x, rng.normal(size=n)), 4, **extras(n, rng))
    assert found["normality"].statistic == "JB"
    assert sum(test.p_value is not None for test in found.values()) >= 5


def test_order_of_points_does_not_matter():
    rng = np.random.default_rng(5)
    data, other = thesis_axis("r"), thesis_axis("c").x
    depth = bc.thesis().camera_frame()[:, 2]
    shuffle = rng.permutation(57)
    labels = tuple(data.labels[i] for i in shuffle)
    mixed = dataclasses.replace(data, x=data.x[shuffle], t=data.t[shuffle], labels=labels)
    first = block(data, 4, other=other, depth=depth)
    second = block(mixed, 4, other=other[shuffle], depth=depth[shuffle])
    for name, test in first.items():
        if test.value is not None:
            assert second[name].value == pytest.approx(test.value, rel=1e-6), name
