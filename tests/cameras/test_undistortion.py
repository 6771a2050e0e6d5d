"""The inverse of radial distortion: round trips, closed forms, what it refuses."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bayescal.cameras.distortion import distort, invertible_radius, undistort
from bayescal.errors import InputError
from tests.helpers.radial import (
    EPS,
    STEP,
    both,
    coefficients_of,
    fractions_of,
    on_radii,
    radii_of,
    terms,
)


class TestInverse:
    @both
    @given(k=coefficients_of, fractions=fractions_of)
    def test_distorting_the_undistorted_gives_it_back(self, powers, k, fractions):
        limit = min(invertible_radius(k, powers), 10.0)
        distorted = distort(on_radii(limit * fractions), k, powers)
        back = distort(undistort(distorted, k, powers), k, powers)
        # 1e-12, but for cancellation among the terms of f.
        row, _ = terms(k, limit * fractions, powers)
        cancelled = np.abs(row).sum(axis=1) / row.sum(axis=1)
        lost = np.maximum(1e-12, 64 * EPS * cancelled) * radii_of(distorted)
        assert (radii_of(back - distorted) <= lost).all()

    @both
    @given(k=coefficients_of, fractions=fractions_of)
    def test_undistorting_the_distorted_gives_it_back(self, powers, k, fractions):
        limit = min(invertible_radius(k, powers), 10.0)
        radii = limit * fractions
        image = on_radii(radii)
        back = undistort(distort(image, k, powers), k, powers)
        # Rounding is amplified by the sizes of f's terms over the slope.
        row, factors = terms(k, radii, powers)
        amplified = np.abs(row).sum(axis=1) / np.maximum(row @ factors, EPS)
        clear = amplified < 50
        error = radii_of(back - image)
        assert (error[clear] <= 1e-12 * radii[clear]).all()

    def test_the_thesis_powers_against_the_quadratic_formula(self):
        k, distorted = -0.4, np.linspace(0.01, 0.6, 60)
        truth = (1 - np.sqrt(1 + 4 * k * distorted)) / (-2 * k)
        np.testing.assert_allclose(radii_of(undistort(on_radii(distorted), [k])), truth, rtol=1e-13)

    def test_even_powers_against_the_trigonometric_solution(self):
        # w - w^3 / 3 = d with d = (2/3) sin(3 a) has the root w = 2 sin(a).
        angle = np.linspace(0.01, 0.5, 50)
        distorted = (2 / 3) * np.sin(3 * angle)
        np.testing.assert_allclose(
            radii_of(undistort(on_radii(distorted), [-1 / 3], "even")),
            2 * np.sin(angle),
            rtol=1e-13,
        )

    @both
    def test_against_forty_digits(self, powers):
        k, distorted = [-0.31, 0.12, -0.05, 0.004], [1e-9, 0.05, 0.3, 0.5]
        with mpmath.workdps(40):
            truth = [
                float(
                    mpmath.findroot(
                        lambda w, d=d: (
                            w
                            * (
                                1
                                + sum(
                                    mpmath.mpf(c) * w ** (STEP[powers] * (j + 1))
                                    for j, c in enumerate(k)
                                )
                            )
                            - d
                        ),
                        d,
                    )
                )
                for d in distorted
            ]
        np.testing.assert_allclose(
            radii_of(undistort(on_radii(distorted), k, powers)), truth, rtol=1e-14
        )

    @both
    @pytest.mark.parametrize("k", [[-0.3], [-0.3, 0.02], [-1.5, 0.75], [0.2, -0.5, 0.1]])
    def test_reaches_the_bound_and_no_further(self, powers, k):
        limit = invertible_radius(k, powers)
        assert limit < math.inf
        edge = distort(on_radii([0.5 * limit, limit]), k, powers)
        # The slope is zero there: the radius is good to the root of rounding (the cube
        # root where the slope only touches zero).
        back = radii_of(undistort(edge, k, powers))
        assert back[1] == pytest.approx(limit, rel=2e-5)
        with pytest.raises(InputError) as caught:
            undistort(edge * [[1.0], [1 + 1e-9]], k, powers)
        assert str(caught.value).startswith("point 2: its distorted radius")
        assert f"(at radius {limit:.9g})" in str(caught.value)

    def test_refuses_even_where_another_branch_has_a_root(self):
        # w - 1.5 w^2 + 0.6 w^3 turns at 0.46, and rises to 1 again far beyond.
        k = [-1.5, 0.6]
        far = distort([[2.5, 0.0]], k)
        assert far[0, 0] == pytest.approx(2.5 * (1 - 3.75 + 3.75))
        with pytest.raises(InputError, match="stops being invertible"):
            undistort(far, k)

    @both
    def test_beyond_the_bound_distort_folds_back(self, powers):
        # Why there is a bound: the inverse of a point beyond it is another point.
        k = [-0.3]
        limit = invertible_radius(k, powers)
        image = on_radii([1.2 * limit])
        back = radii_of(undistort(distort(image, k, powers), k, powers))
        assert back < limit
        np.testing.assert_allclose(
            distort(on_radii(back), k, powers), distort(image, k, powers), rtol=1e-12
        )

    @both
    @given(k=coefficients_of, angle=st.floats(-math.pi, math.pi))
    def test_moves_points_along_their_radius(self, powers, k, angle):
        radius = 0.9 * min(invertible_radius(k, powers), 1.0)
        turned = undistort(distort(on_radii([radius], angle), k, powers), k, powers)
        cross = turned[0] @ [-math.sin(angle), math.cos(angle)]
        assert abs(cross) <= 8 * EPS * radius
        assert turned[0] @ [math.cos(angle), math.sin(angle)] > 0

    @both
    def test_many_points_are_as_one_by_one(self, powers):
        k = [-0.3, 0.1]
        distorted = on_radii(np.linspace(0, 0.5, 40))
        single = [undistort(point[None], k, powers)[0] for point in distorted]
        np.testing.assert_allclose(undistort(distorted, k, powers), single, rtol=8 * EPS)

    @both
    def test_works_in_pixels(self, powers):
        # A barrel of 10 % at 1000 px.
        k = [-1e-4 if powers == "all" else -1e-7]
        image = on_radii([1e-6, 1.0, 500.0, 1000.0])
        back = undistort(distort(image, k, powers), k, powers)
        np.testing.assert_allclose(back, image, rtol=1e-14)
