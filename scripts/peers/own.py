"""The program's own runs: as it does it, at many walkers, and drawing from the closed form."""

from __future__ import annotations

from functools import partial

import numpy as np

from bayescal.inference.chains.move import IndependenceMove
from bayescal.inference.chains.sampling import autocorrelation_time, quiet_sampler
from bayescal.inference.checked_posterior import sample_posterior
from bayescal.inference.proposals.proposal import LinearProposal
from bayescal.inference.target import log_prob
from bayescal.linear.closed_form import exact_posterior
from scripts.peers.posterior import Posterior
from scripts.peers.sampled import Sampled


class Bayescal:
    """The program itself: closed form, emcee with an independence move, diagnosed and checked."""

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:
        """Sample as `compare` does."""
        found = sample_posterior(self.model, np.random.default_rng(seed), ess)
        chain = found.chain
        size = min(min(d.ess_bulk, d.ess_tail) for d in chain.diagnostics)
        rhat = max(d.rhat for d in chain.diagnostics)
        return Sampled(size, rhat, found.log_evidence, found.log_evidence_error)


class Thousand:
    """The closed form and the independence move alone, at 1000 walkers, for as many draws."""

    walkers, steps = 1000, 400

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - a length of its own
        """Sample; 64 walkers say how the others are."""
        model, rng = self.model, np.random.default_rng(seed)
        exact = exact_posterior(model)
        proposal = LinearProposal(exact)
        start = proposal.draw(rng, self.walkers)
        move = IndependenceMove(proposal, rng)
        sampler = quiet_sampler(self.walkers, start.shape[1], partial(log_prob, model), move)
        sampler.run_mcmc(start, self.steps, skip_initial_state_check=True)
        some = sampler.get_chain()[:, :64].swapaxes(0, 1)
        times = [autocorrelation_time(some[:, :, j]) for j in range(some.shape[2])]
        found, error = exact.log_evidence, exact.log_evidence_error
        return Sampled(self.walkers * self.steps / max(times), None, found, error)


class Direct:
    """The closed form and independent draws of it by numpy: nothing is sampled."""

    draws, together = 400_000, 40_000

    def __init__(self, posterior: Posterior) -> None:
        self.model = posterior.linear

    def run(self, seed: int, ess: int) -> Sampled:  # noqa: ARG002 - a length of its own
        """Draw."""
        rng, exact = np.random.default_rng(seed), exact_posterior(self.model)
        proposal = LinearProposal(exact)
        for _ in range(self.draws // self.together):
            proposal.draw(rng, self.together)
        return Sampled(self.draws, None, exact.log_evidence, exact.log_evidence_error)
