"""The public comparison: what determines its draws, and what it says of exact fits."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bayescal as bc
from tests.helpers.problems import ORDERS
from tests.helpers.strategies import settings_for

ROOT = Path(bc.__file__).resolve().parents[1]

# 200 000 points and order 15: from about there a threaded BLAS splits the factorisation,
# and where nothing limits its threads the digests differ.
HASH_OF_A_COMPARISON = """
import hashlib
import numpy as np
import bayescal as bc
rng = np.random.default_rng(0)
x = rng.uniform(-1, 1, 200_000)
y = 500 + 300 * x + 20 * x**3 + rng.normal(0, 2, len(x))
digest = hashlib.sha256()
for result in (bc.compare_polynomials(x, y, [15], ess=500), bc.compare(bc.thesis(), [4])):
    for axis in result.axes.values():
        for order in axis.orders:
            digest.update(order.posterior.chain.draws.tobytes())
            digest.update(order.fit.coefficients.tobytes())
            digest.update(repr(order.log_evidence).encode())
print(digest.hexdigest())
"""


def draws(result, axis: str, order: int) -> bytes:
    return result.axes[axis][order].posterior.chain.draws.tobytes()


def test_the_same_seed_gives_the_same_bytes(thesis_comparison):
    again = bc.compare(bc.thesis(), axis="r")
    for order in ORDERS:
        assert draws(again, "r", order) == draws(thesis_comparison, "r", order)


def test_another_seed_gives_other_draws():
    """Negative control."""
    first, second = (bc.compare(bc.thesis(), [1], axis="r", seed=s) for s in (0, 1))
    assert draws(first, "r", 1) != draws(second, "r", 1)


def same_but_for_rounding(one, other, axis, order):
    """The factorisation at another highest order rounds otherwise; nothing else differs."""
    first, second = (r.axes[axis][order].posterior.chain.draws for r in (one, other))
    assert (np.abs(first - second) < 1e-9 * second.std(axis=(0, 1))).all()


@pytest.mark.parametrize("orders", [[4], [1, 4], [3, 4]])
def test_lower_orders_compared_change_no_draw(thesis_comparison, orders):
    result = bc.compare(bc.thesis(), orders, axis="r")
    same_but_for_rounding(result, thesis_comparison, "r", 4)


@pytest.mark.parametrize("orders", [[2], [2, 3], [2, 5]])
def test_higher_orders_compared_change_no_draw(thesis_comparison, orders):
    result = bc.compare(bc.thesis(), orders, axis="c")
    same_but_for_rounding(result, thesis_comparison, "c", 2)


def test_the_other_axis_changes_no_draw(thesis_comparison):
    alone = bc.fit(bc.thesis(), order_c=1)
    same_but_for_rounding(alone, thesis_comparison, "c", 1)


def test_axes_and_orders_have_random_numbers_of_their_own(thesis_comparison):
    """Negative control: ln sigma's ranks would agree if two models shared a stream."""
    ranks = []
    for axis, order in [("r", 1), ("c", 1), ("r", 2)]:
        theta = thesis_comparison.axes[axis][order].posterior.chain.theta
        ranks.append(np.argsort(np.argsort(theta[:, :, order + 1].ravel())))
    for i, j in [(0, 1), (0, 2), (1, 2)]:
        assert abs(np.corrcoef(ranks[i], ranks[j])[0, 1]) < 5 / np.sqrt(len(ranks[i]))


def hash_with_threads(threads: str) -> str:
    """Digest of two comparisons, in a process of its own."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    environment = {**os.environ, **dict.fromkeys(names, threads), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", HASH_OF_A_COMPARISON],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_one_thread_and_many_give_the_same_bytes():
    """In processes of their own, as a BLAS reads its number of threads when it loads."""
    one, many = hash_with_threads("1"), hash_with_threads("4")
    assert len(one) == hashlib.sha256().digest_size * 2
    assert one == many


@settings_for(8)
@given(st.integers(1, 3), st.integers(0, 1000))
def test_an_exact_fit_has_no_criteria_a_caveat_and_no_warning(order, seed):
    """Closed form: integer polynomials of integers leave no residual (warnings are errors)."""
    rng = np.random.default_rng(seed)
    x = np.arange(12.0)
    y = np.polynomial.polynomial.polyval(x, rng.integers(1, 9, order + 1).astype(float))
    result = bc.compare_polynomials(x, y, [order, order + 1], ess=100)
    axis = result.axes["y"]
    for entry in axis.orders:
        assert entry.fit.exact
        found = entry.criteria
        assert (found.log_likelihood, found.aic, found.aicc, found.bic) == (None,) * 4
    assert axis.reference.value is None
    assert any("fits exactly" in caveat for caveat in axis.verdict.caveats)
    assert (axis.verdict.aicc_order, axis.verdict.bic_order) == (None, None)


def test_an_exact_fit_of_a_higher_order_alone_is_told_apart():
    """A cubic without noise: the line has criteria, the cubic has none."""
    x = np.arange(12.0)
    axis = bc.compare_polynomials(x, x**3, [1, 3], ess=100).axes["y"]
    assert axis[1].criteria.bic is not None
    assert axis[3].criteria.bic is None
    assert any("order 3 fits exactly" in caveat for caveat in axis.verdict.caveats)
    assert axis.verdict.order == 3


@settings_for(8)
@given(st.integers(0, 1000))
def test_probabilities_of_a_comparison_sum_to_one(seed):
    rng = np.random.default_rng(seed)
    x = np.linspace(0, 1, 20)
    result = bc.compare_polynomials(x, x + rng.normal(0, 0.1, 20), [1, 2, 4], ess=100)
    assert sum(r.probability for r in result.axes["y"].orders) == pytest.approx(1, abs=1e-12)


def test_a_flat_prior_gives_no_probabilities_and_no_recommendation():
    axis = bc.compare(bc.thesis(), [1, 2], axis="c", prior="flat").axes["c"]
    assert [r.probability for r in axis.orders] == [None, None]
    assert [r.log_evidence for r in axis.orders] == [None, None]
    assert axis.verdict.order is None
    assert axis.verdict.plausible == ()
    assert "flat prior" in axis.verdict.text
    assert axis.chosen.order == 1  # by BIC
    assert axis.orders[0].posterior.agrees_with_exact
