"""Independence Metropolis in emcee against targets whose moments are known."""

from __future__ import annotations

from dataclasses import dataclass

import emcee
import numpy as np
import pytest
from scipy import stats

from bayescal.inference.chains.move import IndependenceMove

WALKERS = 50
STEPS = 600
THIN = 6  # far beyond the autocorrelation time at acceptances of 0.6 and more


@dataclass
class StudentProposal:
    """Independent Student t coordinates, whose scale it claims `overstated` times as large."""

    centre: float
    scale: float
    overstated: float = 1.0

    def draw(self, rng, size):
        return self.centre + self.scale * rng.standard_t(4, (size, 2))

    def log_density(self, theta):
        claimed = stats.t(4, loc=self.centre, scale=self.overstated * self.scale)
        return claimed.logpdf(theta).sum(axis=1)


def normal_target(theta):
    """Two independent standard normals, not normalised."""
    return -0.5 * (theta**2).sum(axis=1)


def skewed_target(theta):
    """The logarithms of two independent Gamma(3) variables."""
    return (3 * theta - np.exp(theta)).sum(axis=1)


# Target, the truth of each coordinate, centre and scale of a proposal that covers it.
TARGETS = {
    "normal": (normal_target, stats.norm(), 0.0, 1.3),
    "skewed": (skewed_target, stats.loggamma(3), 0.9, 0.8),
}


def sampled(target, proposal, seed=1):
    """Thinned draws of one run, (n, 2), and the acceptance fraction."""
    rng = np.random.default_rng(seed)
    move = IndependenceMove(proposal, rng)
    sampler = emcee.EnsembleSampler(WALKERS, 2, target, moves=move, vectorize=True)
    state = sampler.run_mcmc(rng.normal(0, 0.5, (WALKERS, 2)), 50)
    sampler.reset()
    sampler.run_mcmc(state, STEPS)
    return sampler.get_chain(thin=THIN, flat=True), sampler.acceptance_fraction.mean()


def scores(draws, truth) -> np.ndarray:
    """Standard scores of mean and variance per coordinate, draws taken as independent."""
    n = len(draws)
    mean, variance, _, excess = truth.stats("mvsk")
    of_mean = (draws.mean(axis=0) - mean) / np.sqrt(variance / n)
    of_variance = (draws.var(axis=0) / variance - 1) / np.sqrt((excess + 2) / n)
    return np.concatenate([of_mean, of_variance])


@pytest.mark.parametrize("name", TARGETS)
def test_draws_have_the_targets_moments(name):
    """Four scores within 4 standard errors of 5000 independent draws."""
    target, truth, centre, scale = TARGETS[name]
    draws, acceptance = sampled(target, StudentProposal(centre, scale))
    assert acceptance > 0.5
    assert np.abs(scores(draws, truth)).max() < 4


@pytest.mark.parametrize("name", TARGETS)
def test_draws_have_the_targets_distribution(name):
    """Kolmogorov-Smirnov per coordinate."""
    target, truth, centre, scale = TARGETS[name]
    draws, _ = sampled(target, StudentProposal(centre, scale))
    assert min(stats.kstest(column, truth.cdf).pvalue for column in draws.T) > 1e-3


@pytest.mark.parametrize("name", TARGETS)
def test_a_proposal_that_misstates_its_density_fails_both(name):
    """Negative control: a scale claimed to be a third larger."""
    target, truth, centre, scale = TARGETS[name]
    draws, _ = sampled(target, StudentProposal(centre, scale, overstated=4 / 3))
    assert np.abs(scores(draws, truth)).max() > 6
    assert min(stats.kstest(column, truth.cdf).pvalue for column in draws.T) < 1e-3


def test_the_density_is_remembered_only_where_the_walkers_stayed():
    """Another move may have moved them: reflections in between keep a symmetric target.

    The proposal is lopsided, so that a density remembered from before a reflection
    would show.
    """
    rng = np.random.default_rng(2)
    move = IndependenceMove(StudentProposal(0.8, 1.3), rng)
    sampler = emcee.EnsembleSampler(WALKERS, 2, normal_target, moves=move, vectorize=True)
    coords = rng.normal(0, 0.5, (WALKERS, 2))
    draws = []
    for _ in range(STEPS):
        coords = -sampler.run_mcmc(coords, 1).coords
        draws.append(coords)
    draws = np.concatenate(draws[50::THIN])
    assert np.abs(scores(draws, stats.norm())).max() < 4


def test_each_walker_is_a_chain_of_its_own():
    """Independent walkers: means of their halves are uncorrelated across neighbours.

    The correlation of 50 independent pairs has a standard error of 0.14.
    """
    rng = np.random.default_rng(3)
    move = IndependenceMove(StudentProposal(0.0, 1.3), rng)
    sampler = emcee.EnsembleSampler(WALKERS, 2, normal_target, moves=move, vectorize=True)
    sampler.run_mcmc(rng.normal(0, 0.5, (WALKERS, 2)), 200)
    means = sampler.get_chain()[50:, :, 0].mean(axis=0)
    assert abs(np.corrcoef(means, np.roll(means, 1))[0, 1]) < 4 * 0.14


def test_a_target_of_zero_density_is_never_accepted():
    """Closed form: a half-normal; no walker may ever leave the positive side."""

    def half(theta):
        return np.where((theta > 0).all(axis=1), normal_target(theta), -np.inf)

    rng = np.random.default_rng(4)
    move = IndependenceMove(StudentProposal(0.0, 1.3), rng)
    sampler = emcee.EnsembleSampler(WALKERS, 2, half, moves=move, vectorize=True)
    sampler.run_mcmc(np.abs(rng.normal(0, 0.5, (WALKERS, 2))), 300)
    draws = sampler.get_chain(discard=50, thin=25, flat=True)
    assert (draws > 0).all()
    assert stats.kstest(draws.ravel(), stats.halfnorm.cdf).pvalue > 1e-3
