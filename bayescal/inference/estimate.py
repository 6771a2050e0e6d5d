r"""Evidence from draws: importance sampling, checked by bridge sampling.

With draws theta_i of a normalised proposal q and weights w_i = p(theta_i) / q(theta_i),
p likelihood times prior, Z = mean(w) without bias. Bridge sampling (Meng & Wong 1996,
Statistica Sinica 6, 831, eq. 4.1) finds Z from draws of the posterior *and* of q: its
error does not explode where q misses part of the posterior, and so it shows what the
importance weights alone would hide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array
from bayescal.inference.pareto import pareto_shape

# An evidence less certain than this is marked wherever it is used, nat.
UNCERTAIN = 0.1
# Importance and bridge sampling may differ by this, nat: over five of their usual errors.
DISAGREEMENT = 0.05
LARGEST_K = 0.7
# Share of the evidence below which what a tail lacks, or what differs about a mode, is no warning:
# about as many nat.
NOTICEABLE = 0.01
HEAVIEST_TAIL = 0.9  # Pareto k that is reckoned with; at 1 the mean of a tail is infinite
SMALLEST_FRACTION = 0.02
BRIDGE_STEPS = 1000


@dataclass(frozen=True)
class EvidenceEstimate:
    """Log evidence of a sampled model, with what tells whether to trust it.

    Attributes
    ----------
    log_evidence : float
        Natural log, by importance sampling.
    error : float
        Its Monte Carlo standard error, nat.
    bridge, bridge_error : float
        The same by bridge sampling.
    effective_fraction : float
        (sum w)^2 / (n sum w^2) of the importance weights.
    pareto_k : float
        Shape of the weights' tail (Vehtari et al. 2024).
    draws : int
        Of the proposal.
    warnings : tuple of str
        Why the estimate should not be trusted; empty where it can be.
    """

    log_evidence: float
    error: float
    bridge: float
    bridge_error: float
    effective_fraction: float
    pareto_k: float
    draws: int
    warnings: tuple[str, ...]

    @property
    def certain(self) -> bool:
        """Whether nothing speaks against the estimate."""
        return not self.warnings


def estimate_evidence(
    log_weights: Array,
    log_weights_posterior: Array,
    effective: float,
    others: tuple[str, ...] = (),
) -> EvidenceEstimate:
    """Evidence from fresh draws of the proposal and draws of the posterior.

    Parameters
    ----------
    log_weights : Array
        ln p - ln q at draws of q, ``(n_draws,)``; -inf outside the support.
    log_weights_posterior : Array
        The same at draws of the posterior, ``(n_posterior,)``.
    effective : float
        Effective number of the posterior's draws.
    others : tuple of str, optional
        Warnings from elsewhere.
    """
    found = from_weights(log_weights)
    if not math.isfinite(found.log_evidence):
        return found
    log_z = found.log_evidence
    bridge, bridge_error = bridge_sampling(log_weights, log_weights_posterior, effective)
    warnings = [*others, *found.warnings]
    if not abs(bridge - log_z) <= DISAGREEMENT:
        warnings.append(f"bridge sampling gives {bridge:.2f}, importance sampling {log_z:.2f}")
    return replace(found, bridge=bridge, bridge_error=bridge_error, warnings=tuple(warnings))


def from_weights(log_weights: Array) -> EvidenceEstimate:
    """Evidence by importance sampling alone, which no bridge checks: that is left NaN.

    Parameters
    ----------
    log_weights : Array
        ln p - ln q at draws of q, ``(n_draws,)``; -inf outside the support.
    """
    n = len(log_weights)
    log_z = float(logsumexp(log_weights)) - math.log(n)
    if not math.isfinite(log_z):
        broken = ("no draw of the proposal met the posterior",)
        return EvidenceEstimate(log_z, math.inf, math.nan, math.inf, 0.0, math.inf, n, broken)
    relative = np.exp(log_weights - log_z)
    error = float(relative.std(ddof=1)) / math.sqrt(n)
    fraction = 1 / float(np.mean(relative**2))
    shape = pareto_shape(log_weights)
    warnings = []
    if not error <= UNCERTAIN:
        warnings.append(f"its Monte Carlo error is {error:.2g} nat, over {UNCERTAIN:g}")
    # Beyond the largest draw a tail of shape k still has about its share over 1 - k: among even
    # weights that is nothing.
    lacking = float(relative.max()) / n / (1 - min(shape, HEAVIEST_TAIL))
    if not shape <= LARGEST_K and lacking > NOTICEABLE:
        warnings.append(f"the Pareto k of its weights is {shape:.2f}, over {LARGEST_K:g}")
    if fraction < SMALLEST_FRACTION:
        warnings.append(f"{100 * fraction:.2g}% of the proposal's draws are effective")
    return EvidenceEstimate(log_z, error, math.nan, math.inf, fraction, shape, n, tuple(warnings))


def bridge_sampling(
    log_weights: Array, log_weights_posterior: Array, effective: float
) -> tuple[float, float]:
    """Log evidence by the optimal bridge, and its standard error.

    Parameters
    ----------
    log_weights : Array
        ln p - ln q at draws of q, ``(n,)``.
    log_weights_posterior : Array
        The same at draws of the posterior, ``(m,)``.
    effective : float
        Effective number of the latter.

    Returns
    -------
    log_evidence, error : float
        Error: relative (Fruehwirth-Schnatter 2004, Econometrics J. 7, 143, eq. 15).
    """
    n = len(log_weights)
    share = effective / (effective + n)  # of the posterior's draws
    log_z = float(np.median(log_weights_posterior))
    for _ in range(BRIDGE_STEPS):
        # ln of s1 w / (s1 w + s2 Z) and of 1 / (s1 w + s2 Z), without overflow.
        rest = math.log(1 - share) + log_z
        proposal = log_weights - np.logaddexp(math.log(share) + log_weights, rest)
        posterior = -np.logaddexp(math.log(share) + log_weights_posterior, rest)
        log_numerator = float(logsumexp(proposal)) - math.log(n)
        log_denominator = float(logsumexp(posterior)) - math.log(len(log_weights_posterior))
        before, log_z = log_z, log_numerator - log_denominator
        if abs(log_z - before) < 1e-10:
            break
    a, b = np.exp(proposal - log_numerator), np.exp(posterior - log_denominator)
    variance = float(a.var()) / n + float(b.var()) / max(effective, 1.0)
    return log_z, math.sqrt(variance)
