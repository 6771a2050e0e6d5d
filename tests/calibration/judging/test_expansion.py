"""The density by terms of its residuals, and normal equations without a view."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bayescal.calibration.fitting.reduction import eliminate, eliminate_independent, reduce
from bayescal.calibration.fitting.stacking import pose_slopes, stacked
from bayescal.calibration.judging import by_views
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.evidence import proposal, settled, weighed
from bayescal.calibration.judging.expansion import NEAR, Expansion, Terms, expanded
from bayescal.calibration.model.error_model import WHITE, ErrorModel, Geometry
from bayescal.calibration.model.observations import Observations
from tests.calibration.judging.test_evidence import covariance_of_everything
from tests.helpers import boards

UNIT = 1 / 400
EVERYTHING = ErrorModel(0.5, 0.2, 0.5, 0.5)


def some_missing(rng: np.random.Generator) -> Observations:
    """Views of which each lacks a tenth of the points, in places of its own."""
    world, pixels = boards.pictures(rng, n_views=6)
    v, n = pixels.shape[:2]
    which, view = np.tile(np.arange(n), v), np.repeat(np.arange(v), n)
    kept = rng.random(v * n) < 0.9
    return Observations.of(world, which[kept], pixels.reshape(-1, 2)[kept], view[kept], boards.SIZE)


@cache
def partial_problem(error: ErrorModel) -> Problem:
    data = some_missing(np.random.default_rng(3))
    model = boards.radial(2, tangential=True)
    fit = boards.fitted(model, data)
    geometry = Geometry(data)
    shared, root = geometry.shared(error), geometry.offset_root(error, UNIT)
    return settled(Problem(model, data, fit.x, fit.poses, shared, root))


@pytest.mark.parametrize("error", [WHITE, ErrorModel(0.5, 0.2), ErrorModel(0, 0, 0.5), EVERYTHING])
def test_sum_of_squares_where_views_lack_points(error: ErrorModel) -> None:
    """Truth: generalised least squares over all poses, the covariance dense."""
    problem = partial_problem(error)
    data, v = problem.data, problem.data.n_views
    by_pose = np.zeros((v, *data.which.shape[1:], 2, v, 6))
    for view in range(v):
        by_pose[view, ..., view, :] = problem.stack.by_pose[view]
    seen = np.repeat(data.seen.ravel(), 2)
    slopes, e = by_pose.reshape(len(seen), -1)[seen], problem.stack.residuals.ravel()[seen]
    covariance = covariance_of_everything(problem)[np.ix_(seen, seen)]
    weighted = np.linalg.solve(covariance, np.column_stack([slopes, e]))
    best = np.linalg.solve(slopes.T @ weighted[:, :-1], slopes.T @ weighted[:, -1])
    truth = (e - slopes @ best) @ np.linalg.solve(covariance, e - slopes @ best)
    assert problem.squares(problem.x[None])[0] == pytest.approx(truth, rel=1e-6)
    assert problem.reduced.sum_of_squares == pytest.approx(truth, rel=1e-9)


@pytest.mark.parametrize("holes", [False, True])
@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
def test_normal_equations_without_a_view(error: ErrorModel, holes: bool) -> None:
    """Truth: those of the other views alone; holes are bad points that are left out."""
    problem = partial_problem(error)
    if holes:
        out = np.zeros(problem.data.seen.shape, dtype=bool)
        out[0, 4] = out[3, 7] = True
        data = problem.data.without(out)
        problem = replace(problem, data=data, shared=Geometry(data).shared(error))
    found = problem.views.without(2, problem.stack, problem.data, problem.shared)
    rest = problem.only(np.array([0, 1, 3, 4, 5]))
    truth = reduce(rest.stack, rest.data, rest.shared, offsets=problem.root is not None).sums
    assert found.log_det == pytest.approx(truth.log_det, abs=1e-9)
    for name in ("gram", "cross", "inner"):
        ours, theirs = getattr(found, name), getattr(truth, name)
        np.testing.assert_allclose(ours, theirs, atol=1e-9 * max(1, np.abs(theirs).max(initial=0)))


def test_offsets_are_independent_along_their_directions() -> None:
    """Truth: the covariance of the root."""
    geometry = Geometry(some_missing(np.random.default_rng(3)))
    sds, root = geometry.offset_sds(EVERYTHING, UNIT), geometry.offset_root(EVERYTHING, UNIT)
    assert root is not None
    basis = np.kron(geometry.directions, np.eye(3))[:, geometry.free]
    np.testing.assert_allclose(basis.T @ basis, np.eye(len(sds)), atol=1e-12)
    np.testing.assert_allclose((basis * sds**2) @ basis.T, root @ root.T, atol=1e-15)


def test_offsets_are_eliminated_alike_along_them_and_by_their_root() -> None:
    """Truth: the dense root; of several error models at once, one of them without offsets."""
    problem = partial_problem(EVERYTHING)
    geometry, sums = Geometry(problem.data), problem.views.sums
    errors = [EVERYTHING, ErrorModel(0.5, 0.2), ErrorModel(0.5, 0.2, 0.0, 4.0)]
    sds = np.array([geometry.offset_sds(error, UNIT) for error in errors])
    turned = sums.turned(geometry.directions, geometry.free)
    grams, log_dets = eliminate_independent([turned] * 3, sds)
    for error, gram, log_det in zip(errors, grams, log_dets, strict=True):
        truth = eliminate(sums, geometry.offset_root(error, UNIT))
        np.testing.assert_allclose(gram, truth.gram, rtol=1e-9, atol=1e-12 * np.abs(gram).max())
        assert log_det == pytest.approx(truth.log_det, abs=1e-9)


def test_slopes_of_many_lenses_are_those_of_each() -> None:
    problem = partial_problem(EVERYTHING)
    x = problem.x + np.array([[0.0], [1.0]]) * problem.spread[:, 0]
    found = pose_slopes(problem.model, problem.data, x, problem.poses_at(x))
    for one, slopes in zip(x, found, strict=True):
        truth = stacked(problem.model, problem.data, one, problem.poses_at(one)).by_pose
        np.testing.assert_allclose(slopes, truth, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
def test_expansion_is_the_density_over_the_posterior(error: ErrorModel) -> None:
    """Truth: the density itself, at draws of the posterior; and evidence from the same draws."""
    problem = partial_problem(error)
    density = expanded(problem)
    assert isinstance(density, Expansion)
    x = problem.x + np.random.default_rng(1).standard_normal((200, len(problem.x))) @ (
        problem.spread.T
    )
    off = density.log_prob(x) - problem.log_prob(x)
    assert np.sqrt((off**2).mean()) < NEAR
    fast, full = (weighed(d, np.random.default_rng(2), 500)[0] for d in (density, problem))
    # The correction is the mean of 100 differences of at most NEAR or so.
    assert fast.log_evidence == pytest.approx(full.log_evidence, abs=3 * NEAR / 10)
    assert fast.error == pytest.approx(full.error, rel=0.05)


def test_terms_serve_another_error_model() -> None:
    """Truth: the density under that error model, linearised where the terms were found."""
    problem = partial_problem(EVERYTHING)
    terms = Terms.of(problem)
    assert terms is not None
    geometry = Geometry(problem.data)
    error = ErrorModel(1.0, 0.4, 0.25, 0.5)
    other = replace(problem, shared=geometry.shared(error), root=geometry.offset_root(error, UNIT))
    x = proposal(other)[0].draw(np.random.default_rng(1), 100)
    likely = other.log_prob(x) > other.log_prob(x).max() - 8
    off = Expansion(other, terms).log_prob(x)[likely] - other.log_prob(x)[likely]
    assert np.abs(off).max() < 2 * NEAR


def test_an_expansion_that_is_not_near_is_not_used() -> None:
    """Negative control: a slope with a third of another in it, which the draws must tell."""
    problem = partial_problem(WHITE)
    terms = Terms.of(problem)
    assert terms is not None
    ((views, values),) = terms.values
    wrong = values.copy()
    wrong[1] += 0.3 * wrong[2]
    assert Expansion(problem, terms).near
    assert not Expansion(problem, replace(terms, values=[(views, wrong)])).near


@pytest.mark.parametrize("error", [WHITE, EVERYTHING])
def test_some_views_at_a_time_are_all_at_once(
    error: ErrorModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sums over views in another order: to rounding of the sum of squares."""
    problem = partial_problem(error)
    whole = expanded(problem)
    monkeypatch.setattr(by_views, "AT_ONCE", 1)
    parts = expanded(replace(problem))
    assert isinstance(whole, Expansion)
    assert isinstance(parts, Expansion)
    assert [len(some) for some in (list(whole.terms.values), list(parts.terms.values))] == [1, 6]
    x = proposal(problem)[0].draw(np.random.default_rng(1), 50)
    np.testing.assert_allclose(parts.squares(x), whole.squares(x), rtol=1e-9)
    np.testing.assert_allclose(parts.log_likelihood(x), whole.log_likelihood(x), rtol=1e-9)
    ours, theirs = (p.problem.log_likelihood(x) for p in (parts, whole))
    np.testing.assert_allclose(ours, theirs, rtol=1e-10)


@pytest.mark.parametrize("factor", [0.9, 1.1, np.nan])
def test_an_expansion_far_from_the_density_has_no_say(factor: float) -> None:
    """Truth: the evidence from draws of the density alone; residuals are off by a tenth."""
    problem = partial_problem(WHITE)
    terms = Terms.of(problem)
    assert terms is not None
    ((views, values),) = terms.values
    wrong = Expansion(problem, replace(terms, values=[(views, factor * values)]))
    found, _, _ = weighed(wrong, np.random.default_rng(2), 500)
    truth, _, _ = weighed(problem, np.random.default_rng(3), 500)
    error = np.hypot(found.error, truth.error)
    assert found.log_evidence == pytest.approx(truth.log_evidence, abs=4 * error)
