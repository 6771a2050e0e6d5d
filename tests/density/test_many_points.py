"""Densities of many points, summed block by block.

Truth: the same density from whole arrays; of a parabola, itself; of an evidence, that of all
points searched and weighed as few are.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from bayescal.density import many_points, robust_linear
from bayescal.density.many_points import parabola, starts_of_sample
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.optimum import Mode, climb
from bayescal.inference.sampled_posterior import sample_model
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.polynomials.axis_data import generic_axis
from bayescal.polynomials.rows import BLOCK, Design
from bayescal.prior.amplitudes import PriorRule

N = 2 * BLOCK + 1001
NOISES = [StudentT(), OutlierMixture()]
every_noise = pytest.mark.parametrize("noise", NOISES, ids=lambda noise: noise.name)


def model_of(noise, n=N, *, with_sd=False, order=2):
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.5, 0.7, n)
    sd = rng.uniform(0.5, 2, n) if with_sd else None
    t = 500 + 900 * x + 20 * x**2 + rng.standard_t(4, n) * (1.0 if sd is None else sd)
    data = generic_axis(x, t, sd)
    prior = PriorRule("field", 1000.0, 500.0, None).of_order(order)
    level = NoiseLevel.inferred() if sd is None else NoiseLevel.scale()
    return data, RobustLinearModel.of_order(data, order, level, prior, noise)


@every_noise
@pytest.mark.parametrize("with_sd", [False, True], ids=["alike", "own deviations"])
def test_the_density_is_that_of_whole_arrays(noise, with_sd):
    data, model = model_of(noise, with_sd=with_sd)
    assert isinstance(model.design, Design)
    rng = np.random.default_rng(1)
    full = np.column_stack(
        [
            np.array([500.0, 540.0, 2.0]) + rng.standard_normal((7, 3)),
            0.3 * rng.standard_normal((7, model.dimension - 3)),
        ]
    )
    residuals = data.t - full[:, :3] @ data.design(2).T
    given = residuals, model.log_sigma(full), model.eta(full), data.sd
    expected = noise.log_density(*given)
    error = 1e-14 * np.abs(expected).sum(axis=1)
    assert (np.abs(model.fitted(full) - expected.sum(axis=1)) <= error).all()
    np.testing.assert_allclose(model.log_likelihood(full), expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(model.weight(full), noise.weight(*given).mean(axis=0), rtol=1e-9)


def test_rows_of_a_design_are_those_of_the_whole():
    data, model = model_of(StudentT())
    points = np.array([3, BLOCK, N - 1])
    np.testing.assert_array_equal(model.taken(points).design, data.design(2)[points])
    assert model.design.shape == data.design(2).shape
    assert sum(len(block.t) for block in model.blocks()) == N


def test_a_parabola_is_itself():
    """Differences of second order are exact but for rounding."""
    rng = np.random.default_rng(2)
    root = np.tril(rng.standard_normal((4, 4))) + 2 * np.eye(4)
    centre, slope = rng.standard_normal((2, 4))

    def density(theta):
        z = np.linalg.solve(root, (theta - centre).T)
        return theta @ slope - (z * z).sum(axis=0) / 2 - 1000

    found = parabola(density, Mode(centre, 0.0, root))
    theta = centre + 5 * rng.standard_normal((20, 4))
    np.testing.assert_allclose(found(theta), density(theta), rtol=0, atol=1e-8)


@every_noise
def test_modes_of_a_sample_lie_near_those_of_all(noise, monkeypatch):
    """Within the sample's own deviations, which are wider by sqrt(n / m)."""
    monkeypatch.setattr(many_points, "MANY", 4000)
    _, model = model_of(noise)
    starts = starts_of_sample(model)
    mode = climb(model.log_prob, starts[0])
    wide = math.sqrt(N / 4000)
    assert np.abs(np.linalg.solve(wide * mode.root, starts[0] - mode.theta)).max() < 5


def test_evidence_and_posterior_do_not_depend_on_how_modes_are_looked_for(monkeypatch):
    """Within the Monte Carlo errors of both."""
    _, model = model_of(StudentT(), 6000)
    plain = sample_model(model, np.random.default_rng(3), 400, ladder=model.ladder)
    monkeypatch.setattr(many_points, "MANY", 2000)
    monkeypatch.setattr(robust_linear, "MANY", 2000)
    assert model.evidence_draws < robust_linear.EVIDENCE_DRAWS
    quick = sample_model(
        dataclasses.replace(model),
        np.random.default_rng(4),
        400,
        evidence_draws=model.evidence_draws,
        ladder=model.ladder,
    )
    assert quick.sound
    error = math.hypot(plain.log_evidence_error, quick.log_evidence_error)
    assert abs(quick.log_evidence - plain.log_evidence) < 5 * error
    assert error < 0.05
    for one, other in zip(quick.parameters, plain.parameters, strict=True):
        error = 5 * math.hypot(one.mcse_mean, other.mcse_mean)
        assert abs(one.mean - other.mean) < error
