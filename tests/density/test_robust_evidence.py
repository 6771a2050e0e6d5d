"""Evidence and posteriors under robust noise: quadrature, the Gaussian limit, dynesty, seeds."""

from __future__ import annotations

import math
from dataclasses import replace

import dynesty
import numpy as np
import pytest
from scipy.special import gammaincinv, logsumexp, ndtri

import bayescal as bc
from bayescal.comparison.criteria.goodness import NO_REFERENCE, GoodnessOfFit
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.criteria.leave_one_out import leave_one_out
from bayescal.comparison.criteria.psis import sampled_leave_one_out
from bayescal.comparison.findings.case import Case
from bayescal.comparison.findings.sampling import MANY_BAD, sampled
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.results import OrderResult
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.optimum import find_modes
from bayescal.inference.sampled_posterior import sample_model
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import LeastSquaresFit, factorise
from bayescal.linear.model import LinearModel
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.polynomials.axis_data import generic_axis
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule
from tests.helpers.hogg import TABLE


def thesis_model(axis, order, noise, tau=None):
    data = axis_data(bc.thesis(), axis)
    prior = PriorRule("field", data.size, data.size / 2, tau).of_order(order)
    return RobustLinearModel.of_order(data, order, NoiseLevel.inferred(), prior, noise)


def hogg_model(noise):
    x, y, sd = TABLE.T
    data = generic_axis(x, y, sd)
    prior = PriorRule("field", data.size, float(y.mean())).of_order(1)
    return RobustLinearModel.of_order(data, 1, NoiseLevel.known(1.0), prior, noise)


@pytest.mark.parametrize("noise", [StudentT(), OutlierMixture()], ids=lambda n: n.name)
def test_evidence_and_moments_are_those_of_quadrature(noise):
    """A constant and a known sigma leave two or three coordinates: the midpoint rule on a grid."""
    t = np.random.default_rng(3).normal(500, 2, 12)
    t[[2, 7]] += (25, -60)
    prior = PriorRule("field", 1000.0, 500.0).of_order(0)
    model = RobustLinearModel(
        np.ones((12, 1)), t, None, prior, NoiseLevel.known(2.0), noise, np.eye(1), ("b_0",)
    )
    axes = [np.linspace(490, 510, 201)]
    axes += [np.linspace(-4, 8, 201)] if noise.dimension == 1 else [np.linspace(-6, 6, 121)] * 2
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, model.dimension)
    steps = math.log(math.prod(a[1] - a[0] for a in axes))
    log_prob = model.log_prob(grid)
    truth = float(logsumexp(log_prob)) + steps
    found = sample_model(model, np.random.default_rng(1), 2000)
    assert found.log_evidence == pytest.approx(truth, abs=4 * found.log_evidence_error + 1e-3)
    weights = np.exp(log_prob - logsumexp(log_prob))
    mean = float(weights @ grid[:, 0])
    assert found["b_0"].mean == pytest.approx(mean, abs=4 * found["b_0"].mcse_mean + 1e-3)


def test_student_t_of_very_large_nu_is_gaussian_in_draws_evidence_and_leave_one_out():
    """Truth: the closed form; 1e10 degrees of freedom change a log density by under 1e-6."""
    data = axis_data(bc.thesis(), "c")
    prior = PriorRule("field", data.size, data.size / 2).of_order(2)
    level = NoiseLevel.inferred()
    exact = exact_posterior(LinearModel(factorise(data, 2), 2, level, prior, data.symbol))
    model = RobustLinearModel.of_order(data, 2, level, prior, StudentT(1e10))
    found = sample_model(model, np.random.default_rng(1), 4000)
    assert model.names == exact.model.names
    assert found.log_evidence == pytest.approx(exact.log_evidence, abs=4 * found.log_evidence_error)
    means, sds = exact.summary
    for j, p in enumerate(found.parameters):
        assert abs(p.mean - means[j]) < 4 * p.mcse_mean
        error = sds[j] * math.sqrt((exact.kurtosis[j] - 1) / 4 / found.chain.diagnostics[j].ess_sd)
        assert abs(p.sd - sds[j]) < 4 * error
    loo = leave_one_out(data, exact)
    psis = sampled_leave_one_out(found, model.log_likelihood)
    assert psis.elpd == pytest.approx(loo.elpd, abs=4 * psis.mcse)


def prior_transform(model):
    """From the unit cube to theta, written from the documented priors alone."""
    size = model.prior.size
    means = np.array([model.prior.mean[0], 0.0])

    def transform(u):
        theta = ndtri(u)
        theta[:2] = means + size / 2 * theta[:2]
        if model.noise.parameters == ("nu",):
            theta[-1] = math.log(10 * gammaincinv(2, u[-1]))
        return theta

    return transform


@pytest.mark.parametrize(
    "model",
    [
        thesis_model("c", 1, StudentT()),
        thesis_model("r", 1, OutlierMixture()),
        hogg_model(OutlierMixture()),
    ],
    ids=["c, student-t", "r, mixture", "Hogg, mixture"],
)
def test_evidence_agrees_with_nested_sampling(model):
    """Truth: dynesty with its own error; priors as documented, likelihood alone from the model."""
    sampler = dynesty.NestedSampler(
        lambda theta: float(model.log_likelihood(theta[None]).sum()),
        prior_transform(model),
        model.dimension,
        nlive=100,
        sample="rwalk",
        rstate=np.random.default_rng(2),
    )
    sampler.run_nested(dlogz=0.1, print_progress=False)
    found = sample_model(model, np.random.default_rng(1), 1000)
    error = math.hypot(float(sampler.results.logzerr[-1]), found.log_evidence_error)
    assert abs(float(sampler.results.logz[-1]) - found.log_evidence) < 3 * error
    assert found.log_evidence_error < 0.01


def test_evidence_spreads_little_over_seeds_and_bridge_sampling_agrees():
    """Ten seeds within 0.03 nat; the importance and the bridge estimate within 0.05."""
    model = thesis_model("c", 1, OutlierMixture(), tau=0.05)
    found = [sample_model(model, np.random.default_rng(seed), 400).estimate for seed in range(10)]
    values = [e.log_evidence for e in found]
    assert np.std(values, ddof=1) < 0.03
    assert max(abs(e.bridge - e.log_evidence) for e in found) < 0.05
    # Its spread is what the estimates say of themselves, within a factor of chi's 99.9 %.
    assert np.std(values, ddof=1) < 1.8 * np.sqrt(np.mean([e.error**2 for e in found]))


def test_modes_of_few_good_points_are_found_whatever_the_seed():
    """r of order 3 and c of order 4 have two and five modes; each seed weighs them alike."""
    for axis, order in (("r", 3), ("c", 4)):
        model = thesis_model(axis, order, OutlierMixture())
        found = [sample_model(model, np.random.default_rng(seed), 400) for seed in range(3)]
        assert min(len(f.modes) for f in found) > 1
        values = [f.log_evidence for f in found]
        assert np.std(values, ddof=1) < 0.03
        assert max(abs(f.estimate.bridge - f.log_evidence) for f in found) < 0.05


def test_whole_pixels_make_no_spike():
    """Control: with readings taken as exact, 20 of them agree to a hundredth of a pixel.

    That mode then outweighs all others by far: an evidence of the rounding, not of the order.
    """
    model = thesis_model("c", 4, OutlierMixture())
    exact = replace(model, level=NoiseLevel.inferred())
    tight = model.starts()[6:]  # the trimmed fits', with s at 0.05 px
    lower, upper = exact.level.log_bounds
    tight[:, model.size] = ndtri((math.log(0.05) - lower) / (upper - lower))
    found = [find_modes(m.log_prob, tight) for m in (model, exact)]
    real, spike = (max(modes, key=lambda mode: mode.log_mass) for modes in found)
    assert np.exp(model.log_sigma(real.theta[None]))[0] > 1
    assert np.exp(exact.log_sigma(spike.theta[None]))[0] < 0.02
    assert spike.log_mass > real.log_mass + 10


def test_without_the_bound_on_the_fraction_the_labels_swap_and_that_is_said():
    """Negative control: clean data and a fraction up to 1, of which most is soon "bad"."""
    rng = np.random.default_rng(1)
    x = np.linspace(-1, 1, 40)
    data = generic_axis(x, 500 + 300 * x + rng.normal(0, 4, 40))
    prior = PriorRule("field", 1000.0, 500.0).of_order(1)
    found = {
        largest: sample_model(
            RobustLinearModel.of_order(
                data, 1, NoiseLevel.inferred(), prior, OutlierMixture(largest_fraction=largest)
            ),
            np.random.default_rng(1),
            1000,
        )
        for largest in (0.5, 1.0)
    }
    assert found[1.0]["bad_fraction"].mean > MANY_BAD
    axis = Axis(data, NoiseLevel.inferred(), "", PriorRule("field", 1000.0, 500.0), "", 1)

    def said(posterior):
        case = Case(axis, [result_of(posterior)], OutlierMixture(), NO_REFERENCE)
        return [finding.text for finding in sampled(case)]

    assert any("bad is no exception here" in line for line in said(found[1.0]))
    assert found[0.5]["bad_fraction"].mean < MANY_BAD
    assert not said(found[0.5])


def result_of(posterior):
    """Wrap a posterior as the only order compared."""
    fit = LeastSquaresFit(1, np.zeros(2), None, np.zeros(2), 0.0, 38, None, False)
    none = GoodnessOfFit(None, 38, None, None, None, None, None)
    return OrderResult(
        key=Key.of_axis("y", 1, "outlier-mixture"),
        log_evidence=posterior.log_evidence,
        log_evidence_error=posterior.log_evidence_error,
        posterior=posterior,
        data=generic_axis(np.arange(3.0), np.arange(3.0)),
        fit=fit,
        rss_px2=0.0,
        goodness=none,
        criteria=Criteria(5),
    )
