"""Convergence of chains: rank-normalised split R-hat and effective sample sizes.

As Vehtari, Gelman, Simpson, Carpenter & Buerkner 2021, Bayesian Analysis 16, 667, and as ArviZ
computes them: its numbers come out to rounding (tests/inference/chains/test_diagnostics.py). ArviZ
goes through parameters one by one, which takes a quarter of a comparison, and importing it half as
long as all else; here all parameters of a model are ranked and transformed at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.fft import next_fast_len
from scipy.special import ndtri

from bayescal.arrays import Array

# Numbers whose transforms are held at once.
AT_ONCE = 2_000_000
# The ESS of the tails is the smaller of those of these quantiles.
TAILS = (0.05, 0.95)
FEWEST = 4
# A series that varies by less is constant.
CONSTANT = 1e-15


class Diagnostics(NamedTuple):
    """Convergence diagnostics of one parameter; nan where draws are too few or no numbers."""

    rhat: float
    ess_bulk: float
    ess_tail: float
    ess_mean: float
    ess_sd: float


def diagnose(draws: Array, merged: Array | None = None) -> tuple[Diagnostics, ...]:
    """R-hat and effective sample sizes of every parameter.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws, n_parameters)``.
    merged : Array, optional
        The same draws as the chains that R-hat compares, where these are others.
    """
    merged = draws if merged is None else merged
    step = max(1, AT_ONCE // draws[:, :, 0].size)
    found: list[Diagnostics] = []
    for start in range(0, draws.shape[2], step):
        part = slice(start, start + step)
        ratios, sizes = rhat(merged[:, :, part]), _sizes(draws[:, :, part])
        found += [Diagnostics(*row) for row in np.vstack([ratios, sizes]).T.tolist()]
    return tuple(found)


def rhat(draws: Array) -> Array:
    """Rank-normalised split R-hat of every parameter, ``(n_parameters,)``.

    The larger of that of the draws and that of their distances from the median.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws, n_parameters)``.
    """
    if len(draws) < 2 or draws.shape[1] < FEWEST:
        return np.full(draws.shape[2], np.nan)
    halves = _split(draws)
    folded = np.abs(halves - np.median(halves, axis=(0, 1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.maximum(_plain_rhat(_ranked(halves)), _plain_rhat(_ranked(folded)))


def _plain_rhat(chains: Array) -> Array:
    """Root of the pooled variance over that within chains (eq. 1-4)."""
    n = chains.shape[1]
    between = n * chains.mean(axis=1).var(axis=0, ddof=1)
    within = chains.var(axis=1, ddof=1).mean(axis=0)
    return np.asarray(np.sqrt((between / within + n - 1) / n))


def _sizes(draws: Array) -> Array:
    """Effective sample sizes of bulk, tail, mean and sd, ``(4, n_parameters)``."""
    if draws.shape[1] < FEWEST:
        return np.full((4, draws.shape[2]), np.nan)
    halves = _split(draws)
    low, high = (halves <= q for q in np.quantile(draws, TAILS, axis=(0, 1)))
    tail = np.minimum(_size(low.astype(float)), _size(high.astype(float)))
    squares = (halves - draws.mean(axis=(0, 1))) ** 2
    found = np.array([_size(_ranked(halves)), tail, _size(halves), _size(squares)])
    return np.asarray(np.where(np.isnan(draws).any(axis=(0, 1)), np.nan, found))


def _split(draws: Array) -> Array:
    """Take the first and the second half of each chain as two chains."""
    half = draws.shape[1] // 2
    return np.concatenate([draws[:, :half], draws[:, -half:]])


def _ranked(chains: Array) -> Array:
    """Give normal scores of the ranks among all draws of a parameter (eq. 14)."""
    flat = chains.reshape(-1, chains.shape[2])
    return np.asarray(ndtri((_ranks(flat) - 3 / 8) / (len(flat) + 1 / 4)).reshape(chains.shape))


def _ranks(columns: Array) -> Array:
    """Ranks within each column from 1, the mean of those that are equal.

    As scipy.stats.rankdata, whose import takes as long as a comparison; nan where one is nan.
    """
    order = np.argsort(columns, axis=0, kind="stable")
    ranks = np.empty(columns.shape)
    for place, column, out in zip(order.T, columns.T, ranks.T, strict=True):
        values = column[place]
        starts = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1]]))
        counts = np.diff(np.append(starts, len(values)))
        out[place] = np.repeat(starts + (counts + 1) / 2, counts)
    ranks[:, np.isnan(columns).any(axis=0)] = np.nan
    return ranks


def _size(chains: Array) -> Array:
    """Effective sample size of every parameter's mean (eq. 10-13), ``(n_parameters,)``."""
    count, n = chains.shape[:2]
    covariance = autocovariance(chains).mean(axis=0)
    within = covariance[0] * n / (n - 1)
    pooled = covariance[0] + (chains.mean(axis=1).var(axis=0, ddof=1) if count > 1 else 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = 1 - (within - covariance) / pooled
    correlation[0] = 1.0
    times = np.array([_time(column) for column in correlation.T])
    total = count * n
    still = np.ptp(chains, axis=(0, 1)) < CONSTANT
    return np.asarray(np.where(still, total, total / np.maximum(times, 1 / math.log10(total))))


def _time(correlation: Array) -> float:
    """Integrated autocorrelation time by Geyer's initial monotone sequence (1992, section 3.3).

    Sums of two neighbouring lags are positive and fall; after the last pair that counts, one
    more lag does where it is positive.
    """
    n = len(correlation)
    even, odd = correlation[: n - n % 2 : 2], correlation[1::2]
    pairs = even + odd
    last = max(math.ceil((n - 2) / 2) - 1, 0)
    end = int(np.argmax(np.append(pairs[:last] <= 0, True)))
    rest = even[end] if even[end] > 0 or (end and pairs[end] >= 0) else 0.0
    return float(2 * np.minimum.accumulate(pairs[:end]).sum() - 1 + rest)


def autocovariance(draws: Array) -> Array:
    """Autocovariance of each chain at every lag, by Fourier transform.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws, ...)``.

    Returns
    -------
    Array
        Of the same shape, lags along the second axis.
    """
    n = draws.shape[1]
    size = next_fast_len(2 * n, real=True)
    spectrum = np.fft.rfft(draws - draws.mean(axis=1, keepdims=True), size, axis=1)
    power = spectrum.real**2 + spectrum.imag**2
    return np.asarray(np.fft.irfft(power, size, axis=1)[:, :n] / n)
