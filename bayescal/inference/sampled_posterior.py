"""Posterior and evidence of a model without a closed form."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.inference.chains.chain import Chain
from bayescal.inference.estimate import (
    NOTICEABLE,
    EvidenceEstimate,
    estimate_evidence,
    from_weights,
)
from bayescal.inference.optimum import Mode, find_modes
from bayescal.inference.posterior import Summarised, summarise
from bayescal.inference.proposals.adaptation import Adapted, adapt, refine
from bayescal.inference.proposals.coordinates import Whitening
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.t_mixture import TMixture, cholesky
from bayescal.inference.weighting import drawn

EVIDENCE_DRAWS = 20_000
# Where a chain does not converge, its evidence can't be trusted or rests on a smaller fraction of
# the draws than this, the proposal is fitted to that chain's draws, and all is done once more.
FITTED = 0.2
# A mode's share by draws and by weights differs noticeably from here on, and where a parameter's
# variance by the draws would be so many times NOTICEABLE off.
LEAST, WIDENED = 1e-3, 10.0


@dataclass(frozen=True, eq=False)
class Guess:
    """A proposal that knows a model's shape, and the modes it comes from, the highest first."""

    proposal: TMixture
    modes: tuple[Mode, ...]


@dataclass(frozen=True, eq=False, repr=False)
class SampledPosterior(Summarised):
    """Posterior of a sampled model: draws of emcee and an estimate of the evidence.

    Attributes
    ----------
    full : Array
        Completed draws, ``(n_chains, n_draws, n_full)``.
    modes : tuple of Mode
        The highest first.
    """

    model: SampledModel
    full: Array
    estimate: EvidenceEstimate
    modes: tuple[Mode, ...]

    @property
    def exact(self) -> None:
        """There is no closed form."""
        return

    @property
    def agrees_with_exact(self) -> None:
        """There is nothing to agree with."""
        return

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the evidence should not be trusted; empty where it can be."""
        return self.estimate.warnings

    @property
    def sound(self) -> bool:
        """Whether the draws converged and the evidence can be trusted."""
        return self.converged and self.estimate.certain

    @property
    def completed(self) -> Array:
        """Completed draws one after the other, ``(n_draws, n_full)``."""
        return self.full.reshape(-1, self.full.shape[2])

    @property
    def heaviest(self) -> float:
        """Share of all that one draw has."""
        return 1 / len(self.completed)

    @property
    def effective(self) -> float:
        """Fewest effective draws of a parameter."""
        return min(p.ess_bulk for p in self.parameters)

    @property
    def log_evidence(self) -> float:
        """Natural log of the evidence."""
        return self.estimate.log_evidence

    @property
    def log_evidence_error(self) -> float:
        """Monte Carlo standard error of the log evidence, nat."""
        return self.estimate.error


def sample_model(
    model: SampledModel,
    rng: np.random.Generator,
    ess: int,
    guess: Guess | None = None,
    evidence_draws: int = EVIDENCE_DRAWS,
    ladder: Callable[[Mode], tuple[Mode, ...]] | None = None,
) -> SampledPosterior:
    """Sample a model's posterior with emcee and estimate its evidence.

    Parameters
    ----------
    ess : int
        Effective samples wanted of every parameter.
    guess : Guess, optional
        By default a proposal is adapted to the density.
    evidence_draws : int, optional
        Draws of the proposal that the evidence is taken from.
    ladder : callable, optional
        From the highest mode to normals that the proposal holds beside the modes: those of the
        density at fixed values of what was integrated out.

    Raises
    ------
    InputError
        Where the density is zero at every start of the model.
    """
    for_proposal, for_first, for_second, for_refined, for_chosen = rng.spawn(5)
    if guess is None:
        modes, rungs = _found(model, ladder)
        adapted = adapt(model.log_prob, modes, for_proposal, rungs)
    else:
        proposal, modes, rungs = guess.proposal, guess.modes, ()
        # The last component spans the whole posterior.
        root = proposal.roots[-1]
        adapted = Adapted(proposal, proposal.means[-1], root @ root.T)
    first = _attempt(model, modes, adapted, for_first, ess, evidence_draws)
    if _soundness(first) >= (True, True, FITTED):
        return first
    draws = first.chain.theta.reshape(-1, model.dimension), first.chain.log_prob.ravel()
    refined = refine(model.log_prob, adapted, modes, draws, for_refined, rungs)
    second = _attempt(model, modes, refined, for_second, ess, evidence_draws)
    best, proposal = max(
        (first, adapted.proposal), (second, refined.proposal), key=lambda pair: _soundness(pair[0])
    )
    # Draws that the choice was made by would favour the proposal whose heavy weights they missed.
    estimate = _estimated(model, modes, proposal, best.chain, for_chosen, evidence_draws)
    return replace(best, estimate=estimate)


def evidence_of(
    model: SampledModel,
    rng: np.random.Generator,
    ess: int,
    ladder: Callable[[Mode], tuple[Mode, ...]] | None = None,
    evidence_draws: int = EVIDENCE_DRAWS,
) -> EvidenceEstimate:
    """Estimate the evidence alone: by weighted draws, or where these fit badly, as `sample_model`.

    Without chains, which take most of the time, no bridge checks the weights.
    """
    for_proposal, for_draws, for_model = rng.spawn(3)
    modes, rungs = _found(model, ladder)
    adapted = adapt(model.log_prob, modes, for_proposal, rungs)
    found = from_weights(drawn(model, adapted.proposal, for_draws, evidence_draws)[1])
    if found.certain and found.effective_fraction >= FITTED:
        return found
    return sample_model(model, for_model, ess, None, evidence_draws, ladder).estimate


def _found(
    model: SampledModel, ladder: Callable[[Mode], tuple[Mode, ...]] | None
) -> tuple[tuple[Mode, ...], tuple[Mode, ...]]:
    """Find the modes, the highest first, and normals to hold beside them."""
    modes = find_modes(model.log_prob, model.starts())
    if not modes:
        raise InputError("the likelihood is zero wherever the model could start; check the units")
    return modes, ladder(modes[0]) if ladder is not None else ()


def _soundness(found: SampledPosterior) -> tuple[bool, bool, float]:
    return found.converged, found.estimate.certain, found.estimate.effective_fraction


def _attempt(
    model: SampledModel,
    modes: tuple[Mode, ...],
    adapted: Adapted,
    rng: np.random.Generator,
    ess: int,
    evidence_draws: int,
) -> SampledPosterior:
    """Sample with one proposal, and estimate the evidence with it."""
    from bayescal.inference.chains.ensembles import sample_ensembles

    for_evidence, for_chains = rng.spawn(2)

    def finish(theta: Array, child: np.random.Generator) -> tuple[Array, Array]:
        full = model.complete(theta, child)
        return full, model.report(full)

    chain, full = sample_ensembles(
        model.log_prob,
        adapted.proposal,
        Whitening(adapted.mean, cholesky(adapted.covariance)),
        finish,
        for_chains,
        ess,
    )
    estimate = _estimated(model, modes, adapted.proposal, chain, for_evidence, evidence_draws)
    return SampledPosterior(chain, summarise(model.names, chain), model, full, estimate, modes)


def _estimated(
    model: SampledModel,
    modes: tuple[Mode, ...],
    proposal: TMixture,
    chain: Chain,
    rng: np.random.Generator,
    n: int,
) -> EvidenceEstimate:
    """Estimate the evidence from `n` fresh draws of a proposal, checked by those of a chain."""
    fresh, log_weights = drawn(model, proposal, rng, n)
    theta = chain.theta.reshape(-1, model.dimension)
    effective = min(min(d.ess_bulk, d.ess_tail) for d in chain.diagnostics)
    return estimate_evidence(
        log_weights,
        chain.log_prob.ravel() - proposal.log_density(theta),
        effective,
        shares_differ(modes, fresh, log_weights, theta, effective),
    )


def shares_differ(
    modes: tuple[Mode, ...],
    fresh: Array,
    log_weights: Array,
    theta: Array,
    effective: float,
) -> tuple[str, ...]:
    """Warn where the draws are shared among the modes otherwise than the weights say."""
    if len(modes) < 2 or not np.isfinite(log_weights).any():
        return ()
    nearest = [_nearest(modes, t) for t in (fresh, theta)]
    weights = softmax(log_weights)
    n_effective = 1 / float(weights @ weights)
    mean = weights @ fresh
    variance = weights @ (fresh - mean) ** 2
    for k, mode in enumerate(modes):
        expected = min(float(weights[nearest[0] == k].sum()), 1.0)  # rounding may exceed it
        drawn = float(np.mean(nearest[1] == k))
        gap = abs(drawn - expected)
        error = math.sqrt(expected * (1 - expected) * (1 / n_effective + 1 / effective))
        # What it changes: the evidence, or the variance of a parameter.
        changed = max(gap, gap * float(((mode.theta - mean) ** 2 / variance).max()) / WIDENED)
        if gap > 5 * error + LEAST and changed > NOTICEABLE:
            return (
                f"mode {k + 1} of {len(modes)} holds {100 * expected:.1f}% of the posterior by "
                f"its weights, {100 * drawn:.1f}% by the draws",
            )
    return ()


def _nearest(modes: tuple[Mode, ...], theta: Array) -> Array:
    """Mode of the Laplace approximation that each draw most probably belongs to."""
    distances = []
    for mode in modes:
        z = (theta - mode.theta) @ np.linalg.inv(mode.root).T
        distances.append((z**2).sum(axis=1) / 2 + np.log(np.diag(mode.root)).sum())
    return np.asarray(np.argmin(distances, axis=0))
