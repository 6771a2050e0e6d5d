"""One store and one key: a candidate has the same draws wherever it is shown."""

from __future__ import annotations

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.key import FAMILIES, FREE, STATED, Key
from bayescal.comparison.store import Store
from bayescal.density.robust_pair import RobustPair
from bayescal.noise.choice import NOISE_MODELS

KEYS = [
    *(
        Key.of_axis(a, k, n, f)
        for a in "rc"
        for k in (1, 2)
        for n in NOISE_MODELS
        for f in FAMILIES[:2]
    ),
    *(
        Key(f, (k,), p, n)
        for f in FAMILIES[1:]
        for k in (1, 2)
        for p in (STATED, FREE)
        for n in NOISE_MODELS
    ),
    *(Key("separable", (k, 1), p, n) for k in (1, 2) for p in (STATED, FREE) for n in NOISE_MODELS),
]


def test_candidates_have_names_and_random_numbers_of_their_own():
    assert len({key.file() for key in KEYS}) == len(KEYS)
    first = {key.rng(0).integers(2**60) for key in KEYS}
    assert len(first) == len(KEYS)
    assert KEYS[0].rng(0, 1).integers(2**60) not in first


@pytest.mark.parametrize(
    ("key", "usual", "name"),
    [
        (Key.of_axis("r", 4, "gaussian"), "gaussian", "r-order-4"),
        (Key.of_axis("r", 4, "student-t"), "student-t", "r-order-4"),
        (Key.of_axis("c", 1, "student-t"), "gaussian", "c-student-t-order-1"),
        (Key("separable", (4, 1), FREE), "gaussian", "separable-4-1-free"),
        (Key("pinhole", (2,), STATED, "student-t"), "student-t", "pinhole-2-stated"),
    ],
)
def test_names_in_runs_stay(key, usual, name):
    assert key.file(usual) == name


def test_a_gaussian_order_has_the_random_numbers_it_always_had():
    """Truth: numpy's own tree of seeds, by axis and order."""
    for i, axis in enumerate("rc"):
        was = np.random.default_rng(np.random.SeedSequence(3, spawn_key=(i, 4)))
        assert was.integers(2**60) == Key.of_axis(axis, 4, "gaussian").rng(3).integers(2**60)


def test_a_store_computes_once():
    store, computed = Store(), []
    key = Key.of_axis("r", 1, "gaussian")
    for _ in range(2):
        found = store.posterior(key, None, lambda: computed.append(1) or "posterior")
    assert found == "posterior"
    assert computed == [1]


def test_one_set_of_draws_wherever_a_model_is_shown():
    """Order 2 of r under Student-t: compared, among bad points, across families.

    A defence weighs it without a chain: its evidence agrees within 5 Monte Carlo errors.
    """
    points, how = bc.thesis(), {"seed": 5, "ess": 400}
    compared = bc.compare(points, [2], axis="r", noise="student-t", hint=False, **how)
    draws = compared.axes["r"][2].posterior.full
    study = bc.outliers(points, [2], axis="r", **how).axes["r"]
    (heavy,) = (t for t in study.treatments if t.noise == "student-t")
    assert np.array_equal(heavy.orders[0].posterior.full, draws)
    pair = bc.fit_family(points, "separable", (2, 1), noise="student-t", **how).models[0].posterior
    assert isinstance(pair.model, RobustPair)
    kept = pair.model.apart(pair.full.reshape(-1, pair.full.shape[2]))[0]
    rows = {row.tobytes() for row in draws.reshape(-1, draws.shape[2])}
    assert len(kept) > 400
    assert all(row.tobytes() in rows for row in np.ascontiguousarray(kept))
    defended = bc.compare(points, [2], axis="r", defend=True, hint=False, **how).axes["r"].defence
    (other,) = (n for n in defended.noises if n.key.noise == "student-t")
    sampled = compared.axes["r"][2]
    error = np.hypot(other.log_evidence_error, sampled.log_evidence_error)
    assert abs(other.log_evidence - sampled.log_evidence) < 5 * error
    assert error < 0.05
    another = bc.compare(points, [2], axis="r", noise="student-t", hint=False, seed=6, ess=400)
    assert not np.array_equal(another.axes["r"][2].posterior.full, draws)  # negative control
