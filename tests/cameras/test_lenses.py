"""One contract that every lens keeps.

Truths: OpenCV's projection, central differences, and identities (undistort undoes distort, many
cameras at once are the same as one by one).
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bayescal.cameras.lenses import lens_named
from bayescal.errors import InputError

RNG = np.random.default_rng


class Case:
    """A lens with coefficients that a real one could have, and rays that it sees."""

    def __init__(self, name, k, angle=45.0, **options):
        self.lens = lens_named(name, **options)
        self.k = np.array(k, dtype=float)
        self.label = f"{name}-{len(k)}"
        self.angle = np.radians(angle)

    def rays(self, n=200, seed=0):
        rng = RNG(seed)
        theta = self.angle * np.sqrt(rng.uniform(0, 1, n))
        phi = rng.uniform(-np.pi, np.pi, n)
        theta[0] = 0  # the axis itself
        sine = np.sin(theta)
        rays = np.column_stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)])
        return rays * rng.uniform(0.5, 3, (n, 1))


BARREL = [-0.28, 0.12, 8e-4, -5e-4, -0.02]
CASES = [
    Case("radial", [], order=0, tangential=False),
    Case("radial", [8e-4, -5e-4], order=0, tangential=True),
    Case("radial", [-0.1], order=1, tangential=False),
    Case("radial", [-0.2, 0.3], order=2, tangential=False, step=1),
    Case("radial", [-0.28, 0.12, 1e-3, -1e-3, -0.02, 0.01, -1e-3, 1e-4], order=6),
    Case("opencv4", BARREL[:4]),
    Case("opencv5", BARREL),
]
every = pytest.mark.parametrize("case", CASES, ids=[case.label for case in CASES])


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


def opencv_vector(lens, k):
    """Coefficients in OpenCV's places, zero where the lens has none."""
    order = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
    return np.array([dict(zip(lens.names, k, strict=True)).get(name, 0.0) for name in order])


def is_opencvs(case):
    return case.label.startswith("opencv") or (case.label.startswith("radial") and len(case.k) < 3)


@pytest.mark.parametrize(
    "case",
    [case for case in CASES if is_opencvs(case) and "step=1" not in repr(case.lens)],
    ids=lambda case: case.label,
)
def test_projection_is_opencvs(case):
    rays, matrix = case.rays(), np.array([[1400.0, 0, 955], [0, 1350, 540], [0, 0, 1]])
    truth, _ = cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), matrix, opencv_vector(case.lens, case.k)
    )
    plane = case.lens.distort(rays, case.k)
    np.testing.assert_allclose(plane * [1400, 1350] + [955, 540], truth[:, 0], rtol=0, atol=1e-9)


def test_nothing_is_claimed_beyond_the_fold():
    """w (1 - w^2/3) turns back at w = 1, where it is 2/3: its image is empty beyond that."""
    lens, k = lens_named("radial", order=1, tangential=False), np.array([-1 / 3])
    assert lens.limit(k) == pytest.approx(np.pi / 4, rel=1e-14)
    rays = np.array([[0.999, 0, 1], [1.001, 0, 1], [0, -1.5, 1], [0, 0.1, -1]])
    assert lens.seen(rays, k).tolist() == [True, False, False, False]
    found = lens.undistort(np.array([[0.6666, 0], [0.6667, 0], [0, -5]]), k)
    assert found.found.tolist() == [True, False, False]
    assert np.isnan(found.rays[1:]).all()


def test_unknown_lenses_options_and_orders_are_named():
    for name, options, words in (
        ("barrel", {}, "no lens is called barrel: use one of radial, "),
        ("radial", {"orders": 2}, "has no option orders: it has order, tangential"),
        ("opencv4", {"order": 3}, "has no option order: it has none"),
        ("radial", {"order": 7}, "order 7 of lens radial: use 0 to 6"),
    ):
        with pytest.raises(InputError, match=words):
            lens_named(name, **options)
