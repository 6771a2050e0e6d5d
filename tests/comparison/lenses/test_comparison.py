"""Lens models compared: the right one is found, and what stands against it is said."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.special import softmax

import bayescal as bc
from bayescal.calibration.judging.evidence import weighed
from bayescal.comparison.lenses.candidates import named_candidates
from bayescal.comparison.lenses.left_out import jackknife, leave_views_out, refitted
from bayescal.comparison.lenses.results import LensComparison
from bayescal.errors import InputError
from bayescal.points.views.views import Views
from tests.helpers import boards

NAMES = ("pinhole", "radial 1", "radial 2", "radial 2 + p", "radial 3")


def simulated(seed: int, n_views: int = 8, **options: object) -> Views:
    world, pixels = boards.pictures(np.random.default_rng(seed), n_views, **options)  # type: ignore[arg-type]
    width, height = boards.SIZE
    return Views.from_arrays([world] * n_views, list(pixels), width=width, height=height)


@cache
def compared() -> LensComparison:
    return bc.calibrate(simulated(1), lenses=NAMES)


def test_the_true_lens_is_found() -> None:
    """Truth: the simulated camera has k1 and k2; every true value within 5 sd."""
    found = compared()
    assert found.verdict.best == "radial 2"
    assert found.sound
    assert found.best.probability > 0.5
    truth = {"fx": 530, "fy": 531, "cx": 328, "cy": 235, "k1": -0.28, "k2": 0.07, "sigma": 0.2}
    for name, value in truth.items():
        p = found.posterior[name]
        assert abs(p.mean - value) < 5 * p.sd, name


def test_independent_errors_are_found_to_be_so() -> None:
    """Truth: the noise was independent and the board exact."""
    error, weight = compared().errors[0]
    assert not error.correlated
    assert not error.offsets
    assert weight > 0.3


def test_probabilities_and_criteria_agree_with_their_definitions() -> None:
    found = compared()
    assert sum(j.probability for j in found.lenses) == pytest.approx(1)
    logs = np.array([j.log_evidence for j in found.lenses])
    assert (np.diff(logs) <= 0).all()
    best = found.best
    n, k = 8 * 54, 6 + 6 * 8 + 1
    assert best.n_parameters == k
    squares = best.rms**2 * n
    log_likelihood = -n * (np.log(2 * np.pi * squares / (2 * n)) + 1)
    assert best.bic == pytest.approx(-2 * log_likelihood + k * np.log(n))
    assert best.aic == pytest.approx(-2 * log_likelihood + 2 * k)


def test_a_notebook_shows_the_lenses() -> None:
    shown = compared()._repr_html_()
    assert all(name in shown for name in NAMES)
    assert shown.count("<tr>") == len(NAMES) + 1


def test_emcee_agrees_with_importance_draws() -> None:
    """Truth: the same density, weighed; means within 5 of their errors, sds within a tenth."""
    found = compared()
    estimate, draws, log_weights = weighed(found.problem, np.random.default_rng(0))
    weights = softmax(log_weights)
    mean = weights @ draws
    sd = np.sqrt(weights @ (draws - mean) ** 2)
    theta = found.posterior.chain.theta.reshape(-1, len(mean))
    assert (np.abs(theta.mean(axis=0) - mean) < 5 * sd / np.sqrt(1000)).all()
    np.testing.assert_allclose(theta.std(axis=0), sd, rtol=0.12)
    gap = found.posterior.log_evidence - estimate.log_evidence
    assert abs(gap) < 5 * estimate.error


def test_views_left_out_are_the_ratio_of_evidences() -> None:
    """Truth: an evidence of the other views, settled from where they themselves fit best."""
    problem = compared().best.evidence.problem
    found = leave_views_out(problem)
    assert found is not None
    left, without = found
    prior = problem.likely_strengths
    for view in range(8):
        rest, _ = refitted(problem, np.delete(np.arange(8), view), prior, close=1e-4)
        truth = problem.laplace.log_evidence - rest.laplace.log_evidence
        # Residuals are linear within a half a deviation only.
        assert left.pointwise[view] == pytest.approx(truth, abs=0.01)
    sd = np.sqrt(np.diag(jackknife(without)))
    spread = np.sqrt(np.diag(problem.laplace.covariance))
    # Of eight views: right to a factor of about two.
    assert (sd[:6] < 3 * spread[:6]).all()
    assert (sd[:6] > spread[:6] / 4).all()


def test_the_same_seed_gives_the_same() -> None:
    views = simulated(2, 5)
    first, second = (bc.calibrate(views, lenses=["radial 1"], seed=3) for _ in range(2))
    assert first.best.log_evidence == second.best.log_evidence
    assert (first.draws == second.draws).all()


def test_names_users_know() -> None:
    keys = [c.name for c in named_candidates(["radial:2", "radial 2", "opencv5", "fisheye 1"])]
    assert keys == ["radial 2", "opencv5", "fisheye 1"]


@pytest.mark.parametrize("name", ["radial two", "lens", "radial 9", "eucm 1 2", ""])
def test_unknown_names_are_refused_in_a_line(name: str) -> None:
    with pytest.raises(InputError) as error:
        named_candidates([name])
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("noise", [0.1, 1.0])
def test_one_view_taken_three_times_is_refused(noise: float) -> None:
    """The noise differs, the pose does not: they tell no more than one."""
    world, pixels = boards.pictures(np.random.default_rng(1), 1)
    rng = np.random.default_rng(2)
    again = [pixels[0] + rng.normal(0, noise, pixels[0].shape) for _ in range(3)]
    width, height = boards.SIZE
    views = Views.from_arrays([world] * 3, again, width=width, height=height)
    with pytest.raises(InputError, match="alike"):
        bc.calibrate(views, lenses=["pinhole", "radial 1"])


def test_one_view_is_refused() -> None:
    with pytest.raises(InputError, match="one view"):
        bc.calibrate(simulated(1, 1))


def test_a_lens_alone_has_the_evidence_it_has_among_others() -> None:
    """Truth: one model of one set of views has one evidence; the search starts elsewhere."""
    alone = bc.calibrate(simulated(1), lenses=["radial 2"], ess=100)
    among = compared()["radial 2"]
    assert alone.best.log_evidence == pytest.approx(among.log_evidence, abs=0.005)
