"""Caveats: what a comparison can't vouch for is said, and only then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.criteria.goodness import NO_REFERENCE
from bayescal.comparison.findings.case import Case
from bayescal.comparison.findings.sampling import sampling
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.results import OrderResult
from bayescal.inference.checked_posterior import sample_posterior
from bayescal.linear.closed_form import exact_posterior
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.points.notes import point_notes
from bayescal.points.setup import Setup
from tests.helpers.problems import field_rule, make_model, thesis_axis
from tests.helpers.wrong_proposals import Misstated


@pytest.fixture
def result(thesis_comparison) -> OrderResult:
    """Order 2 of c, soundly sampled."""
    return thesis_comparison.axes["c"][2]


def caveats(result: OrderResult, noise) -> list[str]:
    """What the sampling of one order says against it."""
    data = thesis_axis("c")
    axis = Axis(data, noise, "inferred", field_rule(data), "separable", 2)
    return [f.text for f in sampling(Case(axis, [result], GAUSSIAN, NO_REFERENCE))]


@pytest.fixture
def noise(thesis_comparison):
    return thesis_comparison.axes["c"].noise


def test_a_sound_result_has_no_caveat(result, noise):
    assert caveats(result, noise) == []
    assert result.sound


def test_draws_at_odds_with_the_closed_form_are_said_to_be(result, noise):
    """Negative control: draws of a proposal 10 % wider than it claims."""
    exact = exact_posterior(make_model(thesis_axis("c"), 2))
    wrong = sample_posterior(
        exact.model, np.random.default_rng(9), 4000, exact, Misstated(exact, 1.1)
    )
    found = replace(result, posterior=wrong)
    assert not found.sound
    assert any("order 2 disagree with the closed form" in c for c in caveats(found, noise))


def test_chains_that_did_not_reach_the_rule_are_said_so(result, noise):
    chain = replace(result.posterior.chain, converged=False)
    found = replace(result, posterior=replace(result.posterior, chain=chain))
    assert not found.sound
    assert any("order 2 did not reach the stopping rule" in c for c in caveats(found, noise))


def test_exact_fits_are_named(result, noise):
    found = replace(result, fit=replace(result.fit, exact=True))
    assert any("order 2 fits exactly" in c for c in caveats(found, noise))


def test_sigma_piling_up_at_its_lower_bound_is_said():
    """Noise of 1e-4 px, where sigma may not be below 0.01 px."""
    points = bc.thesis()
    x, _, z = points.world.T
    pixels = points.pixels.copy()
    noise = np.random.default_rng(1).normal(0, 1e-4, len(points))
    pixels[:, 0] = 960 + 1000 * (x - 330) / z + noise
    other = bc.Correspondences.from_arrays(points.world, pixels, setup=points.setup)
    verdict = bc.compare(other, [1], axis="r", ess=100).axes["r"].verdict
    assert any("lower bound" in caveat for caveat in verdict.caveats)


def test_sigma_piling_up_at_its_upper_bound_is_said():
    """Values of +-1 have a deviation of 0.5 spans, where sigma may not be above 0.52."""
    y = np.where(np.arange(30) % 2, 1.0, -1.0)
    verdict = bc.compare_polynomials(np.arange(30.0), y, [1], ess=100).axes["y"].verdict
    assert any("upper bound" in caveat for caveat in verdict.caveats)


def test_assumptions_are_noted():
    """The thesis states no width; unknown sizes and points behind the camera are said too."""
    assert "image width 1920 px is assumed" in bc.compare(bc.thesis(), [1], ess=100).notes
    world = np.column_stack([np.linspace(-3, 3, 8), np.ones(8), np.full(8, 5.0)])
    world[0, 2] = -5
    pixels = np.column_stack([np.linspace(0, 80, 8) ** 1.1, np.ones(8)])
    points = bc.Correspondences.from_arrays(world, pixels, setup=Setup(position=(0, 0, 0)))
    found = bc.compare(points, [1], axis="r", ess=100)
    assert "image size is not known" in " ".join(found.notes)
    verdict = found.axes["r"].verdict
    assert "1 point of 8 lies behind the camera" in verdict.caveats[0]
    assert not verdict.decided


def test_points_off_the_image_and_copies_are_noted():
    points = bc.thesis()
    pixels = points.pixels.copy()
    pixels[3] = [2500, 1200]
    off = replace(points, pixels=pixels)
    (note,) = [n for n in bc.compare(off, [1], ess=100).notes if "off the image" in n]
    assert note.startswith("1 of 57 points lies off the image (the first at ")
    assert "r = 2500, c = 1200" in note
    twice = bc.Correspondences.from_arrays(
        np.vstack([points.world, points.world[:2]]),
        np.vstack([points.pixels, points.pixels[:2]]),
        setup=points.setup,
    )
    for found in (bc.compare(twice, [1], ess=100), bc.fit_family(twice, "separable", (1, 1))):
        (note,) = [n for n in found.notes if "exactly" in n]
        assert note.startswith("2 of 59 points repeat another exactly (the first at ")
        assert "point 58" in note
    plain = " ".join(bc.compare(points, [1], ess=100).notes)
    assert "off the image" not in plain
    assert "exactly" not in plain


def test_an_edge_of_the_image_is_on_it():
    """Pixels count from their corners or their centres: half a pixel beyond is no mistake."""
    points = bc.thesis()
    pixels = points.pixels.copy()
    pixels[0], pixels[1] = [-0.5, 0], [1920.5, 1080]
    assert not any("off the image" in n for n in point_notes(replace(points, pixels=pixels)))
