"""Simulation-based calibration: truths drawn from the prior have uniform ranks.

Talts et al. 2018 (arXiv:1804.06788). Everything is drawn from the default prior as it
stands: sigma log-uniform from 0.01 to 1000 px, tau from 0.01 px to half
the image, amplitudes given
tau. The log density at the truth joins the parameters as a quantity to rank, as it
sees errors that no single parameter shows (Modrak et al. 2023, arXiv:2211.02383).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial

from bayescal.inference.checked_posterior import sample_posterior
from bayescal.inference.target import log_prob
from scripts.validation.ranks import DRAWS, holm, p_values, ranks
from tests.helpers.problems import make_axis, make_model

SIMULATIONS = 384
BINS = 16  # of 16 ranks
LEVEL = 1e-3  # of the whole family of tests
SIZE = 1000.0  # px
X = np.linspace(-0.4, 0.7, 15)


def simulated(order: int, rng: np.random.Generator):
    """A truth from the prior and data from the truth: theta, reported truth, points."""
    log_sigma = rng.uniform(np.log(0.01), np.log(1000))
    log_tau = rng.uniform(np.log(0.01 / SIZE), np.log(0.5))
    scale = np.full(order + 1, np.exp(log_tau) * SIZE)
    scale[:2] = SIZE / 2
    b = rng.normal(0, scale)
    b[0] += SIZE / 2
    series = Legendre(b, domain=[X[0], X[-1]])
    t = series(X) + np.exp(log_sigma) * rng.standard_normal(len(X))
    hyper = [log_sigma, log_tau] if order > 1 else [log_sigma]
    monomials = series.convert(kind=Polynomial).coef
    return np.append(b, hyper), np.append(monomials, np.exp(hyper)), make_axis(X, t, SIZE)


def independent(chains: np.ndarray) -> np.ndarray:
    """255 draws at least 16 steps apart, (255, ...): the autocorrelation time is about 1."""
    return chains[:, 15::16].reshape(-1, *chains.shape[2:])[:DRAWS]


@cache
def posteriors(order: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Per simulation: the truth, and draws of the same quantities, (255, quantities)."""
    rng = np.random.default_rng([2024, order])
    out = []
    for _ in range(SIMULATIONS):
        theta, truth, data = simulated(order, rng)
        model = make_model(data, order)
        chain = sample_posterior(model, rng, 1000).chain
        draws = np.column_stack([independent(chain.draws), independent(chain.log_prob)])
        out.append((np.append(truth, log_prob(model, theta[None])), draws))
    return out


def adjusted(order: int, *, shrink: float) -> np.ndarray:
    """Adjusted p-values of uniform ranks, the parameters' draws shrunk about their means."""
    return holm(p_values(ranks(posteriors(order), shrink), BINS))


@pytest.mark.parametrize("order", [1, 3])
def test_ranks_of_the_truths_are_uniform(order):
    """Family-wise level 1e-3 over the parameters, sigma, tau and the log density."""
    assert adjusted(order, shrink=1.0).min() > LEVEL / 2  # two orders share the level


@pytest.mark.parametrize("order", [1, 3])
def test_deviations_30_percent_too_small_are_rejected(order):
    """Negative control: the same draws, shrunk about their means; every coefficient shows it."""
    p = adjusted(order, shrink=0.7)
    assert (p[: order + 1] < LEVEL / 2).all()


def test_shifted_posteriors_are_rejected():
    """Negative control: draws half a deviation too high."""
    rows = [(draws + 0.5 * draws.std(axis=0) < truth).sum(axis=0) for truth, draws in posteriors(3)]
    assert (holm(p_values(np.array(rows), BINS))[:4] < LEVEL / 2).all()


def test_holm_is_the_step_down_rule():
    """By hand: sorted p times 4, 3, 2, 1, never falling."""
    np.testing.assert_allclose(holm(np.array([0.03, 0.01, 0.5, 0.02])), [0.06, 0.04, 0.5, 0.06])
