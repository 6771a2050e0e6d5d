"""Simulated points: the truth that is told is the one they were made with."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

import bayescal as bc
from bayescal.errors import InputError
from bayescal.points.reader import load
from bayescal.points.writer import to_csv
from bayescal.polynomials.basis import Domain
from bayescal.simulation import DEFAULT_SETUP, DEFAULT_TAU, VOLUME, simulate

BOTH = {"r": 3, "c": 2}
SEEDS = 400


def made(seed=0, orders=BOTH, sigma=1.0, **settings):
    return simulate(orders, sigma, np.random.default_rng(seed), **settings)


@pytest.mark.parametrize(
    "settings",
    [{}, {"like": bc.thesis()}, {"coefficients": {"r": [900.0, 1100, -30], "c": [500, 1200.0]}}],
    ids=["drawn", "like", "given"],
)
def test_without_noise_pixels_are_the_told_polynomials(settings):
    """Truth: numpy's polynomial of x/z and y/z, c = height - row."""
    points, truth = made(sigma=0.0, **settings)
    x, y, z = (points.world - np.array(points.setup.position)).T
    r = np.polynomial.Polynomial(truth.axes["r"].coefficients)(x / z)
    c = np.polynomial.Polynomial(truth.axes["c"].coefficients)(y / z)
    np.testing.assert_allclose(points.pixels[:, 0], r, rtol=0, atol=1e-9)
    np.testing.assert_allclose(points.pixels[:, 1], 1080 - c, rtol=0, atol=1e-9)
    for axis, given in settings.get("coefficients", {}).items():
        assert truth.axes[axis].coefficients.tolist() == given
        assert (truth.axes[axis].order, truth.axes[axis].tau) == (len(given) - 1, None)


def test_amplitudes_and_coefficients_are_the_same_polynomial():
    """Truth: numpy's Legendre series on the domain that the points span."""
    points, truth = made(like=bc.thesis(), coefficients={"c": [500.0, 1200.0, 40.0, -90.0]})
    for axis, column in (("r", 0), ("c", 1)):
        told = truth.axes[axis]
        frame = points.camera_frame()
        assert told.domain == Domain.of(frame[:, column] / frame[:, 2])
        s = np.linspace(-1, 1, 9)
        x = told.domain.middle + told.domain.half_range * s
        series = np.polynomial.legendre.legval(s, told.amplitudes)
        monomials = np.polynomial.Polynomial(told.coefficients)(x)
        np.testing.assert_allclose(series, monomials, rtol=1e-13)


def standardised(tau):
    """Amplitudes of r and noise of r over many seeds, each over its own deviation."""
    amplitudes, noise = [], []
    for seed in range(SEEDS):
        points, truth = made(seed, sigma=0.5, n=20, tau=tau)
        told = truth.axes["r"]
        frame = points.camera_frame()
        exact = np.polynomial.Polynomial(told.coefficients)(frame[:, 0] / frame[:, 2])
        noise.append((points.pixels[:, 0] - exact) / 0.5)
        amplitudes.append(told.amplitudes[2:] / 96)
        assert told.amplitudes[:2].tolist() == [960, 768]  # fills 0.8 of 1920 px
    return np.concatenate(amplitudes), np.concatenate(noise)


def test_amplitudes_follow_the_field_prior_and_noise_is_normal():
    """Truth: standard normals (docs/method.md), by Kolmogorov-Smirnov; control: half the tau."""
    amplitudes, noise = standardised(0.05)
    assert stats.kstest(amplitudes, "norm").pvalue > 1e-4
    assert stats.kstest(noise, "norm").pvalue > 1e-4
    amplitudes, noise = standardised(0.025)
    assert stats.kstest(amplitudes, "norm").pvalue < 1e-6


def test_the_default_layout_is_in_front_of_the_camera():
    setup = dataclasses.replace(DEFAULT_SETUP, position=(1000.0, -20.0, 5.0))
    points, truth = made(n=2000, setup=setup)
    x, y, z = points.camera_frame().T
    for values, (lower, upper) in zip((x / z, y / z, z), VOLUME, strict=True):
        assert lower - 1e-5 <= values.min() < lower + 0.01 * (upper - lower)
        assert upper + 1e-5 >= values.max() > upper - 0.01 * (upper - lower)
    assert len(made()[0]) == 57
    assert truth.axes["r"].tau == DEFAULT_TAU
    assert made(orders={"r": 1, "c": 1})[1].axes["r"].tau is None


@pytest.mark.parametrize("n", [20, 57, 130, None])
def test_like_takes_every_point_as_often_as_n_allows(n):
    thesis = bc.thesis()
    points, _ = made(like=thesis, n=n)
    wanted = 57 if n is None else n
    rows, counts = np.unique(points.world, axis=0, return_counts=True)
    original, often = np.unique(thesis.world, axis=0, return_counts=True)
    assert len(points) == wanted
    assert len(set(points.labels)) == wanted
    assert points.setup == thesis.setup
    known = {tuple(w): k for w, k in zip(original.tolist(), often.tolist(), strict=True)}
    for row, count in zip(rows.tolist(), counts.tolist(), strict=True):
        assert wanted // 57 * known[tuple(row)] <= count <= -(-wanted // 57) * known[tuple(row)]
    if wanted >= 57:
        assert points.labels[:57] == thesis.labels
        assert len(rows) == len(original)


def test_points_of_a_group_stay_in_it():
    world = [[1.0, 2, 5], [2, 1, 5], [3, 4, 6], [4, 3, 7]]
    like = bc.Correspondences.from_arrays(
        world, np.zeros((4, 2)), groups=("a", "a", "b", "b"), setup=DEFAULT_SETUP
    )
    points, _ = made(like=like, orders={"r": 1, "c": 1}, n=7)
    group = {tuple(w): g for w, g in zip(world, like.groups, strict=True)}
    assert points.groups == tuple(group[tuple(w)] for w in points.world.tolist())


def test_points_survive_the_round_trip_through_a_file(tmp_path):
    points, _ = made(like=bc.thesis(), n=60)
    (tmp_path / "sim.csv").write_text(to_csv(points))
    read = load(tmp_path / "sim.csv", points.setup)
    assert (read.world.tolist(), read.pixels.tolist()) == (
        points.world.tolist(),
        points.pixels.tolist(),
    )
    assert read.labels == points.labels


def test_a_seed_gives_the_same_points_and_sigma_only_scales_the_noise():
    first, again, other = made(7), made(7), made(8)
    assert to_csv(first[0]) == to_csv(again[0])
    assert to_csv(first[0]) != to_csv(other[0])
    exact, doubled = made(7, sigma=0.0)[0], made(7, sigma=2.0)[0]
    noise = first[0].pixels - exact.pixels
    np.testing.assert_allclose(doubled.pixels - exact.pixels, 2 * noise, atol=1e-9)
    assert made(7, orders={"r": 5, "c": 2})[0].pixels[:, 1].tolist() == (
        first[0].pixels[:, 1].tolist()
    )


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"sigma": -1.0}, "sigma must be from 0"),
        ({"sigma": float("nan")}, "sigma must be from 0"),
        ({"n": 1}, "number of points must be from 2"),
        ({"n": 3}, "order 3 has 4 coefficients for 3 points"),
        ({"tau": 0.0}, "tau must be a positive number"),
        ({"tau": float("inf")}, "tau must be a positive number"),
        ({"tau": 0.1, "coefficients": {"r": [1, 2], "c": [1, 2]}}, "tau has no part"),
        ({"coefficients": {"r": [1.0, float("nan")]}}, "coefficients of r must be finite"),
        ({"coefficients": {"r": [1.0]}}, "order 0 is out of range"),
        ({"orders": {"r": 21, "c": 1}, "n": 100}, "order 21 is out of range"),
        ({"setup": bc.Setup()}, "image width is not known"),
        ({"like": bc.thesis(), "n": 100, "orders": {"r": 20, "c": 1}, "setup": bc.Setup(
            position=(0, 0, 300), width=9, height=9)}, "in the camera's plane"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        made(**settings)
