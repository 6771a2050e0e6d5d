"""The density of a linear model under any noise: against a plain sum over the points."""

from __future__ import annotations

import dataclasses
import math
import tracemalloc

import numpy as np
import pytest
from scipy import integrate, stats

import bayescal as bc
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.errors import InputError
from bayescal.noise.gaussian import Gaussian
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule

LEVELS = {
    "known": NoiseLevel.known(0.7),
    "inferred": NoiseLevel.inferred(),
    "scale": NoiseLevel.scale(),
}


def model_of(level, noise, tau=None, order=3, with_sd=False):
    data = axis_data(bc.thesis(), "c")
    sd = np.linspace(0.5, 2, len(data)) if with_sd else None
    prior = PriorRule("field", data.size, data.size / 2, tau).of_order(order)
    base = RobustLinearModel.of_order(data, order, level, prior, noise)
    return RobustLinearModel(
        base.design, base.t, sd, prior, level, noise, base.to_reported, base.coefficients
    )


def plain_log_prob(model, theta):
    """Sum over points of scipy's densities, tau by quadrature; one draw, nothing shared."""
    p = model.size
    b, rest = theta[:p], list(theta[p:])
    total = 0.0
    if model.level.value is None:
        u = rest.pop(0)
        lower, upper = (math.log(v) for v in model.level.bounds)
        sigma = math.exp(lower + (upper - lower) * stats.norm.cdf(u))
        total += stats.norm.logpdf(u)
    else:
        sigma = model.level.value
    for i in range(len(model.t)):
        scale = sigma * (1.0 if model.sd is None else model.sd[i])
        residual = model.t[i] - sum(model.design[i, j] * b[j] for j in range(p))
        if isinstance(model.noise, StudentT):
            total += stats.t.logpdf(residual, math.exp(rest[0]), scale=scale)
        elif isinstance(model.noise, OutlierMixture):
            f = stats.norm.cdf(rest[0]) / 2
            width = 5 * 200 ** stats.norm.cdf(rest[1])
            good = (1 - f) * stats.norm.pdf(residual, scale=scale)
            bad = f * stats.norm.pdf(residual, scale=math.hypot(scale, width))
            total += math.log(good + bad)
        else:
            total += stats.norm.logpdf(residual, scale=scale)
    if isinstance(model.noise, StudentT):
        total += stats.gamma(2, scale=10).logpdf(math.exp(rest[0])) + rest[0]
    if isinstance(model.noise, OutlierMixture):
        total += stats.norm.logpdf(rest[0]) + stats.norm.logpdf(rest[1])
    size = model.prior.size
    total += stats.norm.logpdf(b[0], size / 2, size / 2) + stats.norm.logpdf(b[1], 0, size / 2)

    def of_tau(log_tau):
        return np.prod(stats.norm.pdf(b[2:], scale=math.exp(log_tau) * size))

    if model.prior.tau is not None:
        return total + math.log(of_tau(math.log(model.prior.tau)))
    ends = math.log(0.01 / size), math.log(0.5)
    integral, _ = integrate.quad(of_tau, *ends, epsabs=0, epsrel=1e-11, limit=400)
    return total + math.log(integral / (ends[1] - ends[0]))


@pytest.mark.parametrize("noise", [Gaussian(), StudentT(), OutlierMixture()], ids=lambda n: n.name)
@pytest.mark.parametrize("level", LEVELS.values(), ids=LEVELS)
@pytest.mark.parametrize("tau", [None, 0.05])
def test_log_prob_is_a_plain_sum_over_the_points(noise, level, tau):
    model = model_of(level, noise, tau, with_sd=level.source == "scale")
    rng = np.random.default_rng(1)
    start = model.starts()
    theta = start + rng.normal(0, 0.3, start.shape)
    found = model.log_prob(theta)
    for row, value in zip(theta, found, strict=True):
        assert value == pytest.approx(plain_log_prob(model, row), rel=1e-10)


def test_reported_parameters_are_what_they_are_called():
    model = model_of(LEVELS["inferred"], OutlierMixture(infers_offset=True))
    assert model.names == (
        *(f"beta_{j}" for j in range(4)),
        "sigma",
        "tau",
        "bad_fraction",
        "bad_width",
        "bad_offset",
    )
    assert model.dimension == 4 + 1 + 3
    theta = model.starts()
    full = model.complete(theta, np.random.default_rng(1))
    reported = model.report(full)
    assert reported.shape == (len(theta), len(model.names))
    data = axis_data(bc.thesis(), "c")
    monomials = np.vander(data.x, 4, increasing=True)
    # Both are the same polynomial.
    assert monomials @ reported[0, :4] == pytest.approx(model.design @ theta[0, :4], rel=1e-12)
    assert reported[:, 5].min() >= 0.01 / data.size
    assert reported[:, 5].max() <= 0.5
    trimmed = len(theta) - 6
    assert trimmed > 0
    assert reported[:, 6] == pytest.approx([0.05, 0.05, 0.42] * 2 + [0.42] * trimmed)


def test_starts_do_not_follow_the_bad_points():
    """Truth: a line with known coefficients, a fifth of whose points are far off."""
    x = np.linspace(-1, 1, 40)
    t = 100 + 30 * x + np.random.default_rng(1).normal(0, 0.5, 40)
    t[[1, 4, 9, 14, 20, 27, 33, 38]] += np.array([60, 45, -30, 60, 80, 60, -20, 60])
    prior = PriorRule("field", 1000.0, 500.0).of_order(1)
    model = RobustLinearModel(
        np.column_stack([np.ones(40), x]),
        t,
        None,
        prior,
        NoiseLevel.inferred(),
        OutlierMixture(),
        np.eye(2),
        ("b_0", "b_1"),
    )
    starts = model.starts()
    assert np.isfinite(model.log_prob(starts)).all()
    fitted = starts[3, :2]  # the M-estimate's; least squares comes first, the trimmed fits last
    assert np.abs(fitted - [100, 30]).max() < 1
    assert np.abs(starts[0, :2] - [100, 30]).max() > 5
    assert np.abs(starts[6, :2] - [100, 30]).max() < 1


def test_a_flat_prior_is_refused():
    data = axis_data(bc.thesis(), "c")
    prior = PriorRule("flat", data.size, data.size / 2).of_order(1)
    with pytest.raises(InputError, match="student-t noise needs a proper prior"):
        RobustLinearModel.of_order(data, 1, NoiseLevel.inferred(), prior, StudentT())


@pytest.mark.parametrize("noise", [StudentT(), OutlierMixture()], ids=lambda n: n.name)
def test_what_is_said_of_points_is_the_mean_over_all_draws_in_little_memory(noise):
    """Truth: all draws by all points at once, which of many would be gigabytes."""
    few = model_of(NoiseLevel.inferred(), noise)
    theta = few.starts()[0] + 0.1 * np.random.default_rng(0).standard_normal((3000, few.dimension))
    given = few.residuals(theta), few.log_sigma(theta), few.eta(theta), few.sd
    weight = noise.weight(*given).mean(axis=0)
    np.testing.assert_allclose(few.weight(theta), weight, rtol=1e-12)
    bad = noise.bad_probability(*given)
    if bad is None:
        assert few.bad_probability(theta) is None
    else:
        np.testing.assert_allclose(few.bad_probability(theta), bad.mean(axis=0), rtol=1e-11)
    many = dataclasses.replace(few, design=np.tile(few.design, (300, 1)), t=np.tile(few.t, 300))
    tracemalloc.start()
    found = many.weight(theta[:500])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    np.testing.assert_allclose(found[:57], few.weight(theta[:500]), rtol=1e-11)
    assert peak < 500 * len(found) * 8 / 5  # of one array of all
