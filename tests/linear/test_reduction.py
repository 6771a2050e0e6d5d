"""Points reduced chunk by chunk.

Truth: the factorisation of all points at once, exact least squares in rational numbers, and the
identity that changes the basis.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mpf, workdps

from bayescal.arrays import Array
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.reduction import Reduction
from bayescal.polynomials.axis_data import AxisData, generic_axis
from bayescal.polynomials.basis import Domain, basis_change, legendre_design, legendre_rows
from bayescal.polynomials.plane import plane_change, plane_design, plane_rows
from tests.helpers.exact_least_squares import DIGITS, exact_fit, relative_error

ORDER = 5


def made(n: int, sigma: float, seed: int = 0) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.6, 0.7, n)
    return x, 960 + 1500 * x + 10 * x**2 - 60 * x**3 + sigma * rng.normal(size=n)


def reduced(data: AxisData, sizes: int, order: int = ORDER) -> AxisData:
    """The same points as a sample of themselves, reduced in chunks."""
    reduction = Reduction(order)
    for start in range(0, len(data), sizes):
        part = slice(start, start + sizes)
        reduction.add(data.x[part], data.t[part], None if data.sd is None else data.sd[part])
    return data.sampled_from(reduction.whole())


def test_rows_are_the_design_laid_out_by_columns() -> None:
    s = np.linspace(-1, 1, 101)
    np.testing.assert_allclose(legendre_rows(s, 8), legendre_design(s, 8).T, atol=4e-16)


@pytest.mark.parametrize("new", [Domain(-0.6, 0.7), Domain(-3.0, 0.5), Domain(-0.2, 40.0)])
def test_a_change_of_basis_is_one_of_columns(new: Domain) -> None:
    old = Domain(-0.1, 0.3)
    x = np.linspace(old.lower, old.upper, 50)
    before, after = (legendre_design(domain.scale(x), 8) for domain in (old, new))
    change = basis_change(old, new, 8)
    np.testing.assert_allclose(before @ change, after, atol=1e-13)
    assert (np.tril(change, -1) == 0).all()


@pytest.mark.parametrize("sizes", [20_000, 997, 4])
@pytest.mark.parametrize("order_of_points", ["as drawn", "sorted", "a plane first"])
@pytest.mark.parametrize("weighted", [False, True])
def test_chunks_give_the_factorisation_of_all(
    sizes: int, order_of_points: str, weighted: bool
) -> None:
    x, t = made(20_000 if sizes > 4 else 200, 1.0)
    if order_of_points == "sorted":
        x, t = np.sort(x), t[np.argsort(x)]
    if order_of_points == "a plane first":
        x[: len(x) // 10] = x[0]  # nothing but the level is determined by the first chunks
    sd = np.random.default_rng(1).uniform(0.5, 2, len(x)) if weighted else None
    data = generic_axis(x, t, sd)
    at_once, chunks = factorise(data, ORDER), factorise(reduced(data, sizes), ORDER)
    signs = np.sign(np.diag(at_once.r)) * np.sign(np.diag(chunks.r))
    size = np.abs(at_once.r).max()
    np.testing.assert_allclose(chunks.r * signs[:, None], at_once.r, atol=1e-13 * size)
    np.testing.assert_allclose(
        chunks.qt * signs, at_once.qt, atol=1e-13 * np.linalg.norm(at_once.qt)
    )
    for order in range(1, ORDER + 1):
        assert chunks.rss(order) == pytest.approx(at_once.rss(order), rel=1e-11)
    assert (chunks.n, chunks.largest) == (at_once.n, at_once.largest)
    assert chunks.log_sd == pytest.approx(at_once.log_sd, rel=1e-13)


@pytest.mark.parametrize("sizes", [6000, 700])
@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("order_of_points", ["as drawn", "sorted", "a line first"])
def test_chunks_of_two_regressors_give_the_factorisation_of_all(
    sizes: int, weighted: bool, order_of_points: str
) -> None:
    x, t = made(6000, 1.0)
    rng = np.random.default_rng(1)
    other = rng.uniform(-0.3, 0.4, len(x))
    if order_of_points == "sorted":
        x, t = np.sort(x), t[np.argsort(x)]
    if order_of_points == "a line first":
        other[:1000] = other[0]
    t = t + 30 * x * other - 20 * other**2
    sd = rng.uniform(0.5, 2, len(x)) if weighted else None
    data = replace(generic_axis(x, t, sd), other=other)
    reduction = Reduction(4, across=True)
    for start in range(0, len(x), sizes):
        part = slice(start, start + sizes)
        reduction.add(x[part], t[part], None if sd is None else sd[part], other[part])
    sample = data.sampled_from(reduction.whole())
    assert (sample.domain, sample.across) == (data.domain, data.across)
    at_once, chunks = factorise(data, 4), factorise(sample, 4)
    signs = np.sign(np.diag(at_once.r)) * np.sign(np.diag(chunks.r))
    size = np.abs(at_once.r).max()
    np.testing.assert_allclose(chunks.r * signs[:, None], at_once.r, atol=3e-13 * size)
    for order in range(1, 5):
        assert chunks.rss(order) == pytest.approx(at_once.rss(order), rel=1e-10)
    assert (chunks.n, chunks.largest) == (at_once.n, at_once.largest)


def test_a_change_of_two_bases_is_one_of_columns() -> None:
    old = Domain(-0.1, 0.3), Domain(-0.2, 0.2)
    new = Domain(-0.6, 0.7), Domain(-0.2, 4.0)
    x, y = np.random.default_rng(0).uniform(-0.1, 0.2, (2, 80))
    before, after = (plane_design(a.scale(x), b.scale(y), 5) for a, b in (old, new))
    change = plane_change(*(basis_change(a, b, 5) for a, b in zip(old, new, strict=True)), 5)
    np.testing.assert_allclose(before @ change, after, atol=1e-13)
    assert (np.tril(change, -1) == 0).all()
    np.testing.assert_allclose(
        plane_rows(old[0].scale(x), old[1].scale(y), 5), before.T, rtol=0, atol=1e-14
    )


def test_a_lower_order_is_the_leading_part() -> None:
    data = generic_axis(*made(500, 1.0))
    low, high = factorise(data, 2), factorise(reduced(data, 100, 8), 2)
    np.testing.assert_allclose(solve(high, 2).coefficients, solve(low, 2).coefficients, rtol=1e-12)
    assert high.tail == pytest.approx(low.tail, rel=1e-13)


def test_small_noise_keeps_its_digits() -> None:
    """Evidence, (n / 2) d ln rss, against rational arithmetic: to the pixels' own rounding."""
    x, t = made(1000, 1e-3)
    found = factorise(reduced(generic_axis(x, t), 300), 3).rss(3)
    with workdps(DIGITS):
        exact = exact_fit([mpf(v) for v in x], [mpf(v) for v in t], 3).rss
        error = abs(len(x) / 2 * relative_error(found, exact))
    rounding = len(x) * np.finfo(float).eps * np.linalg.norm(t) / np.sqrt(found)
    assert error < rounding < 1e-6


def test_residuals_of_all_at_weighted_coefficients() -> None:
    """The unweighted sum of squares, which the weighted factorisation does not hold."""
    x, t = made(1000, 1.0)
    data = generic_axis(x, t, np.random.default_rng(1).uniform(0.5, 2, 1000))
    fit = solve(factorise(data, 3), 3, 1.0)
    whole = reduced(data, 100).whole
    assert whole is not None
    left = t - data.design(3) @ fit.amplitudes
    assert whole.plain.rss(fit.amplitudes) == pytest.approx(float(left @ left), rel=1e-10)


def test_points_all_alike_are_refused_as_at_once() -> None:
    data = generic_axis(np.full(50, 2.0), np.arange(50.0))
    errors = []
    for one in (data, reduced(data, 7)):
        with pytest.raises(Exception, match="distinct value") as caught:
            factorise(one, 1)
        errors.append(str(caught.value))
    assert errors[0] == errors[1]
