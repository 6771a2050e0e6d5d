"""Points with a shift of their own, everything else eliminated.

Truth: dense generalised least squares with the shift as two more coefficients; F or chi-squared.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, f

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.free_points import FreePoints
from bayescal.calibration.judging.laplace import Level
from bayescal.calibration.model.error_model import WHITE, ErrorModel
from tests.calibration.judging.test_evidence import EVERYTHING, settled_problem

VIEWS, AT = 4, ((0, 0), (2, 20), (2, 21))
ERRORS = [WHITE, ErrorModel(0.5, 0.2), EVERYTHING]


def weighted(error: ErrorModel, level: Level | None = None) -> Problem:
    """Problem whose points have weights of their own, r's and c's."""
    problem = settled_problem(error, VIEWS)
    weight = np.random.default_rng(3).uniform(0.5, 2, problem.data.weight.shape)
    return replace(problem, data=replace(problem.data, weight=weight), level=level or problem.level)


class Dense:
    """The same by matrices of all values, nothing eliminated."""

    def __init__(self, problem: Problem) -> None:
        v, n = problem.data.which.shape
        rows = 2 * v * n
        self.covariance = np.eye(rows)
        if problem.shared.inverse is not None:
            blocks = np.kron(np.linalg.inv(problem.shared.inverse), np.eye(2))
            for i, block in enumerate(blocks):
                self.covariance[2 * n * i : 2 * n * (i + 1), 2 * n * i : 2 * n * (i + 1)] = block
        if problem.root is not None:
            slope = np.zeros((v, n, 2, len(problem.root) // 3, 3))
            places = np.arange(n)
            for i in range(v):
                slope[i, places, :, problem.data.which[i]] = problem.stack.by_target[i]
            offsets = slope.reshape(rows, -1) @ problem.root
            self.covariance += offsets @ offsets.T
        poses = np.zeros((v, n, 2, v, 6))
        for i in range(v):
            poses[i, :, :, i] = problem.stack.by_pose[i]
        lens = problem.stack.by_lens.reshape(rows, -1)
        self.design = np.concatenate([lens, poses.reshape(rows, -1)], axis=1)
        self.residuals = problem.stack.residuals.ravel()
        self.places = n

    def fit(self, *free: tuple[int, int]) -> tuple[float, Array]:
        """Smallest sum of squares, and the shift of the last point."""
        extra = np.zeros((len(self.residuals), 2 * len(free)))
        for k, (view, place) in enumerate(free):
            at = 2 * (view * self.places + place)
            extra[[at, at + 1], [2 * k, 2 * k + 1]] = 1
        root = np.linalg.cholesky(self.covariance)
        design = np.linalg.solve(root, np.concatenate([self.design, extra], axis=1))
        size = np.linalg.norm(design, axis=0)
        found, squares, *_ = np.linalg.lstsq(
            design / size, np.linalg.solve(root, self.residuals), rcond=None
        )
        return float(squares[0]), (found / size)[-2:]

    def log_integral(self, problem: Problem, *gone: tuple[int, int]) -> float:
        """Log of the integral over lens, poses, offsets and sigma without some points."""
        rows = np.ones(len(self.residuals), dtype=bool)
        for view, place in gone:
            at = 2 * (view * self.places + place)
            rows[[at, at + 1]] = False
        covariance = self.covariance[rows][:, rows]
        design, left = self.design[rows] / np.linalg.norm(self.design, axis=0), self.residuals[rows]
        weighed = np.linalg.solve(covariance, np.column_stack([design, left]))
        precision = design.T @ weighed[:, :-1]
        pull = design.T @ weighed[:, -1]
        squares = left @ weighed[:, -1] - pull @ np.linalg.solve(precision, pull)
        log_det = np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(precision)[1]
        level = problem.level.log_density(np.array([squares]), len(left) - design.shape[1])
        weights = np.log(problem.data.weight.ravel()[rows]).sum()
        return float(level[0] - log_det / 2 + weights)


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("sigma", [None, 0.3])
def test_shifts_and_their_tests_are_those_of_dense_least_squares(
    error: ErrorModel, sigma: float | None
) -> None:
    problem = weighted(error, Level(sigma))
    dense, found = Dense(problem), FreePoints(problem)
    free: list[tuple[int, int]] = []
    for at in AT:
        without, _ = dense.fit(*free)
        assert found.squares == pytest.approx(without, rel=1e-9)
        within, shift = dense.fit(*free, at)
        gain, dof = without - within, found.dof - 2
        if sigma is None:
            expected = f.logsf(gain / 2 / (within / dof), 2, dof)
        else:
            expected = chi2.logsf(gain / sigma**2, 2)
        assert found.log_p()[at] == pytest.approx(expected, rel=1e-7)
        assert found.shift(*at) == pytest.approx(shift / problem.data.weight[at], rel=1e-7)
        found.release(*at)
        assert found.log_p()[at] == 0
        free.append(at)


def test_a_shift_is_seen_in_full_and_by_no_other_point_once_it_is_free() -> None:
    """Truth: the identity; what is added to a pixel is added to its shift, and to nothing else."""
    problem = weighted(EVERYTHING)
    pixels, moved = problem.data.pixels.copy(), np.array([3.0, -7.0])
    pixels[AT[1]] += moved
    before = FreePoints(problem)
    after = FreePoints(replace(problem, data=replace(problem.data, pixels=pixels)))
    assert after.shift(*AT[1]) - before.shift(*AT[1]) == pytest.approx(moved, rel=1e-9)
    worst = after.least_probable()
    assert worst is not None
    assert (worst.view, worst.place) == AT[1]
    for found in (before, after):
        found.release(*AT[1])
    assert after.log_p() == pytest.approx(before.log_p(), abs=1e-7)


def test_a_point_that_alone_places_its_view_is_not_tested() -> None:
    """Truth: four points of a plane leave two of eight values to tell of one of them."""
    problem = weighted(WHITE)
    weight = problem.data.weight.copy()
    corners = [0, 8, 45, 53]
    weight[1, np.setdiff1d(np.arange(54), corners)] = 0
    found = FreePoints(replace(problem, data=replace(problem.data, weight=weight)))
    assert found.left.sum() == problem.data.n_points - 50
    assert found.left[1, corners].all()
    found.release(1, 0)
    assert not found.left[1].any()


def test_exact_pixels_have_no_gross_error() -> None:
    """Truth: rounding is far below the smallest sigma."""
    problem = settled_problem(WHITE, VIEWS)
    exact = problem.data.pixels - problem.stack.residuals
    rounded = exact + np.random.default_rng(0).standard_t(1, exact.shape) * 1e-9
    found = FreePoints(replace(problem, data=replace(problem.data, pixels=rounded)))
    assert found.log_p().min() > -1e-3


def test_good_points_are_called_bad_as_often_as_the_level_says() -> None:
    """Truth: errors drawn from the error model; Bonferroni over 216 points, binomial error."""
    problem = settled_problem(ERRORS[1], VIEWS)
    rng, draws = np.random.default_rng(5), 300
    root = np.linalg.cholesky(Dense(problem).covariance)
    exact = problem.data.pixels - problem.stack.residuals
    least = []
    for _ in range(draws):
        errors = 0.2 * (root @ rng.standard_normal(len(root)))
        data = replace(problem.data, pixels=exact + errors.reshape(exact.shape))
        worst = FreePoints(replace(problem, data=data)).least_probable()
        assert worst is not None
        least.append(worst.log_p + np.log(data.n_points))
    for level in (0.2, 0.05):
        rate, error = np.mean(np.array(least) < np.log(level)), np.sqrt(level / draws)
        assert 1 - np.exp(-level) - 3 * error < rate < level + 3 * error


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("sigma", [None, 0.3])
def test_what_the_others_predict_of_a_point_is_a_ratio_of_integrals(
    error: ErrorModel, sigma: float | None
) -> None:
    """Truth: integrals over lens, poses and offsets by dense matrices, with the point and without.

    Points that have their shift are left out of both but for one of them.
    """
    problem = weighted(error, Level(sigma))
    dense, found = Dense(problem), FreePoints(problem)
    out: list[tuple[int, int]] = []
    whole = dense.log_integral(problem)
    for at in AT:
        found.release(*at)
        out.append(at)
        left = dense.log_integral(problem, *out)
        shifts, log_density = found.released()
        for one, shift, value in zip(out, shifts, log_density, strict=True):
            back = dense.log_integral(problem, *(other for other in out if other != one))
            assert value == pytest.approx(back - left, abs=1e-6)
            _, expected = dense.fit(*(other for other in out if other != one), one)
            assert shift == pytest.approx(expected / problem.data.weight[one], rel=1e-6)
    fresh = FreePoints(problem)
    assert fresh.log_density()[AT[0]] == pytest.approx(
        whole - dense.log_integral(problem, AT[0]), abs=1e-6
    )
    assert np.isnan(found.log_density()[AT[0]])
    other = (1, 7)
    expected = dense.log_integral(problem, *out) - dense.log_integral(problem, *out, other)
    assert found.log_density()[other] == pytest.approx(expected, abs=1e-6)
