"""Evidence of a lens with the poses integrated out, against independent integrals."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from bayescal.arrays import Array
from bayescal.calibration.fitting.stacking import residuals
from bayescal.calibration.judging import laplace as laplace_module
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.evidence import proposal, settled, weighed
from bayescal.calibration.judging.laplace import (
    LOG_POSE,
    SIGMA_BOUNDS,
    Forms,
    Level,
    degrees,
    laplace,
)
from bayescal.calibration.model.error_model import WHITE, ErrorModel, Geometry
from bayescal.calibration.model.observations import Observations
from bayescal.calibration.model.strengths import Strengths, strengths
from bayescal.prior.strength import Strength
from tests.helpers import boards

UNIT = 1 / 400
EVERYTHING = ErrorModel(0.5, 0.2, 0.5, 0.5)


@cache
def settled_problem(error: ErrorModel, n_views: int = 13, seed: int = 1) -> Problem:
    world, pixels = boards.pictures(np.random.default_rng(seed), n_views=n_views)
    data = boards.observed(world, pixels)
    model = boards.radial(2, tangential=True)
    fit = boards.fitted(model, data)
    geometry = Geometry(data)
    shared, root = geometry.shared(error), geometry.offset_root(error, UNIT)
    return settled(Problem(model, data, fit.x, fit.poses, shared, root))


@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
def test_seeds_agree(error: ErrorModel) -> None:
    """Truth: the same number from fresh draws; a spread of 0.02 nat and within 4 of the errors."""
    problem = settled_problem(error)
    found = [weighed(problem, np.random.default_rng(seed), 4000)[0] for seed in range(10)]
    values = np.array([f.log_evidence for f in found])
    assert np.ptp(values) <= 0.02
    assert np.abs(values - values.mean()).max() <= 4 * max(f.error for f in found)
    assert abs(problem.laplace.log_evidence - values.mean()) < 0.03


@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
@pytest.mark.parametrize("away", [0.0, 3.0, -5.0])
def test_combinations_of_strengths_that_are_dropped_matter_to_no_one(
    error: ErrorModel, away: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Truth: all of them kept, from references up to five deviations off the mode."""
    problem = settled_problem(error)
    x = problem.x + away * np.sqrt(np.diag(problem.laplace.covariance))
    moved = replace(problem, x=x, poses=problem.poses_at(x))
    few = moved.laplace
    monkeypatch.setattr(laplace_module, "NEGLIGIBLE", math.inf)
    every = replace(moved).laplace
    assert len(few.log_mass) < len(every.log_mass)  # some were dropped
    assert few.log_evidence == pytest.approx(every.log_evidence, rel=0, abs=1e-5)
    sd = np.sqrt(np.diag(every.covariance))
    np.testing.assert_allclose(few.mean, every.mean, atol=1e-4 * sd.min())
    np.testing.assert_allclose(
        few.covariance, every.covariance, rtol=1e-3, atol=1e-4 * sd.min() ** 2
    )


def test_forms_at_once_are_each_alone() -> None:
    """Truth: one at a time; of unlike sums of squares and degrees of freedom."""
    problem = settled_problem(WHITE)
    form, prior = problem.form, strengths(problem.model)
    parts = [(1.0, 1.0, 0), (2.0, 0.9, 100), (0.5, 40.0, 2)]
    forms = [
        Forms(a * form.precision, a * form.slope, b * form.squares, form.nu - c, form.constant)
        for a, b, c in parts
    ]
    joined = (np.concatenate([getattr(f, each.name) for f in forms]) for each in fields(Forms))
    for found, one in zip(laplace(Forms(*joined), problem.x, prior), forms, strict=True):
        (truth,) = laplace(one, problem.x, prior)
        assert found.log_evidence == pytest.approx(truth.log_evidence, abs=1e-6)
        assert found.kept.tolist() == truth.kept.tolist()
        np.testing.assert_allclose(found.covariance, truth.covariance, rtol=1e-5)


def test_laplace_of_a_pose_is_its_integral() -> None:
    """Truth: importance sampling of six pose parameters, view by view: 0.005 nat in all."""
    problem = settled_problem(WHITE)
    data, model = problem.data, problem.model
    variance = problem.reduced.sum_of_squares / degrees(data)
    rng, n = np.random.default_rng(0), 4000
    roots = np.linalg.cholesky(np.linalg.inv(problem.views.pose_precision) * variance)
    z = rng.standard_normal((n, data.n_views, 6))
    moves = np.einsum("vij,svj->svi", roots, z)
    misfit, possible = residuals(
        model, data, np.broadcast_to(problem.x, (n, model.dimension)), problem.poses.moved(moves)
    )
    assert possible.all()
    best, _ = residuals(model, data, problem.x[None], problem.poses)
    grown = ((misfit**2).sum(axis=(2, 3)) - (best**2).sum(axis=(2, 3))) / (2 * variance)
    log_ratio = logsumexp(-grown + (z**2).sum(axis=2) / 2, axis=0) - math.log(n)
    assert abs(log_ratio.sum()) < 0.005
    assert np.abs(log_ratio).max() < 0.003


@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
def test_integral_over_all_coordinates(error: ErrorModel) -> None:
    """Truth: importance sampling of lens, sigma and all poses together, nothing eliminated."""
    problem = settled_problem(error)
    data, model = problem.data, problem.model
    rng, n, v = np.random.default_rng(0), 2000, data.n_views
    mixture, _ = proposal(problem)
    x = mixture.draw(rng, n)
    covariance = covariance_of_everything(problem)
    root = np.linalg.cholesky(covariance)
    nu, bounds = degrees(data), tuple(math.log(b) for b in SIGMA_BOUNDS)
    poses = problem.poses_at(x)
    slopes = np.zeros((2 * data.n_points, 6 * v))
    rows = np.arange(2 * data.n_points).reshape(v, -1)
    for view in range(v):
        at = np.ix_(rows[view], range(6 * view, 6 * view + 6))
        slopes[at] = problem.stack.by_pose[view].reshape(-1, 6)
    whitened = np.linalg.solve(root, slopes)
    precision = whitened.T @ whitened
    pose_root = np.linalg.inv(np.linalg.cholesky(precision)).T

    def squares_at(moved: object) -> tuple[Array, Array]:
        misfit, possible = residuals(model, data, x, moved)  # type: ignore[arg-type]
        flat = np.linalg.solve(root, misfit.reshape(n, -1).T)
        return flat, np.where(possible, (flat**2).sum(axis=0), np.inf)

    flat, start = squares_at(poses)
    towards = np.linalg.solve(precision, whitened.T @ flat).T
    least = start - np.einsum("si,ij,sj->s", towards, precision, towards)
    log_sigma = Strength((bounds[0], bounds[1]), nu).draw(least, rng)
    z = rng.standard_normal((n, 6 * v))
    move = towards + (z @ pose_root.T) * np.exp(log_sigma)[:, None]
    _, squares = squares_at(poses.moved(move.reshape(n, v, 6)))
    width = bounds[1] - bounds[0]
    log_p = (
        -data.n_points * math.log(2 * math.pi) - 2 * data.n_points * log_sigma
        - squares * np.exp(-2 * log_sigma) / 2
        - np.log(np.diag(root)).sum() - math.log(width)
        + v * LOG_POSE + problem.log_prior(x)
    )  # fmt: skip
    # Of ln sigma given S, as the truncated gamma has it; of the poses given both.
    log_q = (
        -nu / 2 * math.log(2 * math.pi) - nu * log_sigma - least * np.exp(-2 * log_sigma) / 2
        - math.log(width) - Strength((bounds[0], bounds[1]), nu).log_density(least)
        - (z**2).sum(axis=1) / 2 - 3 * v * math.log(2 * math.pi) - 6 * v * log_sigma
        + np.linalg.slogdet(precision)[1] / 2
    )  # fmt: skip
    weights = log_p - log_q - mixture.log_density(x)
    found = float(logsumexp(weights)) - math.log(n)
    error_of_it = float(np.exp(weights - found).std()) / math.sqrt(n)
    ours = weighed(problem, np.random.default_rng(1), 4000)[0]
    assert error_of_it < 0.02
    assert abs(found - ours.log_evidence) < 0.03


def covariance_of_everything(problem: Problem) -> Array:
    """Covariance of all residuals over sigma^2, dense: rows are view, place, axis."""
    data = problem.data
    v, n = data.which.shape
    total = np.zeros((v, n, 2, v, n, 2))
    for view in range(v):
        inverse = problem.shared.inverse
        block = np.eye(n) if inverse is None else np.linalg.inv(inverse[view])
        for axis in (0, 1):
            total[view, :, axis, view, :, axis] = block
    total = total.reshape(2 * v * n, -1)
    if problem.root is not None:
        spread = np.zeros((v, n, 2, len(data.target), 3))
        for view in range(v):
            spread[view, np.arange(n), :, data.which[view]] = problem.stack.by_target[view]
        offsets = spread.reshape(2 * v * n, -1) @ problem.root
        total = total + offsets @ offsets.T
    return total


@pytest.mark.parametrize("error", [WHITE, EVERYTHING, ErrorModel(2.0, 0.4, 0.0, 0.0)])
def test_linear_gaussian_limit(error: ErrorModel) -> None:
    """Truth: the density of a multivariate normal, flat in the poses."""
    problem = settled_problem(error, n_views=3)
    data, sigma = problem.data, 0.2
    known = Level(sigma)
    rng = np.random.default_rng(0)
    d = problem.model.dimension
    sd = rng.uniform(0.5, 2, d) * np.sqrt(np.diag(np.linalg.inv(problem.reduced.precision))) * sigma
    mean = problem.x + rng.normal(0, sd)
    log_density = -np.log(sd).sum() - d / 2 * math.log(2 * math.pi)
    prior = Strengths(sd[None] ** -2, np.array([log_density]), np.zeros(1), mean)
    (ours,) = laplace(problem.form, problem.x, prior, known)
    stack, v = problem.stack, data.n_views
    residual = stack.residuals.ravel()
    by_lens = stack.by_lens.reshape(len(residual), -1)
    by_pose = np.zeros((v, data.which.shape[1], 2, v, 6))
    for view in range(v):
        by_pose[view, :, :, view] = stack.by_pose[view]
    by_pose = by_pose.reshape(len(residual), -1)
    covariance = covariance_of_everything(problem) * sigma**2
    whole = covariance + (by_lens * sd**2) @ by_lens.T
    centred = residual - by_lens @ (mean - problem.x)
    # A flat prior of poses leaves the normal's density at their generalised least squares,
    # times the volume of the normal about it.
    precision = by_pose.T @ np.linalg.solve(whole, by_pose)
    best = np.linalg.solve(precision, by_pose.T @ np.linalg.solve(whole, centred))
    truth = multivariate_normal(by_pose @ best, whole).logpdf(centred)
    truth += 3 * v * math.log(2 * math.pi) - np.linalg.slogdet(precision)[1] / 2 + v * LOG_POSE
    assert ours.log_evidence == pytest.approx(truth, abs=1e-6)


def test_density_is_minimised_over_the_poses() -> None:
    """Truth: Newton's steps to the end at lenses 2 sd off, with the blocks evaluated there."""
    problem = settled_problem(EVERYTHING)
    rng = np.random.default_rng(0)
    x = problem.x + 2 * rng.standard_normal((5, problem.model.dimension)) @ problem.spread.T
    ours = problem.log_prob(x)
    for row, value in zip(x, ours, strict=True):
        there = replace(problem, x=row, poses=problem.poses_at(row[None]).only_draw(0))
        for _ in range(3):
            there = replace(there, poses=there.poses_at(row))
        assert there.log_prob(row[None])[0] == pytest.approx(value, abs=0.01)


def test_known_sigma_and_its_limits() -> None:
    """Truth: integrating the known level over its prior gives the inferred one."""
    problem = settled_problem(WHITE)
    levels = np.exp(np.linspace(np.log(0.15), np.log(0.25), 81))
    x = problem.x[None]
    logs = [replace(problem, level=Level(float(s))).log_prob(x)[0] for s in levels]
    step = math.log(levels[1] / levels[0])
    total = logsumexp(np.array(logs)) + math.log(step / math.log(1000))
    assert problem.log_prob(x)[0] == pytest.approx(total, abs=1e-3)


def test_observations_of_fewer_points() -> None:
    """Negative control: evidence of different data differs."""
    problem = settled_problem(WHITE)
    fewer: Observations = problem.data.only(np.arange(12))
    other = replace(problem, data=fewer, poses=problem.poses.only(np.arange(12)))
    assert abs(other.laplace.log_evidence - problem.laplace.log_evidence) > 10
