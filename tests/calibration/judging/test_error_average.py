"""Draws shared out over error models."""

from __future__ import annotations

import numpy as np

from bayescal.calibration.judging.averaging import FEWEST, allotted


def test_every_error_model_has_its_share_on_average():
    """Truth: n times the share, of those below one lot too; four standard errors of 2000 turns."""
    shares = np.array([0.5, 0.3, 0.1, *[0.005] * 20]) * 0.99  # need not sum to 1
    rng = np.random.default_rng(1)
    counts = np.array([allotted(shares, 1000, rng) for _ in range(2000)])
    assert (counts.sum(axis=1) == 1000).all()
    assert (counts % FEWEST == 0).all()
    expected = 1000 * shares / shares.sum()
    assert (np.abs(counts - expected) < FEWEST).all()  # systematic: never a lot off
    error = np.maximum(counts.std(axis=0), 1e-9) / np.sqrt(len(counts))
    assert (np.abs(counts.mean(axis=0) - expected) < 4 * error + 1e-9).all()


def test_one_error_model_has_all():
    assert allotted(np.array([1.0]), 1000, np.random.default_rng(1)).tolist() == [1000]
