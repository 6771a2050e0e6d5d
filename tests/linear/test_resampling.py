"""Resamples and removals from the reduction of many points.

Truth: the same of the points themselves.
"""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.linear.fewest_nodes import fewest_nodes
from bayescal.linear.least_squares import factorise
from bayescal.linear.resampling import HEAVY, Resampling, without_each
from bayescal.linear.reweighting import Rows
from bayescal.polynomials.axis_data import AxisData, generic_axis

ORDER, N = 2, 5000


def data() -> AxisData:
    rng = np.random.default_rng(2)
    x, e = rng.uniform(-1, 1, N), rng.standard_normal(N)
    e[:4], x[4] = (40, -50, 30, 60), 6.0  # weigh much
    return generic_axis(x, 3 + 2 * x + e, rng.uniform(0.5, 2, N))


def rows_of(axis: AxisData) -> np.ndarray:
    assert axis.sd is not None
    return np.column_stack([axis.design(ORDER), axis.t]) / axis.sd[:, None]


def test_removing_a_point_is_factorising_the_others() -> None:
    axis = data()
    factors, some = factorise(axis, ORDER), np.arange(8)
    assert axis.sd is not None
    ours = without_each(
        factors.reduced(ORDER), factors.monomials, rows_of(axis)[some], np.log(axis.sd[some])
    ).reduced(ORDER)
    for i in some:
        left = np.delete(np.arange(N), i)
        truth = np.linalg.qr(rows_of(axis)[left], mode="r")
        np.testing.assert_allclose(
            np.abs(ours.r[i]), np.abs(truth[:-1, :-1]), rtol=1e-9, atol=1e-9 * np.abs(truth).max()
        )
        assert ours.rss[i] == pytest.approx(truth[-1, -1] ** 2, rel=1e-9)
        assert ours.log_sd[i] == pytest.approx(np.log(axis.sd[left]).sum(), rel=1e-12)
        assert ours.n[i] == N - 1


def test_resamples_vary_as_those_of_the_points() -> None:
    axis, resamples = data(), 1000
    factors = factorise(axis, ORDER)
    assert axis.sd is not None
    rows, log_sd = rows_of(axis), np.log(axis.sd)
    resampling = Resampling(factors.reduced(ORDER), factors.monomials)
    for start in range(0, N, 1300):
        resampling.add(rows[start : start + 1300], log_sd[start : start + 1300])
    q = np.linalg.qr(rows)[0]
    assert 3 <= ((q**2).sum(axis=1) > HEAVY).sum() < N / 2
    ours = resampling.drawn(np.random.default_rng(0), resamples).reduced(ORDER)
    counts = np.random.default_rng(1).multinomial(N, np.full(N, 1 / N), size=resamples)
    truth = Rows.of(axis, ORDER).counted(counts.astype(float)).reduced(ORDER)
    for name in ("rss", "log_sd", "qt"):
        a, b = (np.abs(getattr(one, name)).reshape(resamples, -1) for one in (ours, truth))
        error = np.sqrt(2 / resamples)
        np.testing.assert_allclose((a.mean(0) - b.mean(0)) / b.std(0), 0, atol=5 * error)
        # Kurtosis of the sums is that of a few heavy counts at most.
        np.testing.assert_allclose(a.std(0) / b.std(0), 1, atol=8 * error)


def test_few_nodes_integrate_what_all_do() -> None:
    rng = np.random.default_rng(0)
    at, weights = np.linspace(-1, 1, 3000), rng.dirichlet(np.ones(3000))
    few = fewest_nodes(np.exp(np.linspace(-2, 2, 40)[:, None] * at), weights)
    assert (few >= 0).all()
    assert 3 <= (few > 0).sum() < 25
    for power in (-1.37, 0.0, 0.61, 1.99):  # between those that were asked for
        value = np.exp(power * at)
        assert value @ few == pytest.approx(value @ weights, rel=1e-10)
