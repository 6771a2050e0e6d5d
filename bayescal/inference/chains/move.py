"""Independence Metropolis as a move of emcee."""

from __future__ import annotations

from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.lean_emcee import Move
from bayescal.inference.proposals.proposal import Proposal

# Proposals don't depend on the state, so they are drawn, and their densities evaluated, for
# several steps at a time: the cost of many small array operations falls by this factor. More
# draws at once gain nothing.
STEPS_AHEAD, DRAWS_AHEAD = 38, 152 * 64


class IndependenceMove(Move):
    """Metropolis-Hastings with a proposal that does not depend on the state.

    Each walker moves on its own and so is an independent chain (Tierney 1994,
    Ann. Statist. 22, 2.3.3); the acceptance ratio is p(x') q(x) / (p(x) q(x')).

    Parameters
    ----------
    proposal : Proposal
        In the sampler's coordinates.
    rng : numpy.random.Generator
        The only source of randomness of the move.
    ahead : int, optional
        Steps to draw and evaluate at a time, by default 38, or as many as make 9728 draws; what
        is left of them at the end is lost.
    """

    def __init__(
        self, proposal: Proposal, rng: np.random.Generator, ahead: int | None = None
    ) -> None:
        self.proposal, self.rng, self.ahead = proposal, rng, ahead
        # Drawn, not yet proposed: coordinates, log q and log density, a row per step.
        self._drawn: tuple[Array, Array, Array] = (np.empty((0, 0, 0)), np.empty(0), np.empty(0))
        self._left = 0
        # First coordinate and log density of where the walkers are, and log q there.
        self._at: tuple[Array, Array, Array] | None = None

    def propose(self, model: Any, state: Any) -> tuple[Any, Any]:
        """Propose a new state for every walker and accept or keep the old one.

        Returns
        -------
        accepted : ndarray of bool
            ``(n_walkers,)``.
        """
        walkers = len(state.coords)
        coords, log_q, log_prob = self._next(model, walkers)
        log_q_now = self._log_q(state)
        log_ratio = log_prob - state.log_prob + log_q_now - log_q
        accepted = np.log(self.rng.random(walkers)) < log_ratio
        np.copyto(state.coords, coords, where=accepted[:, None])
        np.copyto(state.log_prob, log_prob, where=accepted)
        np.copyto(log_q_now, log_q, where=accepted)
        self._at = state.coords[:, 0].copy(), state.log_prob.copy(), log_q_now
        return state, accepted

    def _next(self, model: Any, walkers: int) -> tuple[Array, Array, Array]:
        if not self._left or self._drawn[0].shape[1] != walkers:
            ahead = self.ahead or min(STEPS_AHEAD, max(DRAWS_AHEAD // walkers, 1))
            coords = self.proposal.draw(self.rng, ahead * walkers)
            log_q = self.proposal.log_density(coords)
            log_prob, _ = model.compute_log_prob_fn(coords)
            self._drawn = (
                coords.reshape(ahead, walkers, -1),
                log_q.reshape(ahead, walkers),
                log_prob.reshape(ahead, walkers),
            )
            self._left = ahead
        self._left -= 1
        coords, log_q, log_prob = (values[self._left] for values in self._drawn)
        return coords, log_q, log_prob

    def _log_q(self, state: Any) -> Array:
        """Log density where the walkers are: remembered, unless another move moved them.

        That shows in the first coordinate or in the density: comparing all coordinates would
        take a tenth of a step.
        """
        if self._at is not None and len(self._at[0]) == len(state.coords):
            first, log_prob, log_q = self._at
            moved = (first != state.coords[:, 0]) | (log_prob != state.log_prob)
            if not moved.any():
                return log_q
        found: Array = self.proposal.log_density(state.coords)
        return found
