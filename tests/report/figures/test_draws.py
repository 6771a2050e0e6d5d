"""Figures of the draws themselves: traces, ranks, autocorrelation."""

from __future__ import annotations

import numpy as np

from bayescal.report.figures.comparison.autocorrelation import autocorrelation
from bayescal.report.figures.comparison.trace import rank_differences
from bayescal.report.figures.registry import KINDS


def test_traces_are_the_draws(thesis_comparison):
    figure = KINDS["trace"].draw(thesis_comparison, "c", 1)
    draws = thesis_comparison.axes["c"][1].posterior.chain.draws
    panels = np.array(figure.axes).reshape(-1, 2)
    assert len(panels) == draws.shape[2]
    for j, (left, _) in enumerate(panels):
        for artist, chain in zip(left.lines, (0, 21, 42, 63), strict=True):
            np.testing.assert_array_equal(artist.get_ydata(), draws[chain, :, j])


def leaves_band(draws):
    from bayescal.report.figures.comparison.trace import _bound

    return np.abs(rank_differences(draws)[1]).max() > _bound(*draws.shape)


def test_ranks_of_alike_chains_stay_in_the_band_and_of_others_leave_it():
    rng = np.random.default_rng(2)
    sets = 200
    left = np.mean([leaves_band(rng.standard_normal((8, 60))) for _ in range(sets)])
    assert left < 0.05 + 4 * np.sqrt(0.05 * 0.95 / sets)
    apart = rng.standard_normal((8, 60))
    apart[3] += 1.5
    assert leaves_band(apart)


def test_autocorrelation_of_a_known_process():
    rng = np.random.default_rng(4)
    chains, length, rho = 64, 4000, 0.6
    draws = np.empty((chains, length))
    draws[:, 0] = rng.standard_normal(chains)
    for i in range(1, length):
        noise = np.sqrt(1 - rho**2) * rng.standard_normal(chains)
        draws[:, i] = rho * draws[:, i - 1] + noise
    found = autocorrelation(draws)[:10]
    # Bartlett's formula bounds the error of each lag by sqrt((1 + r^2) / (1 - r^2) / n).
    error = np.sqrt((1 + rho**2) / (1 - rho**2) / draws.size)
    np.testing.assert_allclose(found, rho ** np.arange(10), atol=5 * error)
