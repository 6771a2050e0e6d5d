"""One contract that every lens keeps.

Truths: the projections of OpenCV and COLMAP, the rays that the models' authors give in closed
form, central differences, a search over angles for where a lens turns back, and identities
(undistort undoes distort, many cameras at once are the same as one by one).
"""

from __future__ import annotations

import cv2
import numpy as np
import pycolmap
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mpmath import mp

from bayescal.cameras.lenses import lens_named
from bayescal.cameras.lenses.axial import Axial
from bayescal.cameras.lenses.planar import Planar
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
RATIONAL = [8.0, 3.0, 8e-4, -5e-4, 0.2, 8.4, 5.5, 1.0]
CASES = [
    Case("radial", [], order=0, tangential=False),
    Case("radial", [8e-4, -5e-4], order=0, tangential=True),
    Case("radial", [-0.1], order=1, tangential=False),
    Case("radial", [-0.2, 0.3], order=2, tangential=False, step=1),
    Case("radial", [-0.28, 0.12, 1e-3, -1e-3, -0.02, 0.01, -1e-3, 1e-4], order=6),
    Case("opencv4", BARREL[:4]),
    Case("opencv5", BARREL),
    Case("rational", [-0.3, 0.1, 8e-4, -5e-4, -0.01, 0.05], order=1),
    Case("opencv8", RATIONAL, 60),
    Case("thin-prism", [-0.28, 0.12, 8e-4, -5e-4, 1e-3, -2e-4, -8e-4, 3e-4]),
    Case("opencv12", [*RATIONAL, 1e-3, -2e-4, -8e-4, 3e-4]),
    Case("fisheye", [], 175, order=0),
    Case("fisheye", [-0.02, 0.003, -0.0015, 0.0002], 110),
    Case("fisheye", [0.01, -0.004, 0.0015, -0.0003, 2e-5], 100, order=5),
    Case("division", [-0.25], 150),
    Case("division", [0.1], 50),
    Case("eucm", [0.62, 1.1], 110),
    Case("eucm", [0.3, 0.8], 105),
    Case("double-sphere", [-0.2, 0.6], 110),
    Case("double-sphere", [0.3, 0.4], 120),
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


MATRIX = np.array([[1400.0, 0, 955], [0, 1350, 540], [0, 0, 1]])


def pixels(case, rays):
    return case.lens.distort(rays, case.k) * [1400, 1350] + [955, 540]


def opencv_vector(lens, k):
    """Coefficients in OpenCV's places, zero where the lens has none."""
    order = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
    return np.array([dict(zip(lens.names, k, strict=True)).get(name, 0.0) for name in order])


def is_opencvs(lens):
    return isinstance(lens, Planar) and lens.numerator <= 3 and lens.step == 2


def some(chosen):
    kept = [case for case in CASES if chosen(case.lens)]
    return pytest.mark.parametrize("case", kept, ids=[case.label for case in kept])


@some(is_opencvs)
def test_projection_is_opencvs(case):
    rays = case.rays()
    k = opencv_vector(case.lens, case.k)
    truth, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), MATRIX, k)
    np.testing.assert_allclose(pixels(case, rays), truth[:, 0], rtol=0, atol=1e-9)


@some(lambda lens: lens.name == "fisheye" and lens.order <= 4)
def test_projection_is_that_of_opencvs_fisheye(case):
    rays = case.rays()
    rays = rays[rays[:, 2] > 0.05]
    k = np.append(case.k, np.zeros(4 - len(case.k)))
    truth, _ = cv2.fisheye.projectPoints(rays[:, None], np.zeros(3), np.zeros(3), MATRIX, k)
    np.testing.assert_allclose(pixels(case, rays), truth[:, 0], rtol=0, atol=1e-9)


def colmap_model(case):
    """COLMAP's name and the coefficients that it takes; None where it has no such model."""
    lens, k = case.lens, opencv_vector(case.lens, case.k)
    if lens.name in ("division", "eucm"):
        return lens.name.upper(), case.k
    if lens.name == "fisheye" and lens.order <= 4:
        return "OPENCV_FISHEYE", np.append(case.k, np.zeros(4 - lens.order))
    if is_opencvs(lens) and not lens.prism:
        return ("FULL_OPENCV", k[:8]) if k[4:].any() else ("OPENCV", k[:4])
    return None


@pytest.mark.parametrize(
    "case", [case for case in CASES if colmap_model(case)], ids=lambda case: case.label
)
def test_projection_is_colmaps(case):
    """COLMAP's pixel centres at 0.5 are a matter of the principal point, the same number here."""
    rays = case.rays()
    rays = rays[rays[:, 2] > 0.05]
    model, k = colmap_model(case)
    camera = pycolmap.Camera(
        model=model, width=1911, height=1081, params=[1400, 1350, 955, 540, *k]
    )
    truth = camera.img_from_cam(rays)
    np.testing.assert_allclose(pixels(case, rays), truth, rtol=0, atol=1e-9)


def ray_of_division(u, v, bend):
    return u, v, 1 + bend * (u**2 + v**2)


def ray_of_eucm(u, v, alpha, beta):
    """Khomutenko, Garcia & Martinet 2016, eq. 10."""
    square = u**2 + v**2
    root = mp.sqrt(1 - (2 * alpha - 1) * beta * square)
    return u, v, (1 - beta * alpha**2 * square) / (alpha * root + 1 - alpha)


def ray_of_double_sphere(u, v, xi, alpha):
    """Usenko, Demmel & Cremers 2018, eq. 46-50."""
    square = u**2 + v**2
    root = mp.sqrt(1 - (2 * alpha - 1) * square)
    depth = (1 - alpha**2 * square) / (alpha * root + 1 - alpha)
    scale = (depth * xi + mp.sqrt(depth**2 + (1 - xi**2) * square)) / (depth**2 + square)
    return scale * u, scale * v, scale * depth - xi


CLOSED = {
    "division": ray_of_division,
    "eucm": ray_of_eucm,
    "double-sphere": ray_of_double_sphere,
}


@some(lambda lens: lens.name in CLOSED)
def test_rays_are_those_of_the_authors_closed_form_past_ninety_degrees_too(case):
    rays = case.rays()
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    if case.angle > np.pi / 2:
        assert (unit[:, 2] < 0).any()
    plane = case.lens.distort(rays, case.k)
    with mp.workdps(40):
        for at, (u, v) in enumerate(plane):
            truth = CLOSED[case.lens.name](mp.mpf(u), mp.mpf(v), *(mp.mpf(x) for x in case.k))
            length = mp.sqrt(sum(x**2 for x in truth))
            np.testing.assert_allclose(unit[at], [float(x / length) for x in truth], atol=1e-13)


@some(lambda lens: lens.name == "fisheye")
def test_a_fisheye_is_its_polynomial_past_ninety_degrees_too(case):
    rays = case.rays()
    plane = case.lens.distort(rays, case.k)
    with mp.workdps(40):
        for (x, y, z), found in zip(rays, plane, strict=True):
            rho = mp.sqrt(mp.mpf(x) ** 2 + mp.mpf(y) ** 2)
            angle = mp.atan2(rho, z)
            gain = 1 + sum(mp.mpf(k) * angle ** (2 * j + 2) for j, k in enumerate(case.k))
            scale = angle * gain / rho if rho else 0
            np.testing.assert_allclose(found, [float(x * scale), float(y * scale)], atol=1e-14)


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
