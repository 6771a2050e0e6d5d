"""Sets of bad points: sums over them in closed form, and the search for the most probable one.

Truth: all subsets, one by one; points that were moved; integrals with and without points.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import logsumexp

from bayescal.arrays import Array
from bayescal.calibration.judging import bad_points
from bayescal.calibration.judging.bad_points import about, fewest_good, log_prior, search
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.model.error_model import WHITE, ErrorModel
from tests.calibration.judging.test_evidence import settled_problem

VIEWS, N = 4, 54
AREA = math.log(640 * 480)
NONE = np.zeros((VIEWS, N), dtype=bool)


def moved(shifts: dict[tuple[int, int], tuple[float, float]], error: ErrorModel) -> Problem:
    problem = settled_problem(error, VIEWS)
    pixels = problem.data.pixels.copy()
    for at, shift in shifts.items():
        pixels[at] += shift
    return replace(problem, data=replace(problem.data, pixels=pixels))


def marks(*places: tuple[int, int]) -> Array:
    out = NONE.copy()
    for at in places:
        out[at] = True
    return out


@pytest.mark.parametrize(("n", "k"), [(5, 0), (5, 3), (700, 2)])
def test_the_fraction_is_integrated_out(n: int, k: int) -> None:
    """Truth: quadrature over the fraction."""
    found, _ = quad(lambda eps: eps**k * (1 - eps) ** (n - k), 0, 1, epsabs=0, epsrel=1e-10)
    assert log_prior(n, k) == pytest.approx(math.log(found), abs=1e-8)


@pytest.mark.parametrize("certain", [0, 3])
def test_sums_over_points_in_doubt_are_those_over_all_subsets(certain: int) -> None:
    """Truth: 64 subsets one by one."""
    log_ratio, n = np.random.default_rng(0).normal(3, 4, 6), 40
    total, chance, count = bad_points._summed(log_ratio, certain, n)
    subsets = [s for k in range(7) for s in combinations(range(6), k)]
    logs = [log_ratio[list(s)].sum() + log_prior(n, certain + len(s)) for s in subsets]
    assert total == pytest.approx(logsumexp(logs), abs=1e-10)
    share = np.exp(np.array(logs) - total)
    expected = [sum(p for s, p in zip(subsets, share, strict=True) if i in s) for i in range(6)]
    assert chance == pytest.approx(np.array(expected), abs=1e-10)
    assert count == pytest.approx(certain + sum(expected))


def test_no_points_in_doubt_leave_one_set() -> None:
    total, chance, count = bad_points._summed(np.zeros(0), 2, 10)
    assert (total, len(chance), count) == (float(log_prior(10, 2)), 0, 2)


@pytest.mark.parametrize("error", [WHITE, ErrorModel(0.5, 0.2)])
def test_moved_points_are_found_and_far_ones_are_certain(error: ErrorModel) -> None:
    """Truth: the points that were moved, by 2 px (ten deviations) and more; noise is 0.2 px."""
    shifts = {(0, 3): (30.0, -5.0), (0, 9): (-1.5, 1.5), (2, 30): (6.0, 8.0), (3, 53): (0, 4.0)}
    problem = moved(shifts, error)
    found = search(problem, NONE, 10)
    assert (found == marks(*shifts)).all()
    sets = about(problem, found)
    assert sets.log_share == pytest.approx(log_prior(VIEWS * N, 4) - 4 * AREA, abs=1e-2)
    assert (sets.likely == found).all()
    assert sets.chance[found].min() > 0.99
    assert sets.fraction == pytest.approx((1 + 4) / (VIEWS * N + 2), rel=1e-2)
    for at, shift in shifts.items():
        assert sets.shift[at] == pytest.approx(np.array(shift), abs=5 * 0.2 * 1.5)


def test_points_wrongly_begun_with_are_taken_back() -> None:
    problem = moved({(2, 30): (6.0, 8.0)}, WHITE)
    found = search(problem, marks((0, 0), (1, 7), (2, 31)), 10)
    assert (found == marks((2, 30))).all()


def test_points_that_hide_each_other_are_found_together() -> None:
    """Truth: a tenth of the points moved alike, of which none stands out alone."""
    rng = np.random.default_rng(2)
    places = [(int(k) // N, int(k) % N) for k in rng.choice(VIEWS * N, 22, replace=False)]
    angles = rng.uniform(0, 2 * np.pi, 22)
    shifts = {at: (4 * math.cos(a), 4 * math.sin(a)) for at, a in zip(places, angles, strict=True)}
    problem = moved(shifts, WHITE)
    assert not search(problem, NONE, 1).any()  # negative control
    assert (search(problem, NONE, 22) == marks(*shifts)).all()


def test_a_point_in_doubt_is_summed_over() -> None:
    """Truth: about the set with it and about the set without it the sum is the same.

    Of all points' density: an evidence without the point differs by what the others predict of it.
    """
    at, problem = (1, 20), moved({}, WHITE)
    shift = bad_points._released(problem, np.zeros((0, 2), dtype=np.intp)).shift(*at)
    for size in (1.0, 1.2, 1.4):
        off = moved({at: (size - shift[0], -shift[1])}, WHITE)
        free = bad_points._released(off, np.zeros((0, 2), dtype=np.intp))
        predicted = float(free.log_density()[at])
        good, bad = about(off, NONE), about(off, marks(at))
        assert good.log_share == pytest.approx(bad.log_share - predicted, abs=1e-3)
        assert good.chance[at] == pytest.approx(bad.chance[at], abs=1e-3)
        odds = -AREA - predicted - math.log(VIEWS * N)
        assert good.chance[at] == pytest.approx(1 / (1 + math.exp(-odds)), abs=1e-3)


def test_a_view_keeps_half_of_its_points_and_four() -> None:
    """Truth: a view of which all points are anywhere."""
    assert [fewest_good(n) for n in (4, 5, 8, 9, 54)] == [4, 4, 4, 5, 27]
    rng = np.random.default_rng(3)
    problem = moved({(1, k): tuple(rng.uniform(-40, 40, 2)) for k in range(N)}, WHITE)
    found = search(problem, NONE, N)
    assert found[1].sum() == N - fewest_good(N)
    assert not np.delete(found, 1, axis=0).any()
    sets = about(problem, found)
    assert (sets.chance[1] > 0).sum() == N - fewest_good(N)
