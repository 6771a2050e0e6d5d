"""Errors of the world that flatten the curve are said where they matter, and only there."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.polynomials.separable import axis_data

SLOPE = 1066.0  # px
N = 57


def read_with(error: float) -> bc.Correspondences:
    """Give a straight line's points, x read with an error worth so many px, stated as it is."""
    rng, sd = np.random.default_rng(7), error / SLOPE
    true = axis_data(bc.thesis(), "r").x
    world = np.column_stack([true + rng.normal(0, sd, N), np.zeros(N), np.ones(N)])
    pixels = np.column_stack([986 + SLOPE * true + rng.normal(0, 0.5, N), np.zeros(N)])
    setup = bc.Setup(width=1920.0, height=1080.0, world_sigma=(sd, 0.0, 0.0))
    return bc.Correspondences.from_arrays(world, pixels, setup=setup)


def caveats(points: bc.Correspondences, sigma: float | str) -> list[str]:
    found = bc.compare(points, [1], axis="r", hint=False, sigma=sigma, ess=400)
    return [f.text for f in found["r"].verdict.findings if f.kind == "world-errors"]


@pytest.mark.parametrize("sigma", [0.5, "inferred"])
def test_a_curve_that_is_flattened_is_said_to_be(sigma: float | str) -> None:
    """Truth: slope times s² / var(x), times how far the further end is from the mean; 2 digits."""
    points = read_with(40.0)
    (text,) = caveats(points, sigma)
    x, s = points.world[:, 0], 40 / SLOPE
    furthest = np.abs(x - x.mean()).max()
    expected = SLOPE * s**2 / np.var(x) * furthest
    off = float(text.partition("order 1 is off by about ")[2].partition(" px at x/z = ")[0])
    assert off == pytest.approx(expected, rel=0.08)  # 2 digits, and the slope's own error


@pytest.mark.parametrize("sigma", [0.5, "inferred"])
def test_small_errors_are_not_spoken_of(sigma: float | str) -> None:
    assert caveats(read_with(5.0), sigma) == []
