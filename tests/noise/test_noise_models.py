"""One contract that every noise model must keep, and what each is compared with."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, stats
from scipy.special import softmax

from bayescal.errors import InputError
from bayescal.noise.choice import NOISE_MODELS, NoiseChoice
from bayescal.noise.gaussian import Gaussian
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from scripts.validation.ranks import DRAWS, p_values

MODELS = {
    "gaussian": Gaussian(),
    "student-t": StudentT(),
    "student-t, nu 4": StudentT(4.0),
    "outlier-mixture": OutlierMixture(),
    "outlier-mixture, offset": OutlierMixture(infers_offset=True),
    "outlier-mixture, up to all": OutlierMixture(largest_fraction=1.0),
}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)


def places(model, rng, size):
    """Values of ln sigma and eta, as a posterior might hold."""
    return rng.normal(0.5, 0.4, size), rng.normal(0.3, 0.8, (size, model.dimension))


def test_every_noise_model_that_can_be_asked_for_keeps_the_contract():
    assert {m.name for m in MODELS.values()} == set(NOISE_MODELS)
    for name in NOISE_MODELS:
        assert NoiseChoice(name).model(1.0).name == name


@every_model
def test_what_is_said_of_it_is_of_all_it_has(model):
    """Its options make it again; its parameters have columns; it tells bad points or says not."""
    assert set(model.parameters) <= set(model.columns)
    if getattr(model, "largest_fraction", 0.5) == 0.5:
        assert type(model).of(1.0, **model.chosen) == model
    assert set(model.chosen) == set(model.options)
    eta = np.zeros((1, model.dimension))
    told = model.bad_probability(np.zeros((1, 2)), np.zeros(1), eta)
    assert (told is not None) == model.tells_bad


@every_model
def test_density_of_a_residual_integrates_to_1(model):
    """Quadrature over the residual, in units that show a tail out to 1e9 sigma."""
    rng = np.random.default_rng(1)
    for log_sigma, eta in zip(*places(model, rng, 3), strict=True):
        for sd in (None, np.array([2.5])):

            def density(u, log_sigma=log_sigma, eta=eta, sd=sd):
                residual = np.sinh(u)
                found = model.log_density(
                    np.array([[residual]]), np.array([log_sigma]), eta[None], sd
                )
                return math.exp(found[0, 0]) * math.cosh(u)

            total, _ = integrate.quad(density, -40, 40, points=[-5, 0, 5], limit=400)
            # A t of nu near 1 has 1e-9 of its mass beyond sinh(40).
            assert total == pytest.approx(1, abs=1e-6)


@every_model
def test_prior_integrates_to_1(model):
    """The midpoint rule in every coordinate, each from -9 to 9 standard deviations or wider."""
    if model.dimension == 0:
        assert model.log_prior(np.empty((2, 0))) == pytest.approx(0)
        return
    ends, nodes = ((-30, 12), 20_000) if model.dimension == 1 else ((-9, 9), 90)
    step = (ends[1] - ends[0]) / nodes
    axis = ends[0] + step * (np.arange(nodes) + 0.5)
    grid = np.stack(np.meshgrid(*[axis] * model.dimension), axis=-1).reshape(-1, model.dimension)
    total = np.exp(model.log_prior(grid)).sum() * step**model.dimension
    assert total == pytest.approx(1, abs=1e-9)


@every_model
def test_many_draws_at_once_are_each_draw_alone(model):
    rng = np.random.default_rng(2)
    log_sigma, eta = places(model, rng, 5)
    residual, sd = rng.normal(0, 5, (5, 7)), rng.uniform(0.5, 2, 7)
    together = model.log_density(residual, log_sigma, eta, sd)
    assert together.shape == residual.shape
    for i in range(5):
        for j in range(7):
            alone = model.log_density(
                residual[i : i + 1, j : j + 1],
                log_sigma[i : i + 1],
                eta[i : i + 1],
                sd[j : j + 1],
            )
            assert alone[0, 0] == pytest.approx(together[i, j], rel=1e-13)
    assert model.log_prior(eta) == pytest.approx(
        [model.log_prior(eta[i : i + 1])[0] for i in range(5)], rel=1e-13
    )


@every_model
@pytest.mark.parametrize("n", [7, 1000, 1003])
@pytest.mark.parametrize("far", [5.0, 1e40])
def test_the_total_is_the_sum_of_the_densities(model, n, far):
    """Also where a product of many factors would overflow."""
    rng = np.random.default_rng(2)
    log_sigma, eta = places(model, rng, 5)
    residual, sd = rng.normal(0, 5, (5, n)), rng.uniform(0.5, 2, n)
    residual[:, 3:5] *= far
    for own in (None, sd):
        density = model.log_density(residual, log_sigma, eta, own)
        found = model.total(residual, log_sigma, eta, own)
        scale = np.abs(density).sum(axis=1)
        assert (np.abs(found - density.sum(axis=1)) <= 1e-14 * scale).all()


@every_model
def test_what_is_simulated_is_what_is_scored(model):
    """Kolmogorov-Smirnov of 20 000 simulated residuals against the integrated density."""
    rng = np.random.default_rng(3)
    log_sigma, eta = places(model, rng, 1)
    sd = np.array([1.0, 3.0])
    drawn = model.draw(rng, np.repeat(log_sigma, 20_000), np.repeat(eta, 20_000, axis=0), sd)
    assert drawn.shape == (20_000, 2)
    for j, own in enumerate(sd):
        u = np.linspace(-60, 60, 200_001)  # a t of nu below 1 is found 1e20 sigma out
        log_density = model.log_density(np.sinh(u)[None], log_sigma, eta, np.full(len(u), own))
        density = np.exp(log_density[0]) * np.cosh(u)
        below = integrate.cumulative_simpson(density, x=u, initial=0)
        p = stats.kstest(np.interp(np.arcsinh(drawn[:, j]), u, below), "uniform").pvalue
        assert p > 1e-4
        # The test can fail: residuals 30 % too wide are noticed.
        wide = np.interp(np.arcsinh(1.3 * drawn[:, j]), u, below)
        assert stats.kstest(wide, "uniform").pvalue < 1e-4


@every_model
def test_posteriors_of_what_is_simulated_are_calibrated(model):
    """Simulation-based calibration of eta and ln sigma: truths from the prior have uniform ranks.

    The posterior of 8 residuals is the prior's draws, weighted by the likelihood.
    """
    rng = np.random.default_rng(7)
    pool, sets, points = 6_000, 512, 8
    eta = rng.normal(1.0, 1.8, (pool, model.dimension))  # over the prior of every coordinate
    log_sigma = rng.uniform(0, 3, pool)
    log_q = stats.norm(1.0, 1.8).logpdf(eta).sum(axis=1)
    prior = softmax(model.log_prior(eta) - log_q)
    assert 1 / (prior @ prior) > 300
    truths, sd = rng.choice(pool, sets, p=prior), np.ones(points)
    quantities = np.column_stack([log_sigma, eta])
    ranks, shrunk = [], []
    for truth in truths:
        residual = model.draw(rng, log_sigma[[truth]], eta[[truth]], sd)
        log_likelihood = model.log_density(residual, log_sigma, eta).sum(axis=1)
        posterior = prior * np.exp(log_likelihood - log_likelihood.max())
        posterior[truth] = 0  # a draw of the prior that the truth is none of
        draws = quantities[rng.choice(pool, DRAWS, p=posterior / posterior.sum())]
        ranks.append((draws < quantities[truth]).sum(axis=0))
        narrow = draws.mean(axis=0) + 0.7 * (draws - draws.mean(axis=0))
        shrunk.append((narrow < quantities[truth]).sum(axis=0))
    assert p_values(np.array(ranks), 16).min() > 1e-4
    # The test can fail: deviations 30 % too small are noticed.
    assert p_values(np.array(shrunk), 16).max() < 1e-4


@every_model
def test_starts_and_reports_have_the_shapes_they_are_declared_with(model):
    starts = model.starts()
    assert starts.shape == (len(starts), model.dimension)
    assert len(starts) >= 1
    assert model.report(starts).shape == (len(starts), len(model.parameters))
    assert np.isfinite(model.report(starts)).all()


@every_model
def test_places_far_out_have_a_log_density_that_is_a_number(model):
    eta = np.full((2, model.dimension), 300.0) * np.array([[-1.0], [1.0]])
    for log_sigma in (-40.0, 40.0):
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            found = model.log_density(np.array([[0.0, 1e4]] * 2), np.full(2, log_sigma), eta)
            prior = model.log_prior(eta)
        assert not np.isnan(found).any()
        assert (found < np.inf).all()
        assert (prior < -100).all() or model.dimension == 0


@every_model
def test_weight_is_the_share_of_precision_that_a_small_step_of_the_residual_feels(model):
    """Identity: the score of any scale mixture of normals is -residual times its precision.

    With an offset the mixture is no longer centred, and the identity holds at zero offset.
    """
    rng = np.random.default_rng(4)
    log_sigma, eta = places(model, rng, 3)
    if model.dimension == 3:
        eta[:, 2] = 0
    residual, h = rng.normal(0, 8, (3, 6)), 1e-5
    score = (
        model.log_density(residual + h, log_sigma, eta)
        - model.log_density(residual - h, log_sigma, eta)
    ) / (2 * h)
    precision = -score / residual * np.exp(2 * log_sigma)[:, None]
    assert model.weight(residual, log_sigma, eta) == pytest.approx(precision, rel=1e-5, abs=1e-7)


def test_student_t_is_scipys():
    rng = np.random.default_rng(5)
    residual, log_sigma = rng.normal(0, 9, (4, 3)), rng.normal(1, 0.3, 4)
    nu, sd = np.array([0.7, 3.0, 30.0, 1e5]), np.array([1.0, 2.0, 0.3])
    truth = stats.t.logpdf(residual, nu[:, None], scale=np.exp(log_sigma)[:, None] * sd)
    found = StudentT().log_density(residual, log_sigma, np.log(nu)[:, None], sd)
    # scipy's own constant, a difference of two gammas, has lost 1e-11 at nu = 1e5.
    assert found == pytest.approx(truth, rel=1e-10)


def test_student_t_of_very_large_nu_is_gaussian_to_rounding():
    """|difference| is below (z^4 + 2 z^2 + 1) / nu; here z is at most 30."""
    z = np.linspace(-30, 30, 61)[None]
    none = np.empty((1, 0))
    found = StudentT(1e10).log_density(z, np.zeros(1), none)
    assert found == pytest.approx(Gaussian().log_density(z, np.zeros(1), none), abs=1e-4)
    near = np.abs(z) < 3
    exact = Gaussian().log_density(z, np.zeros(1), none)
    assert found[near] == pytest.approx(exact[near], abs=1e-8)


def test_prior_of_nu_is_gamma_2_with_mean_20():
    eta = np.linspace(-3, 5, 9)[:, None]
    truth = stats.gamma(2, scale=10).logpdf(np.exp(eta[:, 0])) + eta[:, 0]
    assert StudentT().log_prior(eta) == pytest.approx(truth, rel=1e-13)


def test_prior_of_the_mixture_is_uniform_log_uniform_and_as_wide_as_the_bad():
    """Quantiles: probits of equal steps become equal steps of f and of ln width."""
    model = OutlierMixture(infers_offset=True)
    share = np.linspace(0.1, 0.9, 9)
    probit = stats.norm.ppf(share)
    found = model.report(np.column_stack([probit, probit, probit]))
    assert found[:, 0] == pytest.approx(share / 2)
    assert found[:, 1] == pytest.approx(stats.loguniform(5, 1000).ppf(share))
    assert found[:, 2] == pytest.approx(stats.norm.ppf(share, scale=found[:, 1]))
    assert model.parameters == ("bad_fraction", "bad_width", "bad_offset")


def test_mixture_is_the_sum_of_two_normals_and_its_labels_follow_bayes_rule():
    rng = np.random.default_rng(6)
    model = OutlierMixture(infers_offset=True)
    log_sigma, eta = places(model, rng, 4)
    residual, sd = rng.normal(0, 30, (4, 5)), rng.uniform(0.5, 2, 5)
    fraction, width, offset = (v[:, None] for v in model.report(eta).T)
    scale = np.exp(log_sigma)[:, None] * sd
    good = (1 - fraction) * stats.norm.pdf(residual, scale=scale)
    bad = fraction * stats.norm.pdf(residual, offset, np.hypot(scale, width))
    found = model.log_density(residual, log_sigma, eta, sd)
    assert found == pytest.approx(np.log(good + bad), rel=1e-12)
    labels = model.bad_probability(residual, log_sigma, eta, sd)
    assert labels == pytest.approx(bad / (good + bad), rel=1e-11)


def test_only_the_mixture_knows_bad_points():
    z, none = np.ones((1, 3)), np.empty((1, 0))
    assert Gaussian().bad_probability(z, np.zeros(1), none) is None
    assert StudentT(3.0).bad_probability(z, np.zeros(1), none) is None


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"name": "laplace"}, "noise must be gaussian, student-t, outlier-mixture, not 'laplace'"),
        ({"nu": 3.0}, "nu belongs to student-t noise; the noise here is gaussian"),
        ({"name": "student-t", "nu": 0.0}, "nu must be from 0.1 to 1e+10, not 0"),
        ({"name": "student-t", "nu": math.nan}, "nu must be from 0.1 to 1e+10, not nan"),
        ({"name": "student-t", "bad_offset": True}, "a bad offset belongs to outlier-mixture"),
    ],
)
def test_options_that_do_not_belong_together_are_refused(options, words):
    with pytest.raises(InputError, match=r"^" + words.replace("+", r"\+")):
        NoiseChoice(**options)
