"""What draws say of a model: its evidence, and leave-one-out from them or from refits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.families.results import JointLeaveOneOut, JointModel
from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.key import Key
from bayescal.comparison.psis import good_k, thinned
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.weighting import WeightedDraws

# Share of the weight of all that one weighted draw may have: of its copies the tail that tells
# of a point left out would be made.
HEAVIEST = 0.02
LOO_DRAWS = 4000  # of a sampled model, at most twice as many
# Pareto k from which a point's term comes from the evidence without it, of so many points at most.
# Good k are below 0.7; but terms between these were too high, together by half a nat.
REFITTED, MOST_REFITS = 0.4, 20
# Log density of each point given draws, and given the other points where these say more.
LeftOut = Callable[[Array], Array]
# Evidence without a point.
Without = Callable[[int], EvidenceEstimate]


@dataclass(frozen=True, eq=False)
class Found:
    """What draws say of a model: chains, or weighted draws where it was not sampled."""

    log_evidence: float
    error: float
    loo: JointLeaveOneOut | None
    posterior: SampledPosterior | None = None
    weighted: WeightedDraws | None = None
    doubts: tuple[str, ...] = ()


def from_posterior(
    posterior: SampledPosterior, left_out: LeftOut, without: Without | None = None
) -> Found:
    """Evidence and leave-one-out of a sampled model."""
    draws, estimate = shortened(posterior), posterior.estimate
    effective = min(p.ess_bulk for p in posterior.parameters)
    loo = _leave_one_out(draws, effective, left_out, estimate, without)
    return Found(estimate.log_evidence, estimate.error, loo, posterior)


def from_weighted(draws: WeightedDraws, left_out: LeftOut, without: Without | None = None) -> Found:
    """Find the same by importance sampling alone."""
    estimate, loo = from_weights(draws.log_weights), None
    if float(softmax(draws.log_weights).max()) <= HEAVIEST:
        effective = estimate.effective_fraction * estimate.draws
        loo = _leave_one_out(draws.full, effective, left_out, estimate, without)
    return Found(
        estimate.log_evidence, estimate.error, loo, weighted=draws, doubts=estimate.warnings
    )


def shortened(posterior: SampledPosterior) -> Array:
    """Completed draws, every so many of them, ``(n, n_full)``."""
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    return full[:: max(1, len(full) // LOO_DRAWS)]


def _leave_one_out(
    draws: Array,
    effective: float,
    left_out: LeftOut,
    whole: EvidenceEstimate,
    without: Without | None,
) -> JointLeaveOneOut | None:
    """Leave each point out by the weights of the draws, as many as `effective` independent ones.

    Where a point's weights have a heavy tail, its term comes from the evidence `without` it,
    if that is to be had, and that of the `whole` is certain:
    ln p(t_i | the others) = ln Z - ln Z_-i.
    """
    kept = thinned(draws, left_out(draws[:1]).shape[1])
    if kept is None:
        return None
    pointwise, influence, shape = psis_loo(left_out(kept).T)
    refitted, variance = [], 0.0
    if without is not None and whole.certain:
        heavy = np.flatnonzero(~(shape < REFITTED))
        for i in heavy[np.argsort(-shape[heavy], kind="stable")].tolist()[:MOST_REFITS]:
            rest = without(i)
            if rest.certain:
                pointwise[i] = whole.log_evidence - rest.log_evidence
                variance += rest.error**2
                refitted.append(i)
    # Refitted terms share the error of the whole, the others their draws.
    variance += (len(refitted) * whole.error) ** 2
    shared = np.delete(influence, refitted, axis=0).sum(axis=0)
    variance += float(shared @ shared) / min(1.0, effective / len(kept))
    left, limit = np.delete(shape, refitted), good_k(len(kept))
    return leave_one_out_of(pointwise, left, limit, math.sqrt(variance), tuple(sorted(refitted)))


def leave_one_out_of(
    pointwise: Array, shape: Array, limit: float, mcse: float, refitted: tuple[int, ...] = ()
) -> JointLeaveOneOut | None:
    """Collect terms and shapes of weights; None where too few draws count to tell of a point."""
    if not np.isfinite(pointwise).all():
        return None
    largest = float(shape.max(initial=0.0))
    return JointLeaveOneOut(frozen(pointwise), largest, limit, mcse, refitted)


def judged_model(
    name: Key,
    criteria: Criteria,
    found: Found,
    position: Array,
    goodness: GoodnessOfFit | None = None,
) -> JointModel:
    """Make a member of what was found."""
    return JointModel(
        name,
        criteria,
        found.log_evidence,
        found.error,
        found.loo,
        position,
        found.posterior,
        found.doubts,
        goodness=goodness,
        weighted=found.weighted,
    )
