"""Counted and left-out points against a factorisation of those very points.

The truth is the QR of the actual rows, repeated or removed, in Bonnet's basis on the
domain of all points. R'R, R'Q't and the residual sum of squares don't depend on signs;
the condition number of these Gram matrices is below 1e3, so that 1e-11 of their size
leaves room for rounding.
"""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.linear.reweighting import Rows
from bayescal.noise.level import NoiseLevel
from tests.helpers.cases import all_but, curve, refit
from tests.helpers.problems import (
    AXES,
    ORDERS,
    field_rule,
    legendre_columns,
    make_axis,
    thesis_axis,
)

LEVEL = NoiseLevel.known(1.0)
CLOSE = 1e-11


def check(data, order: int, sets, rows) -> None:
    """Every invariant of each reduced set equals that of its rows."""
    found = sets.reduced(order)
    t_size = float(np.abs(data.t).max() / (1 if data.sd is None else data.sd.min()))
    for i, members in enumerate(rows):
        truth = refit(data, order, members, LEVEL, field_rule(data)).reduced
        r, qt = found.r[i], found.qt[i]
        scale = max(float(np.abs(truth.r).max()), 1e-300) ** 2
        np.testing.assert_allclose(r.T @ r, truth.r.T @ truth.r, rtol=0, atol=CLOSE * scale)
        length = np.sqrt(scale * max(len(members), 1)) * t_size
        np.testing.assert_allclose(r.T @ qt, truth.r.T @ truth.qt, rtol=0, atol=CLOSE * length)
        # rss: the square of norms good to some eps of |t| sqrt(n).
        floor = 1e-13 * t_size * np.sqrt(len(members) + 1)
        assert np.sqrt(found.rss[i]) == pytest.approx(np.sqrt(truth.rss), rel=CLOSE, abs=floor)
        assert found.n[i] == len(members)
        assert found.log_sd[i] == pytest.approx(float(truth.log_sd), abs=1e-12 * len(data))


def counts_and_rows(n: int, sets: int, seed: int = 6):
    """Bootstrap counts and the indices they stand for."""
    counts = np.random.default_rng(seed).multinomial(n, np.full(n, 1 / n), size=sets)
    return counts.astype(float), [np.repeat(np.arange(n), row) for row in counts]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("axis", AXES)
def test_factorising_the_rest_equals_leaving_points_out(axis, order):
    """One point, ten, a whole end of the domain: the domain stays that of all points."""
    data = thesis_axis(axis)
    n = len(data)
    ends = np.argsort(data.x)
    outs = [[i] for i in range(0, n, 7)] + [list(range(10)), ends[:12].tolist(), []]
    members = np.array([np.isin(np.arange(n), out) for out in outs], dtype=float)
    check(data, order, Rows.of(data, 5).without(members), [all_but(n, out) for out in outs])


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("axis", AXES)
def test_factorising_duplicates_equals_counting(axis, order):
    data = thesis_axis(axis)
    counts, rows = counts_and_rows(len(data), 20)
    check(data, order, Rows.of(data, 5).counted(counts), rows)


@pytest.mark.parametrize("order", [1, 3])
def test_factorising_weighted_duplicates_equals_counting_with_deviations(order):
    """sd from 0.1 to 10 px: weights over four decades."""
    sd = 10 ** np.random.default_rng(2).uniform(-1, 1, 30)
    data = curve(30, [480, 300, 5], 1.3, sd=sd)
    counts, rows = counts_and_rows(30, 20)
    check(data, order, Rows.of(data, 3).counted(counts), rows)


@pytest.mark.parametrize("n", [4, 5, 6])
def test_factorising_few_points_equals_counting_them(n):
    """n = p, p + 1, p + 2 points at order 3, and fewer distinct ones than coefficients."""
    data = curve(n, [480, 300, 5, 1], 1.3)
    counts, rows = counts_and_rows(n, 30)
    assert min((c > 0).sum() for c in counts) < 4
    check(data, 3, Rows.of(data, 3).counted(counts), rows)


def test_an_exact_fit_keeps_its_residuals_at_rounding():
    """A straight line counted often: residuals stay below 1e-12 of the pixels."""
    s = np.linspace(-1, 1, 40)
    data = make_axis(s, 500 + 300 * s)
    counts, _ = counts_and_rows(40, 30)
    found = Rows.of(data, 4).counted(counts).reduced(2)
    assert np.sqrt(found.rss.max()) < 1e-12 * 800 * np.sqrt(40)


def test_a_small_residual_beside_large_pixels_is_kept():
    """Noise of 1e-6 px on 1e3 px: rss to six digits, where normal equations lose all."""
    data = curve(40, [480, 300, 5], 1e-6)
    counts, rows = counts_and_rows(40, 10)
    found = Rows.of(data, 2).counted(counts).reduced(2)
    for i, members in enumerate(rows):
        truth = refit(data, 2, members, LEVEL, field_rule(data)).reduced
        assert np.sqrt(found.rss[i]) == pytest.approx(np.sqrt(truth.rss), rel=1e-6)


def test_a_domain_of_the_rest_alone_would_show():
    """Negative control: without the last point the domain, hence the basis, would change."""
    data = curve(12, [480, 300, 5], 1.0)
    part = make_axis(data.x[:-1], data.t[:-1])
    own = legendre_columns(part, 2)
    full = legendre_columns(data, 2)[:-1]
    assert np.abs(own.T @ own - full.T @ full).max() > 0.1
    found = Rows.of(data, 2).without(np.eye(12)[-1:]).reduced(2).r[0]
    np.testing.assert_allclose(found.T @ found, full.T @ full, atol=1e-12)
