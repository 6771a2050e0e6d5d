"""A lens far from the points settles where its evidence can be drawn."""

import numpy as np
import pytest

from bayescal.calibration.judging.evidence import weighed
from bayescal.calibration.judging.laplace import INFERRED, semidefinite
from bayescal.comparison.judging import judge_all
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from scripts.validation.simulated_boards import Errors, Truth, views_of

# Of a long lens whose tangential terms move the corners by a hundred pixels.
TRUTH, INTRINSICS = Truth((0.3, 4.0, 4.0), (90.0, 110.0)), [4964.0, 5125.0, 722.0, 412.0]


@pytest.mark.parametrize(("lens", "seed"), [("radial 1", 4), ("radial 3", 1)])
def test_a_lens_without_the_terms_it_needs_has_an_evidence(lens, seed):
    views, _ = views_of(TRUTH, Errors(0.67), 6, np.random.default_rng(seed), np.array(INTRINSICS))
    names = tuple(dict.fromkeys(("radial 1", "radial 2", lens)))
    sweep = Sweep(views, LensRequest(names, independent=True, draws=500), INFERRED)
    judged = {j.name: j for j in judge_all(sweep, Store(), Settings())}[lens]
    estimate = judged.evidence.estimate
    assert estimate.effective_fraction * estimate.draws > 50
    again, _, _ = weighed(judged.evidence.problem, np.random.default_rng(1), 4000)
    errors = np.hypot(estimate.error, again.error)
    assert estimate.log_evidence == pytest.approx(again.log_evidence, abs=4 * errors)


@pytest.mark.parametrize(("n_views", "seed"), [(8, 4), (18, 1)])
def test_coefficients_that_cancel_settle_at_small_ones(n_views, seed):
    """Numerator and denominator of the rational lens fit best at thousands of px each."""
    truth = Truth((-60.0, 15.0), (0.5, -0.5))
    views, _ = views_of(truth, Errors(0.15), n_views, np.random.default_rng(seed))
    names = ("radial 2 + p", "radial 3 + p", "opencv8")
    sweep = Sweep(views, LensRequest(names, independent=True, draws=500), INFERRED)
    *_, smaller, larger = judge_all(sweep, Store(), Settings())
    assert np.abs(larger.fit.x).max() > 300  # px
    assert larger.evidence.estimate.effective_fraction > 0.5
    # Nothing of what it adds is in the data: it loses by no more than its prior is wider.
    assert -5 < larger.log_evidence - smaller.log_evidence < 1


def test_rounding_leaves_no_negative_precision():
    """Of a precision known to 16 digits, the direction that nothing determines."""
    sides = np.array([[1.0, 1.0 + 1e-9], [2.0, 2.0], [3.0, 3.0]]) * 1e4
    exact = sides.T @ sides
    spoilt = exact - 1e-3 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert np.linalg.eigvalsh(spoilt)[0] < 0
    mended, untouched = semidefinite(np.array([spoilt, np.eye(2)]))
    assert np.linalg.eigvalsh(mended)[0] > -1e-6
    np.testing.assert_allclose(mended, exact, rtol=1e-9)
    np.testing.assert_array_equal(untouched, np.eye(2))
