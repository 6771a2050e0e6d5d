"""Where sigma comes from: replicates, a scale of known deviations, or stated.

Truths are textbook formulas written out here, simulated replicates of known sigma, and
scaling identities of the evidence.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial.legendre import legval
from scipy import stats
from scipy.special import logsumexp

import bayescal as bc
from bayescal.comparison.criteria.goodness import goodness_of_fit, reference_sigma
from bayescal.comparison.criteria.information import criteria
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.linear.replicates import pure_error
from bayescal.noise.level import NoiseLevel
from bayescal.report.terminal import render
from bayescal.report.views.comparison import full
from tests.helpers.cases import HEIGHT, WIDTH, camera_points, printed, result_document
from tests.helpers.problems import field_rule, legendre_columns, make_axis, thesis_axis

PLACES, REPEATS = 8, 4


def replicated(noise=1.5, seed=0, *, jitter=0.0, both=True, **columns) -> bc.Correspondences:
    """Eight places seen four times each: r a parabola of x/z, c a straight line of y/z.

    `jitter` moves each reading's x/z by that fraction of the domain; with `both` false
    y/z differs within a place, so that there are no true replicates.
    """
    rng = np.random.default_rng(seed)
    n = PLACES * REPEATS
    s = np.repeat(np.linspace(-1, 1, PLACES), REPEATS)
    other = np.repeat(rng.uniform(-0.3, 0.3, PLACES), REPEATS)
    if not both:
        other = rng.uniform(-0.3, 0.3, n)
    moved = 0.6 * s + 1.2 * jitter * rng.uniform(-0.5, 0.5, n)
    r = legval(s, [960, 700, 8]) + noise * rng.standard_normal(n)
    c = 540 + 1000 * other + noise * rng.standard_normal(n)
    z = 128.0  # a power of 2, so that x/z is what was meant
    return bc.Correspondences.from_arrays(
        np.column_stack([moved * z, other * z, np.full(n, z)]),
        np.column_stack([r, c]),
        setup=bc.Setup(width=WIDTH, height=HEIGHT),
        **columns,
    )


def compared(points, orders=(1, 2), **options):
    return bc.compare(points, orders, axis="r", ess=100, **options)


def pooled(t: np.ndarray) -> tuple[float, int]:
    """Pooled standard deviation within places, and its degrees of freedom."""
    cells = t.reshape(PLACES, REPEATS)
    rss = ((cells - cells.mean(axis=1, keepdims=True)) ** 2).sum()
    dof = PLACES * (REPEATS - 1)
    return math.sqrt(rss / dof), dof


def test_sigma_from_replicates_equals_the_pooled_sd():
    points = replicated()
    sigma, dof = pooled(points.pixels[:, 0])
    axis = compared(points, sigma="replicates").axes["r"]
    assert axis.noise.value is None
    assert axis.noise.pure == pytest.approx(sigma, rel=1e-12)
    assert axis.noise.dof == dof == 24
    assert (axis.reference.source, axis.reference.dof) == ("replicates", 24)
    assert axis.reference.value == pytest.approx(sigma, rel=1e-12)
    assert axis.noise_source.startswith(f"{sigma:.3g} px, from replicates (24 dof)")


@pytest.mark.parametrize("repeats", [2, 4])
def test_replicates_carry_the_uncertainty_of_their_spread(repeats):
    """Truth: the places' means under a scaled inverse chi-squared prior of sigma, brute force.

    ln B of two orders, by the dense normal of the means, sigma integrated over that prior.
    """
    points = replicated()
    t = points.pixels[:, 0].reshape(PLACES, REPEATS)[:, :repeats]
    rows = np.arange(PLACES * REPEATS).reshape(PLACES, REPEATS)[:, :repeats].ravel()
    fewer = bc.Correspondences.from_arrays(
        points.world[rows], points.pixels[rows], setup=points.setup
    )
    axis = bc.compare(fewer, (1, 2), axis="r", sigma="replicates", tau=0.01, ess=100).axes["r"]
    dof = PLACES * (repeats - 1)
    s2 = ((t - t.mean(axis=1, keepdims=True)) ** 2).sum() / dof
    s = np.linspace(-1, 1, PLACES)
    log_sigma = np.linspace(np.log(s2) / 2 - 8, np.log(s2) / 2 + 8, 6001)
    size, logs = axis.data.size, []
    for order in (1, 2):
        x = np.polynomial.legendre.legvander(s, order)
        sd = np.array([size / 2, size / 2, *[0.01 * size] * (order - 1)])
        spread, vectors = np.linalg.eigh((x * sd**2) @ x.T)
        misfit = vectors.T @ (t.mean(axis=1) - size / 2)
        variance = spread[:, None] + np.exp(2 * log_sigma) / repeats
        means = -(np.log(variance) + misfit[:, None] ** 2 / variance).sum(axis=0) / 2
        # ln of sigma^-dof exp(-dof s^2 / 2 sigma^2), but for a constant.
        prior = -dof * log_sigma - dof * s2 * np.exp(-2 * log_sigma) / 2
        logs.append(logsumexp(means + prior))
    found = axis[2].log_evidence - axis[1].log_evidence
    assert found == pytest.approx(logs[1] - logs[0], abs=1e-5)


def test_true_sigma_equals_that_from_replicates_on_average():
    """400 sets: sigma^2 dof / truth^2 is chi2 of 24 dof, within 4 standard errors."""
    found = []
    for seed in range(400):
        points = replicated(seed=seed)
        x, other = np.repeat(np.arange(PLACES), REPEATS), np.zeros(PLACES * REPEATS)
        found.append(pure_error(x.astype(float), other, points.pixels[:, 0])[0] ** 2 / 1.5**2)
    assert np.mean(found) == pytest.approx(1, abs=4 * math.sqrt(2 / 24 / 400))


def test_sigma_of_replicates_is_not_counted_as_a_parameter():
    """K = p, chi2 with the replicates' sigma, no AICc, and lnL at that sigma."""
    points = replicated()
    sigma, _ = pooled(points.pixels[:, 0])
    for result in compared(points, sigma="replicates").axes["r"].orders:
        chi2 = result.fit.rss / sigma**2
        assert result.goodness.chi2 == pytest.approx(chi2, rel=1e-12)
        assert result.criteria.n_parameters == result.order + 1
        assert result.criteria.aicc is None
        lnl = -chi2 / 2 - 32 * math.log(sigma) - 16 * math.log(2 * math.pi)
        assert result.criteria.log_likelihood == pytest.approx(lnl, rel=1e-12)


@pytest.mark.parametrize("sigma", [None, "replicates"])
def test_textbook_lack_of_fit_equals_p_f_where_there_are_replicates(sigma):
    """Draper & Smith 1998, 2.1: F = [(RSS - SSPE) / (m - p)] / [SSPE / (n - m)]; p chi2 blank."""
    points = replicated()
    t = points.pixels[:, 0]
    cells = t.reshape(PLACES, REPEATS)
    pure = ((cells - cells.mean(axis=1, keepdims=True)) ** 2).sum()
    s = np.repeat(np.linspace(-1, 1, PLACES), REPEATS)
    result = compared(points, (1, 2), sigma=sigma)
    for order in (1, 2):
        rss = ((t - np.polyval(np.polyfit(s, t, order), s)) ** 2).sum()
        f = (rss - pure) / (PLACES - order - 1) / (pure / 24)
        good = result.axes["r"][order].goodness
        assert good.f_p_value == pytest.approx(stats.f.sf(f, PLACES - order - 1, 24), rel=1e-6)
        assert good.p_value is None
        assert good.p_value_lower is None
        assert good.chi2_reduced == pytest.approx(rss / (pure / 24) / (32 - order - 1), rel=1e-9)
    assert "from replicates (24 dof); p F: lack of fit against them" in printed(result)


def test_lack_of_fit_is_uniform_at_the_true_order():
    """200 sets of a true parabola: Kolmogorov's distance below its 0.1 % point."""
    p = []
    for seed in range(200):
        points = replicated(seed=seed)
        data = make_axis(points.world[:, 0] / 128, points.pixels[:, 0])
        fit = solve(factorise(data, 2), 2)
        pure = pure_error(data.x, None, data.t)
        reference = reference_sigma(NoiseLevel.inferred(), fit, pure)
        p.append(goodness_of_fit(fit, fit, reference).f_p_value)
    assert stats.kstest(p, "uniform").pvalue > 1e-3


@pytest.mark.parametrize(
    ("points", "why"),
    [
        (replicated(both=False), "no two points share every regressor"),
        (replicated(jitter=1e-6), "no two points share every regressor"),
        (replicated(noise=0.0), "do not differ"),
        (bc.thesis(), "no two points share every regressor"),
    ],
)
def test_replicates_that_do_not_exist_are_refused_in_one_line(points, why):
    with pytest.raises(bc.InputError) as error:
        compared(points, sigma="replicates")
    message = str(error.value)
    assert why in message
    assert "axis r" in message
    assert "\n" not in message


def test_regressors_within_a_billionth_of_the_domain_are_replicates():
    axis = compared(replicated(jitter=1e-10), sigma="replicates").axes["r"]
    assert axis.noise.dof == 24


def test_the_fit_of_replicated_points_does_not_call_chi2_its_own():
    """chi2/dof against replicates is not 1 by construction, so it must not be said to be."""
    text = render(full(bc.fit(replicated(), 1, ess=100)), terminal=False)
    assert "taken from the same residuals" not in text


def test_known_sigma_alone_has_p_values_of_chi2():
    """Known: both tails of chi2. Inferred and scale: blank, in table and document."""
    points = camera_points(30, sigma_r=np.full(30, 1.0), sigma_c=np.full(30, 1.0))
    known = compared(points).axes["r"][1].goodness
    assert known.p_value == pytest.approx(stats.chi2.sf(known.chi2, 28), rel=1e-9)
    assert known.p_value_lower == pytest.approx(stats.chi2.cdf(known.chi2, 28), rel=1e-9)
    for sigma in ("inferred", "scale"):
        result = compared(points, sigma=sigma)
        for order in result_document(result)["axes"]["r"]["orders"]:
            assert order["p_value"] is None
            assert order["p_value_lower"] is None
        assert "p chi2" not in printed(result)


@pytest.mark.parametrize("factor", [0.2, 3.0])
def test_true_factor_equals_the_inferred_scale(factor):
    """sd stated 1/factor of the truth: the posterior covers it within 4 of its sds."""
    sd = np.random.default_rng(3).uniform(0.5, 2, 200)
    s = np.linspace(-1, 1, 200)
    t = 500 + 300 * s + factor * sd * np.random.default_rng(4).standard_normal(200)
    data = make_axis(s, t, sd=sd)
    model = LinearModel(
        factorise(data, 1), 1, NoiseLevel.scale(), field_rule(data).of_order(1), "alpha"
    )
    exact = exact_posterior(model)
    assert model.names[-1] == "scale"
    mean, spread = exact.summary[0][-1], exact.summary[1][-1]
    assert spread == pytest.approx(factor / math.sqrt(400), rel=0.1)
    assert mean == pytest.approx(factor, abs=4 * spread)


def test_a_scale_counts_as_a_parameter():
    """K = p + 1 and -2 lnL = n [ln(2 pi RSS / n) + 1] + 2 sum ln sd_i (weighted RSS)."""
    sd = np.random.default_rng(3).uniform(0.5, 2, 30)
    points = camera_points(30, sigma_r=sd, sigma_c=sd)
    axis = compared(points, sigma="scale").axes["r"]
    assert axis.noise.source == "scale"
    weight = 1 / sd
    for result in axis.orders:
        x = legendre_columns(axis.data, result.order) * weight[:, None]
        rss = float(np.linalg.lstsq(x, axis.data.t * weight, rcond=None)[1][0])
        k = result.order + 2
        lnl = -15 * (math.log(2 * math.pi * rss / 30) + 1) - np.log(sd).sum()
        assert result.criteria.n_parameters == k
        assert result.criteria.log_likelihood == pytest.approx(lnl, rel=1e-10)
        aicc = -2 * lnl + 2 * k + 2 * k * (k + 1) / (30 - k - 1)
        assert result.criteria.aicc == pytest.approx(aicc, rel=1e-10)


def integral(data, order: int, noise: NoiseLevel) -> float:
    prior = field_rule(data).of_order(order)
    return exact_posterior(LinearModel(factorise(data, order), order, noise, prior)).log_integral


@pytest.mark.parametrize("order", [1, 4])
def test_inferred_sigma_equals_the_scale_of_equal_deviations(order):
    """sd = 2 px throughout times [0.01, 100] is sigma in [0.02, 200] px."""
    data = thesis_axis("r")
    same = make_axis(data.x, data.t, data.size, sd=np.full(len(data), 2.0))
    plain = make_axis(data.x, data.t, data.size)
    truth = integral(plain, order, NoiseLevel.inferred((0.02, 200.0)))
    assert integral(same, order, NoiseLevel.scale()) == pytest.approx(truth, abs=1e-7)
    k = criteria(solve(factorise(same, order), order), NoiseLevel.scale(), 57, 57 * math.log(2))
    own = criteria(solve(factorise(plain, order), order), NoiseLevel.inferred(), 57)
    assert k.log_likelihood == pytest.approx(own.log_likelihood, rel=1e-12)


@pytest.mark.parametrize("factor", [0.3, 7.0])
def test_deviations_in_another_unit_leave_the_evidence_alone(factor):
    """ln scale is uniform: sd times a factor moves the scale, not the evidence.

    What the bounds cut off is below 1e-12 of the probability.
    """
    data = thesis_axis("r")
    sd = np.random.default_rng(5).uniform(1, 4, len(data))
    one, other = (make_axis(data.x, data.t, data.size, sd=f * sd) for f in (1.0, factor))
    level = NoiseLevel.scale()
    assert integral(other, 3, level) == pytest.approx(integral(one, 3, level), abs=1e-7)


def test_a_scale_without_deviations_is_refused_in_one_line():
    with pytest.raises(bc.InputError, match="sigma_r") as error:
        compared(camera_points(20), sigma="scale")
    assert "\n" not in str(error.value)


def test_a_scale_is_a_factor_in_print_and_document():
    """Its bounds and its posterior are no pixels, and the document holds the posterior."""
    points = camera_points(30, sigma_r=np.full(30, 2.0), sigma_c=np.full(30, 2.0))
    result = compared(points, sigma="scale")
    noise = next(line for line in printed(result).split("  prior:")[0].split("noise:")[1:])
    assert "100 px" not in " ".join(noise.split())
    order = result_document(result)["axes"]["r"]["orders"][0]
    found = order.get("scale") or order["sigma"]
    assert found["mean"] == pytest.approx(0.5, abs=0.2)


@pytest.mark.parametrize("kind", [float, np.float64, np.float32, np.int64, int])
def test_a_number_of_any_kind_is_a_known_sigma(kind):
    """2 px, from whatever numpy computed it with; never silently inferred."""
    axis = compared(camera_points(20), (1,), sigma=kind(2)).axes["r"]
    assert (axis.noise.source, axis.noise.value) == ("known", 2.0)
