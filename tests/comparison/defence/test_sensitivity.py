"""Evidence over fixed tau against models with tau fixed, and against their average.

The truth at one tau is the exact posterior of `make_model(tau=...)`, the `--tau` of the
command line: the same evidence to 1e-6 nat.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import logsumexp

from bayescal.comparison.defence.sensitivity import tau_sensitivity
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.evidence import log_evidence_over_tau
from tests.helpers.brute_force import normal_grid, panels
from tests.helpers.cases import curve
from tests.helpers.problems import AXES, ORDERS, THESIS_MODELS, make_axis, make_model, thesis_axis


def models(data, orders=ORDERS, **options):
    return {k: make_model(data, k, **options) for k in orders}


def fixed(data, order: int, tau: float, **options) -> float:
    """Log evidence with tau fixed."""
    return exact_posterior(make_model(data, order, tau=tau, **options)).log_evidence


@pytest.fixture(scope="module", params=AXES)
def thesis(request):
    """An axis of the thesis and its sensitivity."""
    data = thesis_axis(request.param)
    return request.param, data, tau_sensitivity(models(data))


def test_evidence_at_fixed_tau_equals_the_curve(thesis):
    _, data, found = thesis
    for i in range(0, len(found.tau), 12):
        for row, order in zip(found.log_evidence, found.orders, strict=True):
            truth = fixed(data, order, float(found.tau[i]))
            assert row[i] == pytest.approx(truth, abs=1e-6)


@pytest.mark.parametrize("sigma", [None, 3.0])
def test_normal_equations_equal_the_curve(sigma):
    """Another algebra and quadrature, at three tau."""
    data = thesis_axis("r")
    model = make_model(data, 3, sigma=sigma)
    log_tau = np.log([0.001, 0.02, 1.0])
    found = log_evidence_over_tau(model.reduced, model.noise, model.prior, log_tau)
    for value, tau in zip(found, np.exp(log_tau), strict=True):
        grid = normal_grid(make_model(data, 3, sigma=sigma, tau=float(tau)), data)
        assert value == pytest.approx(grid.log_evidence, abs=1e-6)


def test_range_and_probabilities_are_what_they_say(thesis):
    """tau from 0.01 px to the image, 60 steps a decade; softmax of the evidences, by order."""
    _, data, found = thesis
    assert (found.tau[0], found.tau[-1]) == pytest.approx((0.01 / data.size, 1.0), rel=1e-12)
    steps = np.diff(np.log10(found.tau))
    np.testing.assert_allclose(steps[1:], 1 / 60, rtol=1e-9)
    assert 0 < steps[0] <= 1 / 60
    np.testing.assert_allclose(found.probability.sum(axis=0), 1, rtol=1e-12)
    shifted = np.exp(found.log_evidence - found.log_evidence.max(axis=0))
    np.testing.assert_allclose(found.probability, shifted / shifted.sum(axis=0), rtol=1e-12)


@pytest.mark.parametrize(("axis", "order"), THESIS_MODELS)
def test_log_evidence_equals_the_average_over_the_prior_of_tau(axis, order):
    """Gauss-Legendre panels over ln tau from 0.01 px to half the image, density uniform."""
    model = make_model(thesis_axis(axis), order)
    size = {"r": 1920, "c": 1080}[axis]
    log_tau, weight = panels(math.log(0.01 / size), math.log(0.5), 0.4)
    values = log_evidence_over_tau(model.reduced, model.noise, model.prior, log_tau)
    average = logsumexp(values, b=weight / math.log(50 * size))
    assert average == pytest.approx(exact_posterior(model).log_evidence, abs=1e-6)


def test_thesis_winners_by_tau():
    """Order 4 of r, order 1 of c wherever tau leaves more than noise: from 1.3 px on."""
    r = tau_sensitivity(models(thesis_axis("r"))).wins
    assert (r[-1].order, r[-1].upper) == (4, pytest.approx(1.0))
    assert 1920 * r[-1].lower == pytest.approx(1.3, abs=0.1)
    c = tau_sensitivity(models(thesis_axis("c"))).wins
    assert (c[-1].order, c[-1].upper) == (1, pytest.approx(1.0))
    assert 1080 * c[-1].lower == pytest.approx(1.3, abs=0.1)


def check_wins(data, found, **options) -> None:
    """Wins tile the range; at each border the two evidences cross, inside each the winner leads.

    A root between two nodes a step h = ln(10) / 60 apart, found by linear
    interpolation, is off by at most h^2 / 8 times the difference's curvature over its
    slope: 1e-3 in ln tau allows a ratio of 2.4.
    """
    wins = found.wins
    assert wins[0].lower == pytest.approx(0.01 / data.size)
    assert wins[-1].upper == pytest.approx(1.0)
    for one, other in itertools.pairwise(wins):
        assert one.upper == other.lower
        assert one.order != other.order

        def lead(log_tau, one=one, other=other):
            tau = math.exp(log_tau)
            return fixed(data, one.order, tau, **options) - fixed(data, other.order, tau, **options)

        border = math.log(one.upper)
        assert border == pytest.approx(brentq(lead, border - 0.06, border + 0.06), abs=1e-3)
    for win in wins:
        middle = math.sqrt(win.lower * win.upper)
        leads = {k: fixed(data, k, middle, **options) for k in found.orders}
        assert max(leads, key=leads.get) == win.order


def test_evidences_cross_at_the_borders_of_the_thesis(thesis):
    _, data, found = thesis
    check_wins(data, found)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sigma", [None, 2.0])
def test_evidences_cross_at_the_borders_of_weak_curves(seed, sigma):
    """b_2 = 3 px and b_3 = 2 px under 2 px of noise: several winners."""
    data = curve(30, [480, 300, 3, 2], 2.0, seed)
    found = tau_sensitivity(models(data, (1, 2, 3), sigma=sigma))
    check_wins(data, found, sigma=sigma)


def test_borders_of_three_winners():
    """More than one border at once: the case is what it says, and each is a crossing."""
    counts = []
    for seed in range(12):
        data = curve(25, [480, 300, 2.5, 2.5], 2.0, seed)
        found = tau_sensitivity(models(data, (1, 2, 3)))
        counts.append(len(found.wins))
        if counts[-1] >= 3:
            check_wins(data, found)
    assert max(counts) >= 3


def test_a_straight_line_does_not_depend_on_tau():
    """Closed form: order 1 has no scaled amplitude."""
    data = thesis_axis("r")
    found = tau_sensitivity(models(data, (1, 2)))
    assert np.ptp(found.log_evidence[0]) == 0
    truth = exact_posterior(make_model(data, 1)).log_evidence
    assert found.log_evidence[0, 0] == pytest.approx(truth, abs=1e-7)


def test_a_fixed_tau_does_not_change_the_curve():
    """The curve is over all tau, whichever the verdict was taken at."""
    data = thesis_axis("c")
    one = tau_sensitivity(models(data, (1, 3)))
    other = tau_sensitivity(models(data, (1, 3), tau=0.05))
    np.testing.assert_allclose(one.log_evidence, other.log_evidence, atol=1e-7)


def test_wins_scale_with_the_image():
    """Closed form: pixels, sigma and image ten times larger leave every border where it was."""
    data = curve(30, [480, 300, 3, 2], 2.0, 1)
    large = make_axis(data.x, 10 * data.t, 10 * data.size)
    small = tau_sensitivity(models(data, (1, 2, 3), sigma=2.0)).wins
    scaled = tau_sensitivity(models(large, (1, 2, 3), sigma=20.0)).wins
    assert [w.order for w in small] == [w.order for w in scaled]
    borders = [[w.upper for w in wins] for wins in (small, scaled)]
    assert borders[0] == pytest.approx(borders[1], rel=1e-3)  # the grids start at 0.01 px each
