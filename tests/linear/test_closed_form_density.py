"""Closed-form densities of parameters: against the summary, the normal, and the draws."""

from __future__ import annotations

import numpy as np
import pytest

from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.closed_form_density import Densities
from tests.helpers.problems import make_model, thesis_axis

PROBABILITIES = (1 - np.exp(-0.5), 1 - np.exp(-2.0))


@pytest.fixture(scope="module", params=[("r", 4), ("c", 2)], ids=lambda p: f"{p[0]}-{p[1]}")
def exact(request):
    axis, order = request.param
    return exact_posterior(make_model(thesis_axis(axis), order))


def test_marginals_of_coefficients_lie_between_their_quantiles(exact):
    densities, monomials = Densities(exact), exact.model.factors.monomials.lead(exact.model.order)
    probabilities = np.array([0.05, 0.3, 0.5, 0.8, 0.95])
    quantiles = exact.quantiles(monomials, probabilities)
    for name, places in zip(exact.model.names, quantiles, strict=False):
        x, density = densities.marginal(name)
        cumulative = np.concatenate([[0], np.cumsum(np.diff(x) * (density[1:] + density[:-1]) / 2)])
        found = np.interp(places, x, cumulative)
        # Straight lines between places 0.15 sd apart.
        np.testing.assert_allclose(np.diff(found), np.diff(probabilities), atol=2e-3)


def test_marginal_of_sigma_has_its_exact_moments(exact):
    mean, sd = (values[exact.model.size] for values in exact.summary)
    x, density = Densities(exact).marginal("sigma")
    # Straight lines between nodes up to h = 0.3 sd apart lose up to h^2 / 12 of an integral.
    total = np.trapezoid(density, x)
    assert total == pytest.approx(1, abs=0.0075)
    assert np.trapezoid(density * x, x) / total == pytest.approx(mean, abs=0.0075 * sd)
    second = np.trapezoid(density * (x - mean) ** 2, x) / total
    assert second == pytest.approx(sd**2, rel=0.03)


def test_joints_have_the_marginals_mass_and_centre(exact):
    names, densities = exact.model.names, Densities(exact)
    means = dict(zip(names, zip(*exact.summary, strict=True), strict=True))
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            surface = densities.joint(first, second)
            # Averaged over tau, the higher coefficients reach beyond 4.5 sd now and then.
            assert surface.mass.sum() == pytest.approx(1, abs=5e-3), (first, second)
            for name, values in ((first, surface.x), (second, surface.y)):
                if name != "tau":
                    mean, sd = means[name]
                    found = (surface.mass * values).sum() / surface.mass.sum()
                    assert found == pytest.approx(mean, abs=0.02 * sd), (first, second, name)


def test_thresholds_of_a_normal_are_its_own():
    """With sigma and tau known the posterior is normal: density falls by exp(-k^2 / 2)."""
    exact = exact_posterior(make_model(thesis_axis("r"), 3, sigma=3.0, tau=0.02))
    surface = Densities(exact).joint("alpha_1", "alpha_3")
    outer, inner = surface.thresholds(PROBABILITIES)
    monomials = exact.model.factors.monomials.lead(3)
    covariance = (monomials @ exact.covariance @ monomials.T)[np.ix_([1, 3], [1, 3])]
    peak = 1 / (2 * np.pi * np.sqrt(np.linalg.det(covariance)))
    assert surface.density.max() == pytest.approx(peak, rel=1e-9)
    # A step of the mesh is 0.15 sd: about 0.5 % of probability at either level.
    assert inner / peak == pytest.approx(np.exp(-0.5), abs=0.02)
    assert outer / peak == pytest.approx(np.exp(-2), abs=0.02)
    deltas = np.stack([surface.x, surface.y], -1) - exact.summary[0][[1, 3]]
    distance = np.einsum("...a,ab,...b->...", deltas, np.linalg.inv(covariance), deltas)
    np.testing.assert_allclose(surface.density, peak * np.exp(-distance / 2), rtol=1e-6)
