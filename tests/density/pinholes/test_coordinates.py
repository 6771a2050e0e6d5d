"""The coordinates a pinhole is sampled in: evidences must not depend on them."""

from dataclasses import replace

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.families.models import (
    fitted_pinhole,
    gaussian_pinhole,
    noise_levels,
    robust_pinhole,
)
from bayescal.comparison.settings import Settings
from bayescal.density.pinholes.coordinates import suited
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.density.pinholes.proposal import weighted_evidence
from tests.helpers.cameras import problem


def stated_to(sd):
    """The thesis data with the camera's position stated to so many units."""
    points = bc.thesis()
    camera = replace(points.setup.camera, position_sd=(sd, sd, sd))
    return replace(points, setup=replace(points.setup, camera=camera))


def model_of(points, order, position="free", noise="gaussian"):
    settings = Settings(defend=False, noise=noise)
    levels = noise_levels(points, settings, 1)
    fitted = fitted_pinhole(points, order, position, "even", levels.data, settings)
    if noise == "gaussian":
        return gaussian_pinhole(fitted)
    return robust_pinhole(fitted, settings.choice.model(1.0))


def evidence(model, seed=0):
    return weighted_evidence(model, np.random.default_rng(seed), 10_000)


@pytest.mark.parametrize("order", [0, 1])
def test_a_position_pinned_to_a_point_has_the_evidence_of_a_fixed_one(order):
    pinned, fixed = (model_of(stated_to(1e-6), order, position) for position in ("free", "stated"))
    assert pinned.geometry.origin is not None
    one, other = evidence(pinned), evidence(fixed)
    assert one.effective_fraction > 0.7
    error = np.hypot(one.error, other.error)
    assert one.log_evidence == pytest.approx(other.log_evidence, abs=5 * error)


def test_both_kinds_of_coordinates_have_the_same_evidence():
    """Where prior and data know about as much of the position, either will do."""
    points = stated_to(0.5)
    geometry, prior, data = problem(points, 0)
    fit = fit_pinhole(points, geometry, prior, data)
    anchored = type(model_of(points, 0)).of(geometry, prior, data, fit)
    held = model_of(points, 0)
    assert anchored.geometry.origin is None
    assert held.geometry.origin is not None
    one, other = evidence(anchored), evidence(held)
    error = np.hypot(one.error, other.error)
    assert one.log_evidence == pytest.approx(other.log_evidence, abs=5 * error)


def test_the_data_choose_the_anchor_where_they_know_the_position_better():
    for sd, held in ((100.0, False), (0.1, True)):
        points = stated_to(sd)
        geometry, prior, data = problem(points, 1)
        fit = fit_pinhole(points, geometry, prior, data)
        chosen, same = suited(geometry, prior.position, fit)
        assert (chosen.origin is not None) == held
        ours, theirs = chosen.full(same.free[None]), geometry.full(fit.free[None])
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)
        # Of the parameters themselves the covariance is the same: here of the position.
        step = 1e-30j * np.eye(len(fit.free))
        position = geometry.position(geometry.full(fit.free + step)).imag.T / 1e-30
        again = chosen.position(chosen.full(same.free + step)).imag.T / 1e-30
        np.testing.assert_allclose(
            again @ same.covariance @ again.T, position @ fit.covariance @ position.T, rtol=1e-6
        )


@pytest.mark.parametrize("noise", ["gaussian", "student-t"])
def test_a_position_known_to_a_hundredth_is_sampled_well(noise):
    found = bc.fit_family(stated_to(0.01), "pinhole", (0,), noise=noise, ess=200)
    assert found.sound
    assert found.best.posterior.chain.acceptance > 0.45
    assert any("the position found is" in caveat for caveat in found.verdict.caveats)
