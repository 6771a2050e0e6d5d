"""One contract that every lens keeps.

Truths: the projections of OpenCV and COLMAP, the rays that the models' authors give in closed
form, central differences, a search over angles for where a lens turns back, and identities
(undistort undoes distort, many cameras at once are the same as one by one).
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bayescal.cameras.lenses import lens_named
from bayescal.cameras.lenses.axial import Axial
from bayescal.errors import InputError
from tests.helpers.lenses import RNG, every


@every
def test_each_coefficient_has_a_name_a_group_a_power_a_start_and_bounds(case):
    lens, count = case.lens, len(case.k)
    for listed in (lens.names, lens.groups, lens.powers, lens.start, lens.bounds):
        assert len(listed) == count
    assert len(set(lens.names)) == count
    assert all(low <= at <= high for (low, high), at in zip(lens.bounds, lens.start, strict=True))


@every
def test_displacements_grow_with_the_stated_power_near_the_axis(case):
    small = np.array([[3e-2, 4e-2, 1.0], [1.5e-2, 2e-2, 1.0]])
    slopes = case.lens.jacobian(small, np.array(case.lens.start)).by_coefficient
    size = np.linalg.norm(slopes, axis=1)
    # The next term of each series is smaller by the square of the radius, 0.0025.
    np.testing.assert_allclose(np.log2(size[0] / size[1]), case.lens.powers, atol=0.02)


@every
def test_jacobian_is_that_of_central_differences(case):
    rays = case.rays()
    found = case.lens.jacobian(rays, case.k)
    np.testing.assert_allclose(found.plane, case.lens.distort(rays, case.k), rtol=0, atol=1e-14)
    h = 1e-5  # third derivatives of order 10 leave 1e-9, rounding 1e-11
    for j in range(3):
        step = h * np.eye(3)[j]
        up, down = (case.lens.distort(rays + s * step, case.k) for s in (1, -1))
        truth = (up - down) / (2 * h)
        allowed = {"rtol": 1e-7, "atol": 1e-7}
        # Odd powers have a kink on the axis, the first ray.
        rest = slice("step=1" in repr(case.lens), None)
        np.testing.assert_allclose(found.by_ray[rest, :, j], truth[rest], **allowed)
    for j in range(len(case.k)):
        step = h * np.eye(len(case.k))[j]
        up, down = (case.lens.distort(rays, case.k + s * step) for s in (1, -1))
        truth = (up - down) / (2 * h)
        np.testing.assert_allclose(found.by_coefficient[..., j], truth, rtol=1e-7, atol=1e-9)


@every
def test_undistort_undoes_distort(case):
    rays = case.rays()
    assert case.lens.seen(rays, case.k).all()
    plane = case.lens.distort(rays, case.k)
    back = case.lens.undistort(plane, case.k)
    assert back.found.all()
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    np.testing.assert_allclose(back.rays, unit, atol=1e-12)
    np.testing.assert_allclose(case.lens.distort(back.rays, case.k), plane, rtol=1e-13, atol=1e-13)


@every
def test_many_cameras_at_once_are_those_one_by_one(case):
    rays = np.stack([case.rays(seed=s) for s in range(6)]).reshape(2, 3, 200, 3)
    k = case.k * RNG(1).uniform(0.9, 1.1, (2, 3, len(case.k)))
    lens = case.lens
    together = lens.jacobian(rays, k)
    plane = lens.distort(rays, k)
    back, seen, limit = lens.undistort(plane, k), lens.seen(rays, k), lens.limit(k)
    assert limit.shape == (2, 3)
    for at in np.ndindex(2, 3):
        one = lens.jacobian(rays[at], k[at])
        for part in ("plane", "by_ray", "by_coefficient"):
            np.testing.assert_allclose(getattr(together, part)[at], getattr(one, part), rtol=1e-13)
        np.testing.assert_allclose(back.rays[at], lens.undistort(plane[at], k[at]).rays, atol=1e-13)
        np.testing.assert_array_equal(seen[at], lens.seen(rays[at], k[at]))
        np.testing.assert_allclose(limit[at], lens.limit(k[at]), rtol=1e-12)


@every
def test_the_radius_grows_up_to_the_limit_and_no_further(case):
    lens, k = case.lens, case.k * np.array([name[0] not in "ps" for name in case.lens.names])
    limit = float(lens.limit(k))
    assert limit >= case.angle
    theta = np.linspace(0, limit, 4002)[1:-1]

    def radius(angle):
        rays = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
        return lens.distort(rays, k)[:, 0]

    assert (np.diff(radius(theta)) > 0).all()
    whole = np.pi if isinstance(lens, Axial) else np.pi / 2
    if limit < whole - 1e-9:
        before, beyond = radius(np.array([limit - 1e-4, limit + 1e-4]))
        # It turns back, by the square of the step, or starts again behind a pole.
        assert not beyond > before + 1e-7


def test_limits_are_those_of_the_closed_forms():
    for name, options, k, truth in (
        ("radial", {"order": 1, "tangential": False}, [-1 / 3], np.pi / 4),
        ("radial", {"order": 1, "tangential": False}, [0.1], np.pi / 2),
        ("radial", {"order": 1, "tangential": False, "step": 1}, [-0.25], np.arctan(2)),
        ("radial", {"order": 2, "tangential": False}, [-2 / 3, 0.2], np.pi / 4),  # only levels off
        ("rational", {"order": 1, "tangential": False}, [0, 0, 0, -0.25], np.arctan(2)),  # a pole
        ("fisheye", {"order": 1}, [-1 / 12], 2.0),
        ("fisheye", {"order": 1}, [0.1], np.pi),
        ("division", {}, [0.25], np.pi / 4),
        ("division", {}, [-0.25], np.pi),
        ("eucm", {}, [0.0, 1.0], np.pi / 2),
        ("eucm", {}, [0.5, 1.0], np.pi),
        ("double-sphere", {}, [0.0, 0.0], np.pi / 2),
        ("double-sphere", {}, [0.0, 0.5], np.pi),
    ):
        found = lens_named(name, **options).limit(np.array(k))
        # A double root of the slope is found to the root of rounding.
        assert found == pytest.approx(truth, abs=1e-7), (name, k)


@given(k=arrays(float, 6, elements=st.integers(-100, 100).map(lambda n: n / 50)))
def test_a_rational_lens_grows_up_to_its_limit_whatever_its_coefficients(k):
    lens = lens_named("rational", tangential=False)
    w = np.tan(np.linspace(0, float(lens.limit(k)), 500)[1:-1])
    rays = np.column_stack([w, np.zeros_like(w), np.ones_like(w)])
    plane = lens.distort(rays, k)
    assert (np.diff(plane[:, 0]) >= -1e-9 * np.abs(plane[1:, 0])).all()
    back = lens.undistort(plane, k)
    again = lens.distort(back.rays[back.found], k)
    np.testing.assert_allclose(again, plane[back.found], rtol=1e-13, atol=1e-13)
    # Where the slope has all but vanished rounding can put the root on either side of the limit;
    # near a pole the rounding of the ray itself, times the slope, exceeds what counts as found.
    slope = lens.jacobian(rays, k).by_ray[:, 0, 0]
    assert back.found[(slope > 1e-6) & (w * (slope + 1) < 30)].all()


@every
def test_nothing_is_claimed_beyond_the_limit(case):
    """No ray beyond it is seen, and none is given for a pixel that only such rays reach."""
    lens, k = case.lens, case.k * np.array([name[0] not in "ps" for name in case.lens.names])
    limit = float(lens.limit(k))
    angle = np.linspace(min(limit + 1e-6, np.pi), np.pi, 50)
    rays = np.column_stack([np.abs(np.sin(angle)), np.zeros(50), np.cos(angle)])
    assert not lens.seen(rays, k).any()
    assert not lens.seen(np.array([[0, 0, -1.0], [np.nan, 0, 1]]), k).any()
    at = np.array([0.95 * limit, limit * (1 - 1e-9)])
    inside, edge = lens.distort(np.column_stack([np.sin(at), 0 * at, np.cos(at)]), k)[:, 0]
    radii = np.array([inside, np.inf, np.nan, 1.001 * edge, 10 * edge])
    back = lens.undistort(np.column_stack([radii, np.zeros(5)]), k)
    assert back.found[0]
    assert not back.found[1:3].any()
    if edge < 1e3:  # else the image has no end, but for the one that rounding makes
        assert not back.found[3:].any()
    assert np.isnan(back.rays[~back.found]).all()
    assert lens.seen(back.rays[back.found], k).all()


def test_without_coefficients_a_lens_serves_however_far_out_a_point_is():
    """The square of the radius overflows."""
    lens, rays = lens_named("radial", order=0, tangential=False), np.array([[3e168, 0, 1.5]])
    found = lens.jacobian(rays, np.zeros(0))
    assert found.plane.tolist() == [[2e168, 0]]
    truth = [[[1 / 1.5, 0, -2e168 / 1.5], [0, 1 / 1.5, 0]]]
    np.testing.assert_allclose(found.by_ray, truth, rtol=1e-15)
    assert lens.distort(rays, np.zeros(0)).tolist() == [[2e168, 0]]


def test_shapes_out_of_bounds_see_nothing():
    for name, k in (("eucm", [1.2, 1.0]), ("eucm", [0.5, -1.0]), ("double-sphere", [0.0, -0.1])):
        assert not lens_named(name).seen(np.array([[0.1, 0, 1]]), np.array(k)).any(), name


def test_unknown_lenses_options_and_orders_are_named():
    for name, options, words in (
        ("fisheye", {"order": 6}, "order 6 of lens fisheye: use 0 to 5"),
        ("rational", {"order": 0}, "order 0 of lens rational: use 1 to 3"),
        ("thin-prism", {"order": 2, "rational": True}, "order 2 of lens thin-prism: use 3"),
        ("barrel", {}, "no lens is called barrel: use one of radial, "),
        ("radial", {"orders": 2}, "has no option orders: it has order, tangential"),
        ("opencv4", {"order": 3}, "has no option order: it has none"),
        ("radial", {"order": 7}, "order 7 of lens radial: use 0 to 6"),
    ):
        with pytest.raises(InputError, match=words):
            lens_named(name, **options)
