"""Several independent ensembles of emcee for posteriors without a closed form.

Most steps are independence Metropolis from an adapted heavy-tailed proposal, whose
walkers don't interact; every twentieth is a differential-evolution move (ter Braak 2006,
Stat. Comput. 16, 239), which goes where the proposal is too thin.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.chain import Chain
from bayescal.inference.chains.lean_emcee import DEMove, Move
from bayescal.inference.chains.move import IndependenceMove
from bayescal.inference.chains.sampling import (
    BURN_IN,
    MAX_EXTENSIONS,
    further_steps,
    judged,
    quiet_sampler,
)
from bayescal.inference.proposals.coordinates import WhitenedProposal, Whitening
from bayescal.inference.proposals.proposal import Proposal

ENSEMBLES = 4
WALKERS = 16  # of each at least, and twice the dimension, which a differential move needs
STEPS = 120  # to begin with; more draws are more walkers, which emcee moves in one go
EVERY = 20  # steps from one differential move to the next
SPARE = 1.8  # draws per effective sample to begin with
AHEAD = 40  # independence steps at a time: three times that are in BURN_IN + STEPS


class AlternatingMove(Move):
    """Independence Metropolis, and every twentieth step a differential-evolution move.

    A fixed cycle of moves that each leave the posterior invariant leaves it invariant
    (Tierney 1994, Ann. Statist. 22, 2.4), and needs no random choice between them.
    """

    def __init__(self, independence: IndependenceMove) -> None:
        self.independence, self.ensemble, self.step = independence, DEMove(), 0

    def propose(self, model: Any, state: Any) -> tuple[Any, Any]:
        """Propose a new state for every walker by the move whose turn it is."""
        self.step += 1
        move = self.ensemble if self.step % EVERY == 0 else self.independence
        proposed: tuple[Any, Any] = move.propose(model, state)
        return proposed


def sample_ensembles(
    log_prob: Callable[[Array], Array],
    proposal: Proposal,
    whitening: Whitening,
    finish: Callable[[Array, np.random.Generator], tuple[Array, Array]],
    rng: np.random.Generator,
    ess: int,
) -> tuple[Chain, Array]:
    """Sample until the stopping rule of `sampling.sample` is met.

    R-hat is that over the ensembles: walkers of one ensemble are not independent chains.

    Parameters
    ----------
    log_prob : callable
        From parameters ``(n, dimension)`` to log densities ``(n,)``.
    proposal : Proposal
        Heavier-tailed than the posterior.
    whitening : Whitening
        Coordinates emcee samples in.
    finish : callable
        From kept draws of theta and a generator to completed and to reported ones.
    ess : int
        Effective samples wanted of every parameter.

    Returns
    -------
    chain : Chain
        ``draws`` and ``theta``: a walker is a chain, ensemble after ensemble.
    full : Array
        Completed draws, ``(n_chains, n_draws, n_full)``.
    """
    *own, last = rng.spawn(ENSEMBLES + 1)
    seed = last.bit_generator.random_raw(4).tolist()
    walkers = max(WALKERS, 2 * len(whitening.centre), math.ceil(SPARE * ess / (ENSEMBLES * STEPS)))
    ensembles = [_Ensemble(log_prob, proposal, whitening, walkers, child) for child in own]
    steps = STEPS
    for extension in range(MAX_EXTENSIONS + 1):
        for ensemble in ensembles:
            ensemble.run(steps)
        u = np.concatenate([e.sampler.get_chain().swapaxes(0, 1) for e in ensembles])
        theta = whitening.theta(u)
        full, draws = finish(theta.reshape(-1, theta.shape[2]), np.random.default_rng(seed))
        shape = theta.shape[:2]
        chain = judged(
            draws.reshape(*shape, -1),
            theta,
            np.concatenate([e.sampler.get_log_prob().T for e in ensembles]),
            float(np.mean([e.sampler.acceptance_fraction.mean() for e in ensembles])),
            ess,
            ENSEMBLES,
        )
        if chain.converged or extension == MAX_EXTENSIONS:
            break
        steps = further_steps(chain, ess)
    return chain, full.reshape(*shape, -1)


class _Ensemble:
    """One emcee ensemble with randomness of its own."""

    def __init__(
        self,
        log_prob: Callable[[Array], Array],
        proposal: Proposal,
        whitening: Whitening,
        walkers: int,
        rng: np.random.Generator,
    ) -> None:
        whitened = WhitenedProposal(proposal, whitening)
        self.sampler = quiet_sampler(
            walkers,
            len(whitening.centre),
            lambda u: log_prob(whitening.theta(u)),
            AlternatingMove(IndependenceMove(whitened, rng, AHEAD)),
        )
        # The differential move takes emcee's legacy generator, which is seeded here.
        seed = int(rng.integers(2**32))
        self.sampler._random.set_state(np.random.RandomState(seed).get_state())
        state = _start(whitened, self.sampler, rng, walkers)
        self.state = self.sampler.run_mcmc(
            state, BURN_IN, store=False, skip_initial_state_check=True
        )

    def run(self, steps: int) -> None:
        """Go on for so many steps."""
        self.state = self.sampler.run_mcmc(self.state, steps, skip_initial_state_check=True)


def _start(
    whitened: WhitenedProposal, sampler: Any, rng: np.random.Generator, walkers: int
) -> Array:
    """Draws of the posterior, nearly: of the proposal, resampled by their weights."""
    u = whitened.draw(rng, 50 * walkers)
    log_w = sampler.compute_log_prob(u)[0] - whitened.log_density(u)
    # The largest of weight plus Gumbel noise: sampling without replacement.
    best = np.argsort(-(log_w + rng.gumbel(size=len(log_w))), kind="stable")[:walkers]
    return np.asarray(u[best])
