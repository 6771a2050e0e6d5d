"""What draws say of a model: its evidence, and leave-one-out from them or from refits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.families import JointLeaveOneOut, JointModel, ModelName
from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.psis import good_k, thinned
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.weighting import WeightedDraws

# Share of the weight of all that one weighted draw may have: of its copies the tail that tells
# of a point left out would be made.
HEAVIEST = 0.02
LOO_DRAWS = 4000  # of a sampled model, at most twice as many
# The most points without which the evidence is worth having.
MOST_REFITS = 20
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
    value, error = posterior.log_evidence, posterior.log_evidence_error
    return Found(value, error, _leave_one_out(shortened(posterior), left_out, value, without),
                 posterior)  # fmt: skip


def from_weighted(draws: WeightedDraws, left_out: LeftOut, without: Without | None = None) -> Found:
    """Find the same by importance sampling alone."""
    estimate, loo = from_weights(draws.log_weights), None
    value, error = estimate.log_evidence, estimate.error
    if float(softmax(draws.log_weights).max()) <= HEAVIEST:
        loo = _leave_one_out(draws.full, left_out, value, without)
    return Found(value, error, loo, weighted=draws, doubts=estimate.warnings)


def shortened(posterior: SampledPosterior) -> Array:
    """Completed draws, every so many of them, ``(n, n_full)``."""
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    return full[:: max(1, len(full) // LOO_DRAWS)]


def _leave_one_out(
    draws: Array, left_out: LeftOut, log_evidence: float, without: Without | None
) -> JointLeaveOneOut | None:
    """Leave each point out by the weights of the draws.

    Where a point's weights have too heavy a tail, its term comes from the evidence `without`
    it, if that is to be had: ln p(t_i | the others) = ln Z - ln Z_-i.
    """
    kept = thinned(draws, left_out(draws[:1]).shape[1])
    if kept is None:
        return None
    pointwise, _, shape = psis_loo(left_out(kept).T)
    limit, refitted = good_k(len(kept)), []
    heavy = np.flatnonzero(~(shape < limit)).tolist()
    if without is not None and len(heavy) <= MOST_REFITS:
        for i in heavy:
            rest = without(i)
            if rest.certain:
                pointwise[i] = log_evidence - rest.log_evidence
                refitted.append(i)
    return leave_one_out_of(pointwise, np.delete(shape, refitted), limit, tuple(refitted))


def leave_one_out_of(
    pointwise: Array, shape: Array, limit: float, refitted: tuple[int, ...] = ()
) -> JointLeaveOneOut | None:
    """Collect terms and shapes of weights; None where too few draws count to tell of a point."""
    if not np.isfinite(pointwise).all():
        return None
    return JointLeaveOneOut(frozen(pointwise), float(shape.max(initial=0.0)), limit, refitted)


def judged_model(
    name: ModelName,
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
