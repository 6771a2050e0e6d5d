"""What the data alone say of a camera, against least squares and the trace of its hat matrix."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.prediction.calibrated.members import Estimate
from tests.helpers.cameras import turned_points
from tests.helpers.cases import camera_points


def pixel_variances(member, estimate: Estimate, world) -> np.ndarray:
    """Sampling variances of predicted pixels, by one-sd steps, ``(n, 2)``, px^2."""
    up, _ = member.project(estimate.value + estimate.root.T, world)
    down, _ = member.project(estimate.value - estimate.root.T, world)
    return (((up - down) / 2) ** 2).sum(axis=0)


@pytest.mark.parametrize("tau", [1e-3, 0.05])
def test_a_polynomial_is_least_squares_whatever_the_prior_is(tau):
    """Truth: numpy's own least squares; variances of predictions sum to p sigma^2."""
    points = camera_points(40, (960.0, 700.0, 3.0), noise=1.0, seed=3)
    camera = bc.camera(bc.fit_family(points, "separable", (3, 2), tau=tau))
    member, ratios = camera.chosen, points.world[:, :2] / points.world[:, 2:]
    pixels, _ = member.project(member.estimate.value[None], points.world)
    plain = camera.recorded(pixels[0])
    variances = pixel_variances(member, member.estimate, points.world)
    for axis, order in ((0, 3), (1, 2)):
        t = points.pixels[:, axis]
        design = np.polynomial.legendre.legvander(ratios[:, axis], order)
        fitted = design @ np.linalg.lstsq(design, t)[0]
        np.testing.assert_allclose(plain[:, axis], fitted, atol=1e-8)
        # A prior that shrinks the curvature takes it for noise, so that sigma is a little larger.
        rss = ((t - fitted) ** 2).sum()
        ratio = variances[:, axis].sum() / ((order + 1) * rss / (40 - order - 1))
        assert 0.95 < ratio < 1.3
        assert member.estimate.levels[axis][1] == pytest.approx(40 - order - 1, abs=order)


def test_a_pinhole_is_of_maximum_likelihood():
    """Truth: the hat matrix has trace p; no step of a tenth of a sd lessens the residuals."""
    points = turned_points(0.3)
    result = bc.fit_family(points, "pinhole", (1,), ess=100)
    member = bc.camera(result).chosen
    estimate, n = member.estimate, len(points.world)
    pixels, _ = member.project(estimate.value[None], points.world)
    squares = ((points.pixels - pixels[0]) ** 2).sum(axis=0)
    variances = pixel_variances(member, estimate, points.world)
    p = 11
    total = (variances.sum(axis=0) / (squares / n)).sum()
    assert total == pytest.approx(p * 2 * n / (2 * n - p), rel=1e-3)
    weight = n / squares
    steps = estimate.value + 0.1 * np.concatenate([estimate.root.T, -estimate.root.T])
    moved, _ = member.project(steps, points.world)
    misfit = (((points.pixels - moved) ** 2).sum(axis=1) * weight).sum(axis=1)
    assert (misfit > 2 * n).all()


def test_a_lens_of_many_views_has_nearly_its_posterior(lens_comparison):
    """Truth: where coefficients are known far better than beforehand the prior says nothing."""
    member = bc.camera(lens_comparison).chosen
    estimate, n = member.estimate, len(member.estimate.value)
    posterior = member.parameters.draws[:, :n]
    sd = posterior.std(axis=0)
    assert (np.abs(estimate.value - posterior.mean(axis=0)) < 0.3 * sd).all()
    np.testing.assert_allclose(np.linalg.norm(estimate.root, axis=1), sd, rtol=0.15)


def test_levels_are_drawn_as_students_t():
    """Truth: variances dof / (dof - 2) of two levels of their own; correlation as of the root."""
    root = np.array([[1.0, 0, 0], [0.6, 0.8, 0], [0, 0, 2.0]])
    estimate = Estimate(np.zeros(3), root, ((2, 8.0), (1, np.inf)))
    rng = np.random.default_rng(0)
    draws = np.concatenate([estimate.parameters(rng).draws for _ in range(40)])
    covariance = np.cov(draws.T)
    expected = np.diag([8 / 6, 8 / 6, 4.0])
    expected[0, 1] = expected[1, 0] = 0.6 * 8 / 6
    np.testing.assert_allclose(covariance, expected, atol=4 * 4 * np.sqrt(3 / 40_000))
