"""A lens far from the points settles where its evidence can be drawn."""

import numpy as np
import pytest

from bayescal.calibration.evidence import weighed
from bayescal.calibration.laplace import INFERRED
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
