"""Errors of the world coordinates carried to pixels: closed forms and coverage."""

import dataclasses

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

import bayescal as bc
from bayescal.comparison.choosing import noise_level, prior_rule
from bayescal.comparison.settings import Settings
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.errors.attenuation import attenuation, bent_by_errors
from bayescal.linear.errors.effective_variance import with_effective_deviations, world_errors
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import clenshaw_curtis
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.basis import legendre_design
from bayescal.polynomials.separable import axis_data

TRUTH = np.array([986.0, 1066.0, -23.0, -96.0, 203.0])  # px, near the thesis's r
PIXEL_SIGMA, WORLD_SIGMA, SETS = 0.5, 1.0, 700


@pytest.fixture(scope="module")
def thesis():
    return bc.thesis()


def simulated(thesis, rng):
    """Points whose pixels follow TRUTH at the true places, read with errors of 1 unit."""
    camera = thesis.camera_frame()
    pixel = np.polynomial.polynomial.polyval(camera[:, 0] / camera[:, 2], TRUTH)
    pixels = np.column_stack([pixel + rng.normal(0, PIXEL_SIGMA, 57), thesis.pixels[:, 1]])
    world = thesis.world + rng.normal(0, WORLD_SIGMA, (57, 3))
    setup = dataclasses.replace(thesis.setup, world_sigma=(WORLD_SIGMA,) * 3)
    return axis_data(bc.Correspondences.from_arrays(world, pixels, setup=setup), "r")


def covered(data):
    """Which coefficients' central 95 % intervals hold the truth, without sampling."""
    settings = Settings(sigma=PIXEL_SIGMA)
    data, level, *_ = noise_level(data, settings, None, 4)
    factors = factorise(data, 4)
    prior = prior_rule(data, settings, None).of_order(4)
    exact = exact_posterior(LinearModel(factors, 4, level, prior))
    low, high = exact.quantiles(factors.monomials.lead(4), np.array([0.025, 0.975])).T
    return (low < TRUTH) & (high > TRUTH)


def test_intervals_cover_the_truth_where_plain_pixel_noise_fails(thesis):
    """95 % within 4 binomial standard errors for each coefficient; control: no world errors."""
    rng = np.random.default_rng(4)
    with_errors, plain = [], []
    for i in range(SETS):
        data = simulated(thesis, rng)
        with_errors.append(covered(data))
        if i % 10 == 0:
            plain.append(covered(dataclasses.replace(data, x_sd=None)))
    error = np.sqrt(0.95 * 0.05 / SETS)
    assert (np.abs(np.mean(with_errors, axis=0) - 0.95) < 4 * error).all()
    assert (np.mean(plain, axis=0) < 0.7).all()


def test_a_straight_line_has_the_slope_itself(thesis):
    """Order 1: sd_i^2 = sigma^2 + slope^2 (sx^2/z^2 + x^2 sz^2/z^4), slope of the weighted fit."""
    setup = dataclasses.replace(thesis.setup, world_sigma=(0.5, 0.0, 2.0))
    data = axis_data(dataclasses.replace(thesis, setup=setup), "r")
    found, level, words, _ = noise_level(data, Settings(sigma=0.8), None, 1)
    x, _, z = thesis.camera_frame().T
    slope = np.polynomial.polynomial.polyfit(x / z, data.t, 1, w=1 / found.sd)[1]
    expected = np.sqrt(0.8**2 + slope**2 * (0.25 / z**2 + x**2 * 4 / z**4))
    np.testing.assert_allclose(found.sd, expected, rtol=1e-9)
    assert level.source == "known"
    assert "effective variances" in words


@pytest.mark.parametrize("error", [0.01, 0.05])
def test_slopes_are_attenuated_by_the_reliability_ratio(error):
    """Truth 1400 (w / 1 px) at depth 1: least squares finds it times var(w) / (var(w) + error²).

    At 0.01, 14 px, that is 0.08 % of the slope; at 0.05 it is 2 %, many of its standard errors.
    """
    rng, n = np.random.default_rng(1), 40_000
    x = rng.uniform(-0.6, 0.6, n)
    pixels = np.column_stack([960 + 1400 * x, np.zeros(n)]) + rng.normal(0, 0.5, (n, 2))
    world = np.column_stack([x + rng.normal(0, error, n), rng.uniform(-0.3, 0.3, n), np.ones(n)])
    setup = bc.Setup(width=1920.0, height=1080.0, world_sigma=(error, 0.0, 0.0))
    points = bc.Correspondences.from_arrays(world, pixels, setup=setup)
    data = noise_level(axis_data(points, "r"), Settings(sigma=0.5), None, 1).data
    factors = factorise(data, 1)
    fit = solve(factors, 1, 1.0)
    reliability = 0.12 / (0.12 + error**2)
    assert abs(fit.coefficients[1] - 1400 * reliability) < 4 * fit.standard_errors[1]
    attenuated = (1400 - fit.coefficients[1]) / fit.standard_errors[1]
    assert (attenuated > 10) == (error > 0.03)


def test_no_world_errors_leave_the_pixels_alone(thesis):
    setup = dataclasses.replace(thesis.setup, world_sigma=(0.0, 0.0, 0.0))
    data = axis_data(dataclasses.replace(thesis, setup=setup), "c")
    found, level, *_ = noise_level(data, Settings(sigma=0.8), None, 3)
    assert found.sd is None
    assert level.value == 0.8


def test_columns_go_before_the_setup(thesis):
    own = bc.Correspondences.from_arrays(
        thesis.world,
        thesis.pixels,
        sigma_x=np.full(57, 3.0),
        setup=dataclasses.replace(thesis.setup, world_sigma=(1.0, 1.0, 2.0)),
    )
    np.testing.assert_array_equal(own.world_sigma(), np.tile([3.0, 1.0, 2.0], (57, 1)))


def with_errors(thesis, *sigma):
    return dataclasses.replace(thesis, setup=dataclasses.replace(thesis.setup, world_sigma=sigma))


def by_quadrature(data, level, order, highest):
    """ln Z and the mean of sigma: the closed form at each sigma with its own weights."""
    lower, upper = level.log_bounds
    x, weights = clenshaw_curtis(257)
    nodes, weights = (lower + upper) / 2 + (upper - lower) / 2 * x, (upper - lower) / 2 * weights
    prior = prior_rule(data, Settings(), None).of_order(order)
    values = []
    for sigma in np.exp(nodes):
        weighted = with_effective_deviations(data, np.full(len(data), sigma), highest)
        factors = factorise(weighted, highest)
        model = LinearModel(factors, order, NoiseLevel.known(1.0), prior, data.symbol)
        values.append(exact_posterior(model).log_integral)
    joint = np.array(values) + level.log_prior()
    log_z = logsumexp(joint, b=weights)
    return log_z, float(weights * np.exp(joint - log_z) @ np.exp(nodes))


@pytest.mark.parametrize(("axis", "order"), [("r", 4), ("c", 1)])
def test_sigma_is_inferred_beside_world_errors(thesis, axis, order):
    """Evidence within 5 Monte Carlo errors and the grid's 0.002 nat; sigma within 5."""
    points = with_errors(thesis, 1.0, 1.0, 2.0)
    found = bc.compare(points, [order], axis=axis, hint=False)[axis]
    log_z, sigma = by_quadrature(axis_data(points, axis), found.noise, order, order)
    result = found[order]
    assert abs(result.log_evidence - log_z) < 5 * result.log_evidence_error + 0.002
    assert abs(result.posterior["sigma"].mean - sigma) < 5 * result.posterior["sigma"].mcse_mean
    assert "effective variances" in found.noise_source
    # Control: without the world's errors the same pixels have more noise and another evidence.
    plain = bc.compare(thesis, [order], axis=axis, hint=False)[axis][order]
    assert plain.posterior["sigma"].mean > sigma + 0.1
    assert abs(plain.log_evidence - log_z) > 0.5


def test_tiny_world_errors_leave_the_closed_form(thesis):
    """With errors of 1e-6 units the sampled evidence is that of the pixels alone."""
    plain = axis_data(thesis, "r")
    noise = world_errors(
        axis_data(with_errors(thesis, 1e-6, 1e-6, 1e-6), "r"), NoiseLevel.inferred(), 2
    )
    theta = np.log(np.array([0.5, 3.0]))
    residuals = np.linspace(-9, 9, 2 * len(plain)).reshape(2, -1)
    eta = np.empty((2, 0))
    np.testing.assert_allclose(
        noise.log_density(residuals, theta, eta),
        GAUSSIAN.log_density(residuals, theta, eta),
        rtol=0,
        atol=1e-6,
    )


def test_noise_beside_world_errors_is_a_normal_of_both(thesis):
    """On the grid: N(0, sigma^2 + slope^2 sd(x)^2), slope of the fit with that sigma."""
    data = axis_data(with_errors(thesis, 1.0, 1.0, 2.0), "c")
    level = NoiseLevel.inferred()
    noise = world_errors(data, level, 3)
    residuals = np.linspace(-5, 5, len(data))[None]
    for k in (5, 20, 40):
        sigma = np.exp(noise.log_sigma[k])
        sd = with_effective_deviations(data, np.full(len(data), sigma), 3).sd
        expected = stats.norm.logpdf(residuals, scale=sd)
        found = noise.log_density(residuals, noise.log_sigma[[k]], np.empty((1, 0)))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
        share = noise.weight(residuals, noise.log_sigma[[k]], np.empty((1, 0)))
        np.testing.assert_allclose(share[0], sigma**2 / sd**2, rtol=1e-9)


@pytest.mark.parametrize(
    "ask",
    [
        lambda points: bc.compare(points, [1], noise="student-t"),
        lambda points: bc.compare_families(points, ["separable"], [1]),
        lambda points: bc.fit_family(points, "pinhole", (0,)),
        lambda points: bc.outliers(points, [1]),
    ],
)
def test_where_sigma_can_not_be_inferred_beside_them_it_is_asked_for(thesis, ask):
    with pytest.raises(bc.InputError, match="add --sigma PX or a column sigma_r"):
        ask(with_errors(thesis, 1.0, 1.0, 1.0))


def test_the_readmes_setup_runs_with_default_settings_and_is_kept(thesis, tmp_path):
    result = bc.compare(with_errors(thesis, 1.0, 1.0, 2.0), [1, 4], axis="r", ess=400)
    bc.save_run(result, tmp_path / "run")
    again = bc.open_run(tmp_path / "run")
    assert again["r"].verdict.text == result["r"].verdict.text
    assert again["r"][4].log_evidence == result["r"][4].log_evidence
    assert again["r"].noise_model.name == "gaussian-world"


def test_what_errors_take_of_a_straight_line_is_the_reliability_ratio(thesis):
    """Truth: -slope s² / var(x) to second order, as Fuller's s² / (var(x) + s²) is."""
    data = axis_data(with_errors(thesis, 0.0, 0.0, 0.0), "r")
    data = dataclasses.replace(data, x_sd=np.full(57, 0.01))
    off, _ = bent_by_errors(data, np.full(57, 3.0), np.array([960.0, 700.0]))
    assert off[1] == pytest.approx(-700 * 0.01**2 / np.var(data.x), rel=1e-9)
    found = attenuation(data, np.full(57, 3.0), np.array([960.0, 700.0]))
    edge = abs(off[0] + off[1])  # where it is most, of all places
    assert abs(found.shift) >= edge * (1 - 1e-9)


@pytest.mark.parametrize("error", [2.0, 20.0])
def test_what_errors_take_of_a_curve_is_foretold(thesis, error):
    """Truth: the mean of 300 fits at measured places less the true curve, 4 standard errors."""
    rng, n = np.random.default_rng(int(error)), 57
    true = axis_data(thesis, "r").x
    sd, at = error / TRUTH[1], np.array([-0.55, -0.2, 0.3, 0.55])
    pixel, curve = (np.polynomial.polynomial.polyval(x, TRUTH) for x in (true, at))
    setup = bc.Setup(width=1920.0, height=1080.0, world_sigma=(sd, 0.0, 0.0))
    differences, foretold = [], []
    for _ in range(300):
        read = np.column_stack([true + rng.normal(0, sd, n), np.zeros(n), np.ones(n)])
        pixels = np.column_stack([pixel + rng.normal(0, PIXEL_SIGMA, n), np.zeros(n)])
        points = bc.Correspondences.from_arrays(read, pixels, setup=setup)
        data = noise_level(axis_data(points, "r"), Settings(sigma=PIXEL_SIGMA), None, 4).data
        fit = solve(factorise(data, 4), 4, 1.0)
        off, _ = bent_by_errors(data, data.sd, fit.amplitudes)
        shift = legendre_design(data.domain.scale(at), 4) @ off
        foretold.append(shift)
        differences.append(np.polynomial.polynomial.polyval(at, fit.coefficients) - curve - shift)
    error_of_mean = np.std(differences, axis=0) / np.sqrt(300)
    assert (np.abs(np.mean(differences, axis=0)) < 4 * error_of_mean).all()
    largest = np.abs(np.mean(foretold, axis=0)) / error_of_mean
    assert (largest.max() > 5) == (error > 5)  # control: without it the mean would be off
