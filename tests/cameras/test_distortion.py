"""Radial distortion: the polynomial by hand, and where its inverse ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bayescal.cameras.distortion import distort, invertible_radius, undistort
from bayescal.errors import InputError
from tests.helpers.radial import (
    EPS,
    STEP,
    both,
    coefficients_of,
    coefficients_with_slope,
    on_radii,
    radii_of,
    terms,
)


class TestPolynomial:
    def test_by_hand(self):
        # (0.3, 0.4) is 0.5 from the centre: 1 + 0.2 * 0.5 + 0.4 * 0.25 = 1.2.
        np.testing.assert_allclose(distort([[0.3, 0.4]], [0.2, 0.4]), [[0.36, 0.48]], rtol=4 * EPS)

    def test_even_powers_by_hand(self):
        # 1 + 0.2 * 0.25 + 0.4 * 0.0625 = 1.075
        np.testing.assert_allclose(
            distort([[0.3, 0.4]], [0.2, 0.4], "even"), [[0.3225, 0.43]], rtol=4 * EPS
        )

    def test_even_powers_are_every_other_power(self):
        image = on_radii([0.1, 0.5, 2.0])
        np.testing.assert_allclose(
            distort(image, [0.0, -0.3, 0.0, 0.1]), distort(image, [-0.3, 0.1], "even"), rtol=8 * EPS
        )

    @both
    def test_barrel_draws_in_and_pincushion_pushes_out(self, powers):
        image = on_radii([0.5])
        assert (
            radii_of(distort(image, [-0.1], powers)) < 0.5 < radii_of(distort(image, [0.1], powers))
        )

    @both
    def test_the_centre_stays(self, powers):
        assert distort([[0.0, 0.0]], [-0.3, 0.1], powers).tolist() == [[0.0, 0.0]]
        assert undistort([[0.0, 0.0]], [-0.3, 0.1], powers).tolist() == [[0.0, 0.0]]

    @both
    @pytest.mark.parametrize("k", [[], [0.0], [0.0, 0.0, 0.0]])
    def test_without_coefficients_nothing_moves(self, powers, k):
        image = on_radii([0.0, 1e-300, 0.5, 1e90])
        assert distort(image, k, powers).tolist() == image.tolist()
        assert undistort(image, k, powers).tolist() == image.tolist()
        assert invertible_radius(k, powers) == math.inf


class TestInvertibleRadius:
    @given(st.floats(-1e6, -1e-6))
    def test_of_one_coefficient(self, k):
        # Slope 1 + 2 k w, and 1 + 3 k w^2.
        assert invertible_radius([k]) == pytest.approx(-1 / (2 * k), rel=4 * EPS)
        assert invertible_radius([k], "even") == pytest.approx(1 / math.sqrt(-3 * k), rel=4 * EPS)

    @both
    @pytest.mark.parametrize("k", [[0.2], [0.2, 0.1], [-0.2, 1.0], [0.0, 0.0, 1.0]])
    def test_is_infinite_where_the_slope_stays_positive(self, powers, k):
        assert invertible_radius(k, powers) == math.inf

    def test_of_two_coefficients(self):
        # Slope 1 - 3 w + 2.16 w^2: roots (3 -+ 0.6) / 4.32, of which the smaller counts.
        assert invertible_radius([-1.5, 0.72]) == pytest.approx(5 / 9, rel=16 * EPS)
        # The same in w^2.
        assert invertible_radius([-1.0, 0.432], "even") == pytest.approx(
            math.sqrt(5 / 9), rel=16 * EPS
        )

    def test_of_a_double_root(self):
        # Slope (1 - 1.5 w)^2: it touches zero, to the last digit.
        assert invertible_radius([-1.5, 0.75]) == pytest.approx(2 / 3, rel=1e-7)
        # Slope (1 - w)^2 but for the rounding of 1/3, whose root is 1 -+ 1e-8.
        assert invertible_radius([-1.0, 1 / 3]) == pytest.approx(1, rel=1e-7)
        assert invertible_radius([-2 / 3, 1 / 5], "even") == pytest.approx(1, rel=1e-7)

    def test_a_slope_that_stays_clear_of_zero_is_no_double_root(self):
        assert invertible_radius([-1.5, 0.75 * (1 + 1e-12)]) == math.inf
        assert invertible_radius([-1.5, 0.75 * (1 - 1e-12)]) == pytest.approx(2 / 3, rel=2e-6)

    @both
    @given(
        real=st.lists(st.floats(0.2, 5), min_size=0, max_size=3),
        negative=st.lists(st.floats(-5, -0.2), max_size=2),
        pairs=st.lists(
            st.tuples(st.floats(0.2, 5), st.floats(0.05, math.pi - 0.05)), min_size=0, max_size=2
        ),
    )
    def test_is_the_smallest_positive_root_of_the_slope(self, powers, real, negative, pairs):
        complex_roots = [
            z for r, angle in pairs for z in (r * np.exp(1j * angle), r * np.exp(-1j * angle))
        ]
        k = coefficients_with_slope([*real, *negative, *complex_roots], powers)
        found = invertible_radius(k, powers)
        expected = min(real, default=math.inf) ** (1 / STEP[powers])
        if found == expected == math.inf:
            return
        # Where the slope is zero to rounding, as at a multiple root, it ends early; it
        # never ends late.
        row, factors = terms(k, [found], powers)
        noise = 100 * (len(k) + 1) * EPS * (np.abs(row[0]) @ factors)
        assert abs(row[0] @ factors) <= noise
        assert found <= expected * (1 + 1e-3)
        below, _ = terms(k, np.linspace(0, 0.99 * found, 200), powers)
        assert (below @ factors > 0).all()

    def test_of_high_orders_with_simple_roots(self):
        for powers, expected in (("all", 0.5), ("even", math.sqrt(0.5))):
            pair = [1.2 * np.exp(0.6j), 1.2 * np.exp(-0.6j)]
            k = coefficients_with_slope([0.5, 0.9, -0.7, 2.0, -3.0, 5.0, *pair], powers)
            assert invertible_radius(k, powers) == pytest.approx(expected, rel=1e-12)

    def test_of_coefficients_of_very_different_size(self):
        # Slope 1 + 3 w^2 - 9e-121 w^8, where the terms between are nothing; eigenvalues miss it.
        found = invertible_radius([1.0, -1e-121, -1e-121, -1e-121], "even")
        assert found == pytest.approx((3 / 9e-121) ** (1 / 6), rel=1e-12)

    @both
    @given(k=coefficients_of, exponent=st.integers(-20, 20))
    def test_scales_with_the_unit(self, powers, k, exponent):
        unit = 2.0**exponent
        scaled = k * unit ** -(STEP[powers] * np.arange(1.0, len(k) + 1))
        expected = invertible_radius(k, powers) * unit
        assert invertible_radius(scaled, powers) == pytest.approx(expected, rel=1e-6)

    @both
    @given(k=coefficients_of)
    def test_the_radius_grows_up_to_it_and_not_beyond(self, powers, k):
        limit = invertible_radius(k, powers)
        radii = np.linspace(0, min(limit, 10.0), 501)
        row, _ = terms(k, radii, powers)
        distorted = radii * row.sum(axis=1)
        noise = 16 * (len(k) + 1) * EPS * radii * np.abs(row).sum(axis=1)
        assert (np.diff(distorted) > -noise[1:]).all()
        row, factors = terms(k, [min(limit, 10.0)], powers)
        if limit <= 10:
            assert abs(row[0] @ factors) <= 1e-9 * (np.abs(row[0]) @ factors)

    @both
    def test_the_radius_shrinks_beyond_it(self, powers):
        limit = invertible_radius([-0.3, 0.02], powers)
        beyond = distort(on_radii(limit * np.array([1.0, 1.05, 1.1])), [-0.3, 0.02], powers)
        assert (np.diff(radii_of(beyond)) < 0).all()


class TestInput:
    @pytest.mark.parametrize("function", [distort, undistort])
    def test_refuses_what_it_cant_use(self, function):
        with pytest.raises(InputError, match=r"image must have shape \(n, 2\)"):
            function([[1.0, 2.0, 3.0]], [0.1])
        with pytest.raises(InputError, match="image, point 1: holds a number that is NaN"):
            function([[math.nan, 0.0]], [0.1])
        with pytest.raises(InputError, match="coefficients holds a number that is NaN"):
            function([[0.1, 0.1]], [math.inf])
        with pytest.raises(InputError, match="coefficients must have shape"):
            function([[0.1, 0.1]], [[0.1]])
        with pytest.raises(InputError, match="powers must be all or even, not 'odd'"):
            function([[0.1, 0.1]], [0.1], "odd")

    @pytest.mark.parametrize("function", [distort, undistort])
    def test_takes_no_points(self, function):
        assert function(np.empty((0, 2)), [-0.1]).shape == (0, 2)
        assert function(np.empty((0, 2)), [0.1]).shape == (0, 2)

    def test_refuses_an_image_that_overflows(self):
        with pytest.raises(InputError, match=r"^point 2: its image is above"):
            distort([[1.0, 1.0], [1e99, 0.0]], [1.0, 1.0, -1.0, 1.0])

    def test_refuses_a_radius_beyond_what_doubles_can_search(self):
        with pytest.raises(InputError, match=r"^point 1: its image is above"):
            undistort([[9e99, 0.0]], [-3e-101])

    def test_refuses_coefficients_whose_powers_overflow(self):
        with pytest.raises(InputError, match="coefficients are too large for their number"):
            invertible_radius([1e99, 0.0, 0.0, -1.0])

    @both
    @given(
        k=arrays(float, st.integers(0, 6), elements=st.floats(-1e99, 1e99)),
        fraction=st.floats(0, 1),
    )
    @example(k=np.array([1.0, 5e-324]), fraction=0.5)
    @example(k=np.array([1.0, -1e-121, -1e-121, -1e-121]), fraction=0.5)
    @example(k=np.array([-1e-121, -1e-121, 1.0, -1e-121]), fraction=0.5)
    @example(k=np.array([-1e-320]), fraction=1.0)
    @example(k=np.array([1e-300, -1e-300]), fraction=1.0)
    def test_survives_any_number(self, powers, k, fraction):
        try:
            limit = min(invertible_radius(k, powers), 1e90)
            distorted = distort([[fraction * limit, 0.0]], k, powers)
            back = undistort(distorted, k, powers)
        except InputError:
            return
        assert 0 <= back[0, 0] <= limit * (1 + 4 * EPS)
        np.testing.assert_allclose(distort(back, k, powers), distorted, rtol=1e-9, atol=1e-300)
