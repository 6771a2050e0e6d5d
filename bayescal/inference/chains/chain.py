"""What sampling leaves: draws with their diagnostics, without the sampler.

What only reads draws need not wait for the sampler's import.
"""

from __future__ import annotations

from dataclasses import dataclass

from bayescal.arrays import Array
from bayescal.inference.chains.diagnostics import Diagnostics


@dataclass(frozen=True, eq=False)
class Chain:
    """Draws of emcee with their diagnostics.

    Attributes
    ----------
    draws : Array
        Reported parameters, ``(n_chains, n_draws, n_parameters)``; a walker of the
        independence move is a chain.
    theta : Array
        Sampled parameters, of the same shape.
    log_prob : Array
        Log of likelihood times prior, ``(n_chains, n_draws)``.
    diagnostics : tuple of Diagnostics
        Per reported parameter.
    acceptance : float
        Mean acceptance fraction.
    autocorrelation_time : float
        The largest over the reported parameters, steps.
    converged : bool
        Whether the stopping rule was met.
    """

    draws: Array
    theta: Array
    log_prob: Array
    diagnostics: tuple[Diagnostics, ...]
    acceptance: float
    autocorrelation_time: float
    converged: bool
