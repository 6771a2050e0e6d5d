"""The radial lens's fold and inverse, in even powers and in the thesis's: closed forms, 40 digits.

Slope of w f(w): 1 + 2 k_1 w + ... in all powers, 1 + 3 k_1 w^2 + ... in even ones.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bayescal.cameras.lenses import lens_named
from tests.helpers.chapter_three import STEP
from tests.helpers.radial import (
    EPS,
    both,
    coefficients_of,
    coefficients_with_slope,
    fractions_of,
    terms,
)


def lens_of(k, powers):
    return lens_named("radial", order=len(k), tangential=False, step=STEP[powers])


def fold(k, powers="all"):
    """Radius of the undistorted plane at which the lens folds; infinite where it does not."""
    angle = float(lens_of(k, powers).limit(np.array(k, dtype=float)))
    return math.inf if angle == math.pi / 2 else math.tan(angle)


def distort(radii, k, powers="all"):
    rays = np.column_stack([radii, np.zeros(len(radii)), np.ones(len(radii))])
    return lens_of(k, powers).distort(rays, np.array(k, dtype=float))[:, 0]


def undistort(radii, k, powers="all", angle=0.7):
    """Radii of the undistorted plane; nan where none is found."""
    plane = np.asarray(radii)[:, None] * [math.cos(angle), math.sin(angle)]
    rays = lens_of(k, powers).undistort(plane, np.array(k, dtype=float)).rays
    along = rays[:, 0] * math.cos(angle) + rays[:, 1] * math.sin(angle)
    return along / rays[:, 2]


@given(st.floats(-1e6, -1e-6))
def test_fold_of_one_coefficient(k):
    # The angle rounds at eps, its tangent at (1 + w^2) / w times that.
    for powers, truth in (("all", -1 / (2 * k)), ("even", 1 / math.sqrt(-3 * k))):
        assert fold([k], powers) == pytest.approx(truth, rel=8 * EPS * (truth + 1 / truth))


@both
@pytest.mark.parametrize("k", [[0.2], [0.2, 0.1], [-0.2, 1.0], [0.0, 0.0, 1.0], []])
def test_no_fold_where_the_slope_stays_positive(powers, k):
    assert fold(k, powers) == math.inf


def test_fold_of_two_coefficients():
    # Slope 1 - 3 w + 2.16 w^2: roots (3 -+ 0.6) / 4.32, of which the smaller counts; then in w^2.
    assert fold([-1.5, 0.72]) == pytest.approx(5 / 9, rel=16 * EPS)
    assert fold([-1.0, 0.432], "even") == pytest.approx(math.sqrt(5 / 9), rel=16 * EPS)


def test_a_slope_that_touches_zero_ends_the_inverse():
    # Slope (1 - 1.5 w)^2 to the last digit; (1 - w)^2 but for the rounding of 1/3 and of 1/5.
    assert fold([-1.5, 0.75]) == pytest.approx(2 / 3, rel=1e-7)
    assert fold([-1.0, 1 / 3]) == pytest.approx(1, rel=1e-7)
    assert fold([-2 / 3, 1 / 5], "even") == pytest.approx(1, rel=1e-7)
    # One that stays clear of zero does not, and one that crosses it closely does.
    assert fold([-1.5, 0.75 * (1 + 1e-12)]) == math.inf
    assert fold([-1.5, 0.75 * (1 - 1e-12)]) == pytest.approx(2 / 3, rel=2e-6)


def test_fold_of_high_order_with_simple_roots():
    pair = [1.2 * np.exp(0.6j), 1.2 * np.exp(-0.6j)]
    k = coefficients_with_slope([0.5, 0.9, -3.0, 5.0, *pair], "even")
    assert fold(k, "even") == pytest.approx(math.sqrt(0.5), rel=1e-12)


@both
@given(
    real=st.lists(st.floats(0.2, 5), max_size=2),
    negative=st.lists(st.floats(-5, -0.2), max_size=2),
    pairs=st.lists(st.tuples(st.floats(0.2, 5), st.floats(0.05, math.pi - 0.05)), max_size=1),
)
def test_the_fold_is_the_smallest_positive_root_of_the_slope(powers, real, negative, pairs):
    complex_roots = [z for r, t in pairs for z in (r * np.exp(1j * t), r * np.exp(-1j * t))]
    k = coefficients_with_slope([*real, *negative, *complex_roots], powers)
    found = fold(k, powers)
    expected = min(real, default=math.inf) ** (1 / STEP[powers])
    if found == expected == math.inf:
        return
    # Where the slope is zero to rounding, as at a multiple root, it ends early; it never ends late.
    row, factors = terms(k, [found], powers)
    noise = 200 * (len(k) + 1) * EPS * (np.abs(row[0]) @ factors)
    assert abs(row[0] @ factors) <= noise
    assert found <= expected * (1 + 1e-3)
    below, _ = terms(k, np.linspace(0, 0.99 * found, 200), powers)
    assert (below @ factors > 0).all()


@both
@given(k=coefficients_of)
def test_the_radius_grows_up_to_the_fold(powers, k):
    radii = np.linspace(0, min(fold(k, powers), 10.0), 501)
    row, _ = terms(k, radii, powers)
    noise = 16 * (len(k) + 1) * EPS * radii * np.abs(row).sum(axis=1)
    assert (np.diff(radii * row.sum(axis=1)) > -noise[1:]).all()


@both
@given(k=coefficients_of, fractions=fractions_of)
def test_undistorting_the_distorted_gives_it_back(powers, k, fractions):
    radii = min(fold(k, powers), 10.0) * fractions
    back = undistort(distort(radii, k, powers), k, powers)
    # Rounding is amplified by the sizes of f's terms over the slope.
    row, factors = terms(k, radii, powers)
    clear = np.abs(row).sum(axis=1) / np.maximum(row @ factors, EPS) < 50
    error = np.abs(back - radii)
    assert (error[clear] <= 1e-12 * np.maximum(radii, radii**3)[clear] + 1e-300).all()


def test_the_thesis_powers_against_the_quadratic_formula():
    k, distorted = -0.4, np.linspace(0.01, 0.6, 60)
    truth = (1 - np.sqrt(1 + 4 * k * distorted)) / (-2 * k)
    np.testing.assert_allclose(undistort(distorted, [k]), truth, rtol=1e-13)


def test_even_powers_against_the_trigonometric_solution():
    # w - w^3 / 3 = d with d = (2/3) sin(3 a) has the root w = 2 sin(a).
    angle = np.linspace(0.01, 0.5, 50)
    found = undistort((2 / 3) * np.sin(3 * angle), [-1 / 3], "even")
    np.testing.assert_allclose(found, 2 * np.sin(angle), rtol=1e-12)


@both
def test_against_forty_digits(powers):
    k, distorted = [-0.31, 0.12, -0.05, 0.004], [1e-9, 0.05, 0.3, 0.5]

    def image(w):
        return w * (1 + sum(mpmath.mpf(c) * w ** (STEP[powers] * (j + 1)) for j, c in enumerate(k)))

    with mpmath.workdps(40):
        truth = [float(mpmath.findroot(lambda w, d=d: image(w) - d, d)) for d in distorted]
    np.testing.assert_allclose(undistort(distorted, k, powers), truth, rtol=1e-14)


@both
@pytest.mark.parametrize("k", [[-0.3], [-0.3, 0.02], [-1.5, 0.75], [0.2, -0.5, 0.1]])
def test_reaches_the_fold_and_no_further(powers, k):
    limit = fold(k, powers)
    assert limit < math.inf
    edge = distort(np.array([limit]), k, powers)[0]
    found = undistort([edge * (1 - 1e-12), edge * (1 + 1e-9)], k, powers)
    # The slope is zero there: the radius is good to the root of rounding (the cube root where the
    # slope only touches zero).
    assert found[0] == pytest.approx(limit, rel=2e-4)
    assert math.isnan(found[1])


def test_finds_nothing_where_only_another_branch_has_a_root():
    # w - 1.5 w^2 + 0.6 w^3 turns at 0.46, and rises to 1 again far beyond.
    k = [-1.5, 0.6]
    far = distort(np.array([2.5]), k)
    assert far[0] == pytest.approx(2.5 * (1 - 3.75 + 3.75))
    assert np.isnan(undistort(far, k)).all()


@both
@given(k=arrays(float, st.integers(0, 6), elements=st.floats(-1e99, 1e99)), angle=st.floats(0, 1))
@example(k=np.array([1.0, 5e-324]), angle=0.5)
@example(k=np.array([1.0, -1e-121, -1e-121, -1e-121]), angle=0.5)
@example(k=np.array([-1e-320]), angle=1.0)
@example(k=np.array([1e99, 0.0, 0.0, -1.0]), angle=1.0)
def test_survives_any_number(powers, k, angle):
    lens = lens_of(k, powers)
    limit = float(lens.limit(k))
    assert 0 <= limit <= math.pi / 2
    at = angle * limit
    plane = lens.distort(np.array([[math.sin(at), 0, math.cos(at)]]), k)
    back = lens.undistort(plane, k)
    if back.found[0]:
        assert lens.seen(back.rays, k)[0]
        np.testing.assert_allclose(lens.distort(back.rays, k), plane, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("k", [[np.nan, 0.1], [np.inf, -0.1]])
def test_coefficients_that_are_no_numbers_see_nothing(k):
    lens, k = lens_of(k, "even"), np.array(k)
    assert lens.limit(k) == 0
    assert not lens.seen(np.array([[0, 0.1, 1.0]]), k).any()
    assert not lens.undistort(np.array([[0.1, 0.1]]), k).found.any()
