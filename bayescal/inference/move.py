"""Independence Metropolis as a move of emcee."""

from __future__ import annotations

from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.lean_emcee import Move
from bayescal.inference.proposals.proposal import Proposal

# Proposals don't depend on the state, so they are drawn, and their densities evaluated, for
# several steps at a time: the cost of many small array operations falls by this factor. More
# draws at once would leave the processor's cache.
STEPS_AHEAD, DRAWS_AHEAD = 38, 38 * 64


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
        Steps to draw and evaluate at a time, by default 38, or as many as make 2432 draws; what
        is left of them at the end is lost.
    """

    def __init__(
        self, proposal: Proposal, rng: np.random.Generator, ahead: int | None = None
    ) -> None:
        self.proposal, self.rng, self.ahead = proposal, rng, ahead
        # Drawn, not yet proposed: coordinates, log q and log density.
        self._ahead: list[tuple[Array, Array, Array]] = []
        self._at: tuple[Array, Array] | None = None  # where the walkers are, and log q there

    def propose(self, model: Any, state: Any) -> tuple[Any, Any]:
        """Propose a new state for every walker and accept or keep the old one.

        Returns
        -------
        accepted : ndarray of bool
            ``(n_walkers,)``.
        """
        walkers = len(state.coords)
        coords, log_q, log_prob = self._next(model, walkers)
        log_q_now = self._log_q(state.coords)
        log_ratio = log_prob - state.log_prob + log_q_now - log_q
        accepted = np.log(self.rng.random(walkers)) < log_ratio
        # emcee's State has no type information; its class is that of the one given.
        new = type(state)(coords, log_prob=log_prob)
        state = self.update(state, new, accepted)
        self._at = state.coords.copy(), np.where(accepted, log_q, log_q_now)
        return state, accepted

    def _next(self, model: Any, walkers: int) -> tuple[Array, Array, Array]:
        if not self._ahead or len(self._ahead[-1][1]) != walkers:
            ahead = self.ahead or min(STEPS_AHEAD, max(DRAWS_AHEAD // walkers, 1))
            coords = self.proposal.draw(self.rng, ahead * walkers)
            log_q = self.proposal.log_density(coords)
            log_prob, _ = model.compute_log_prob_fn(coords)
            parts = (np.split(values, ahead) for values in (coords, log_q, log_prob))
            self._ahead = list(zip(*parts, strict=True))
        return self._ahead.pop()

    def _log_q(self, coords: Array) -> Array:
        """Log density where the walkers are: remembered, unless another move moved them."""
        if self._at is not None and np.array_equal(self._at[0], coords):
            return self._at[1]
        return self.proposal.log_density(coords)
