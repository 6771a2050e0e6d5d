"""Sampling a posterior with emcee until a stated rule is met."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.chain import Chain
from bayescal.inference.chains.diagnostics import autocovariance, diagnose
from bayescal.inference.chains.lean_emcee import EnsembleSampler, Move, auto_window
from bayescal.inference.chains.move import IndependenceMove
from bayescal.inference.proposals.proposal import Proposal

WALKERS = 64
MIN_STEPS = 66
SPARE = 1.12  # draws per effective sample wanted; independence sampling needs about 1.05
BURN_IN = 6  # steps; the walkers start from the proposal, which is nearly the posterior
RHAT_LIMIT = 1.01
TAU_STEPS = 50  # autocorrelation times that a chain must be long (emcee's rule)
MAX_EXTENSIONS = 6  # each at most doubles the steps


def sample(
    log_prob: Callable[[Array], Array],
    proposal: Proposal,
    report: Callable[[Array], Array],
    rng: np.random.Generator,
    ess: int,
) -> Chain:
    """Sample with independence Metropolis until the stopping rule is met.

    The rule: bulk and tail ESS of every parameter at least `ess`, rank-normalised
    split R-hat below 1.01, more than 50 autocorrelation times of steps. Where it is
    not met the chain goes on, four times at most (`further_steps`).

    Parameters
    ----------
    log_prob : callable
        From parameters ``(n, dimension)`` to log densities ``(n,)``.
    report : callable
        From parameters ``(n, dimension)`` to reported ones ``(n, n_parameters)``.
    ess : int
        Effective samples wanted of every parameter.
    """
    move = IndependenceMove(proposal, rng)
    start = proposal.draw(rng, WALKERS)
    sampler = quiet_sampler(WALKERS, start.shape[1], log_prob, move)
    # emcee chooses among its moves with a legacy generator; one move leaves no choice.
    # Its check of the start's condition is for moves that stay in the walkers' span.
    options = {"skip_initial_state_check": True}
    state = sampler.run_mcmc(start, BURN_IN, store=False, **options)
    steps = max(MIN_STEPS, math.ceil(SPARE * ess / WALKERS))
    for extension in range(MAX_EXTENSIONS + 1):
        state = sampler.run_mcmc(state, steps, **options)
        chain = _collect(sampler, report, ess)
        if chain.converged or extension == MAX_EXTENSIONS:
            break
        steps = further_steps(chain, ess)
    return chain


class VectorSampler(EnsembleSampler):
    """An emcee sampler of a density that is evaluated for many walkers at once.

    emcee goes through what comes back number by number, in case blobs are among it: at 1000
    walkers that takes as long as everything else together. At every step it copies its
    generator's 624 numbers into the state, which nobody reads: a tenth of a step.
    """

    @property
    def random_state(self) -> None:
        """Nothing: the generator goes on from where it is."""

    @random_state.setter
    def random_state(self, state: object) -> None:
        pass

    def compute_log_prob(self, coords: Array) -> tuple[Array, None]:
        """Log densities of coordinates ``(n, dimension)``, ``(n,)``, and no blobs."""
        if not np.isfinite(coords).all():
            raise ValueError("a walker is at no finite place")
        found = self.log_prob_fn(coords)
        if np.isnan(found).any():
            raise ValueError("the log density is NaN")
        return found, None


def quiet_sampler(
    walkers: int, dimension: int, log_prob: Callable[[Array], Array], move: Move
) -> VectorSampler:
    """Make an emcee sampler that prints nothing.

    Parameters
    ----------
    log_prob : callable
        From all walkers at once, ``(n, dimension)``, to log densities ``(n,)``.
    """
    sampler = VectorSampler(walkers, dimension, log_prob, moves=move, vectorize=True)
    # emcee wraps the density to print whatever it raises, with its trace, before passing it
    # on: when somebody presses Ctrl-C, too.
    sampler.log_prob_fn = log_prob
    return sampler


def _collect(sampler: VectorSampler, report: Callable[[Array], Array], ess: int) -> Chain:
    theta = np.ascontiguousarray(sampler.get_chain().swapaxes(0, 1))  # (walker, step, dimension)
    draws = report(theta.reshape(-1, theta.shape[2])).reshape(*theta.shape[:2], -1)
    return judged(
        draws, theta, sampler.get_log_prob().T, float(np.mean(sampler.acceptance_fraction)), ess
    )


def judged(
    draws: Array,
    theta: Array,
    log_prob: Array,
    acceptance: float,
    ess: int,
    ensembles: int | None = None,
) -> Chain:
    """Diagnose draws and apply the stopping rule.

    Parameters
    ----------
    draws, theta, log_prob, acceptance
        As of a Chain.
    ess : int
        Effective samples wanted of every parameter.
    ensembles : int, optional
        Number of ensembles whose walkers interact, one after the other along the first
        axis: R-hat is then that over the ensembles, each a chain of all its walkers.
    """
    merged = draws
    if ensembles is not None:
        walkers = draws.reshape(ensembles, -1, *draws.shape[1:])
        merged = walkers.swapaxes(1, 2).reshape(ensembles, -1, draws.shape[2])
    diagnostics = diagnose(draws, merged)
    time = max(autocorrelation_time(draws[:, :, j]) for j in range(draws.shape[2]))
    enough = min(min(d.ess_bulk, d.ess_tail) for d in diagnostics) >= ess
    mixed = max(d.rhat for d in diagnostics) < RHAT_LIMIT
    long = draws.shape[1] > TAU_STEPS * time
    return Chain(
        draws, theta, log_prob, diagnostics, acceptance, time, bool(enough and mixed and long)
    )


def further_steps(chain: Chain, ess: int) -> int:
    """Say by how many steps a chain must go on: as many again, or fewer if ESS is nearly enough.

    Parameters
    ----------
    chain : Chain
        Not converged.
    ess : int
        Effective samples wanted of every parameter.
    """
    steps = len(chain.draws[0])
    found = min(min(d.ess_bulk, d.ess_tail) for d in chain.diagnostics)
    if not found < ess:  # R-hat or the length is what falls short, or nothing moved
        return steps
    return math.ceil(steps * min(max(1.1 * ess / found - 1, 0.25), 1.0))


def autocorrelation_time(chains: Array) -> float:
    """Integrated autocorrelation time, as ``emcee.autocorr.integrated_time`` defines it.

    That function goes through the walkers one by one; taking them together saves a
    tenth of a whole comparison.

    Parameters
    ----------
    chains : Array
        One parameter, ``(n_chains, n_draws)``.

    Returns
    -------
    float
        Steps; nan where a chain never moved.
    """
    covariance = autocovariance(chains)
    with np.errstate(invalid="ignore"):
        correlation = (covariance / covariance[:, :1]).mean(axis=0)
    times = 2 * np.cumsum(correlation) - 1
    return float(times[auto_window(times, 5.0)])
