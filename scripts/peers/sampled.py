"""What a run of a peer gives, and when it is long enough."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.chains.diagnostics import diagnose
from scripts.peers.posterior import Posterior

RHAT = 1.01
BUDGET = 100.0  # seconds of processor time after which a run is not made longer


class Sampled(NamedTuple):
    """What a run gave: effective samples of the worst parameter, R-hat, evidence and its error."""

    ess: float
    rhat: float | None = None
    log_evidence: float | None = None
    error: float | None = None


class Sampler(Protocol):
    """A peer, prepared for a posterior."""

    def __init__(self, posterior: Posterior) -> None: ...

    def run(self, seed: int, ess: int) -> Sampled:
        """Sample until so many effective samples are there, where it can be told to."""
        ...


def of_chains(chains: Array) -> Sampled:
    """Bulk and tail ESS and R-hat of chains ``(chains, draws, dimension)``, the worst of each."""
    found = diagnose(chains)
    return Sampled(min(min(d.ess_bulk, d.ess_tail) for d in found), max(d.rhat for d in found))


def of_ensembles(chains: list[Array]) -> Sampled:
    """ESS by emcee's autocorrelation time, R-hat over ensembles ``(steps, walkers, dimension)``."""
    from emcee.autocorr import integrated_time

    size = math.inf
    for j in range(chains[0].shape[2]):
        each = [c[:, :, j].size / integrated_time(c[:, :, j], tol=0)[0] for c in chains]
        size = min(size, float(sum(each)))
    merged = np.array([c.reshape(-1, c.shape[2]) for c in chains])
    return Sampled(size, of_chains(merged).rhat)


def grown(more: Callable[[int], Sampled], first: int, ess: int) -> Sampled:
    """Go on, as many draws again each time, until a run has what is wanted of it."""
    begin, steps = time.process_time(), first
    found = more(steps)
    while found.ess < ess or (found.rhat or math.inf) >= RHAT:
        if time.process_time() - begin > BUDGET:
            break
        found = more(steps)
        steps *= 2
    return found
