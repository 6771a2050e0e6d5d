"""R-hat and effective sample sizes of all parameters at once.

Truth: ArviZ, parameter by parameter.
"""

from __future__ import annotations

import numpy as np
import pytest
from arviz_stats.base import array_stats

from bayescal.arrays import Array
from bayescal.inference.chains import diagnostics
from bayescal.inference.chains.diagnostics import Diagnostics, autocovariance, diagnose


def of_arviz(draws: Array) -> Diagnostics:
    def ess(method: str, **options: float) -> float:
        found = array_stats.ess(draws, chain_axis=0, draw_axis=1, method=method, **options)
        return float(found)

    rhat = float(array_stats.rhat(draws, chain_axis=0, draw_axis=1))
    return Diagnostics(rhat, ess("bulk"), ess("tail", prob=0.95), ess("mean"), ess("sd"))


def chains(count: int, n: int, memory: float, seed: int = 0) -> Array:
    """First-order autoregressions, ``(count, n)``."""
    rng = np.random.default_rng(seed)
    out, state = np.empty((count, n)), rng.standard_normal(count)
    for i in range(n):
        state = memory * state + np.sqrt(1 - memory**2) * rng.standard_normal(count)
        out[:, i] = state
    return out


CASES = {
    "independent": chains(64, 66, 0.0),
    "correlated": chains(8, 501, 0.9),
    "hardly moving": chains(4, 200, 0.999),
    "antithetic": chains(4, 300, -0.8),
    "one chain": chains(1, 400, 0.5),
    "chains apart": chains(6, 100, 0.3) + np.arange(6)[:, None],
    "heavy tails": np.random.default_rng(1).standard_cauchy((5, 333)),
    "ties": np.round(chains(4, 250, 0.4)),
    "few draws": chains(3, 5, 0.0),
    "fewest": chains(2, 4, 0.0),
    "too few": chains(2, 3, 0.0),
    "a chain stuck": np.concatenate([chains(3, 90, 0.2), np.ones((1, 90))]),
    "nan": np.where(np.arange(200).reshape(4, 50) == 17, np.nan, chains(4, 50, 0.2)),
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of ArviZ
@pytest.mark.parametrize("name", CASES)
def test_the_numbers_of_arviz(name: str) -> None:
    draws = CASES[name]
    (found,) = diagnose(draws[:, :, None])
    np.testing.assert_allclose(found, of_arviz(draws), rtol=1e-10)


def test_a_constant_counts_every_draw() -> None:
    (found,) = diagnose(np.ones((3, 40, 1)))
    assert found.ess_mean == found.ess_bulk == 120
    assert np.isnan(found.rhat)


def test_parameters_do_not_know_of_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """All at once, in parts or each by itself: the same to rounding."""
    draws = np.stack([chains(6, 80, memory, i) for i, memory in enumerate((0, 0.5, 0.9))], axis=2)
    together = diagnose(draws)
    alone = [diagnose(draws[:, :, [j]])[0] for j in range(3)]
    np.testing.assert_allclose(together, alone, rtol=1e-12)
    monkeypatch.setattr(diagnostics, "AT_ONCE", 1)
    np.testing.assert_allclose(diagnose(draws), together, rtol=1e-12)


def test_rhat_compares_the_chains_it_is_given() -> None:
    draws = chains(6, 100, 0.2)[:, :, None]
    merged = draws.reshape(2, 300, 1)
    found = diagnose(draws, merged)[0]
    assert found.rhat == diagnose(merged)[0].rhat
    assert found.ess_bulk == diagnose(draws)[0].ess_bulk


def test_autocovariance_is_its_definition() -> None:
    draws = chains(3, 50, 0.6)
    centred = draws - draws.mean(axis=1, keepdims=True)
    for lag in (0, 1, 7, 49):
        expected = (centred[:, : 50 - lag] * centred[:, lag:]).sum(axis=1) / 50
        np.testing.assert_allclose(autocovariance(draws)[:, lag], expected, atol=1e-14)
