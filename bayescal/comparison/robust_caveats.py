"""What a comparison under robust noise can't vouch for, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bayescal.comparison.caveats import common_caveats
from bayescal.comparison.results import OrderResult
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.posterior import Posterior
from bayescal.noise.level import NoiseLevel

# Posterior mean of the bad fraction above which "bad" is no exception.
MANY_BAD = 0.35
# Combined Monte Carlo errors within which a lead is none.
ERRORS = 3.0


def robust_caveats(results: Sequence[OrderResult], noise: NoiseLevel) -> list[str]:
    """Say what the comparison of one axis under robust noise can't vouch for.

    Parameters
    ----------
    results : sequence of OrderResult
    noise : NoiseLevel

    Returns
    -------
    list of str
    """
    return common_caveats(results, noise, _sigma_at_bounds) + sampled_caveats(results)


def _sigma_at_bounds(result: OrderResult) -> tuple[float, float]:
    posterior = result.posterior
    assert not isinstance(posterior, Posterior), "robust noise is sampled"
    assert isinstance(posterior.model, RobustLinearModel), "on an axis"
    theta = posterior.chain.theta.reshape(-1, posterior.model.dimension)
    return posterior.model.sigma_at_bounds(theta)


def sampled_caveats(results: Sequence[OrderResult]) -> list[str]:
    """Say where a lead is within Monte Carlo error, or bad points are no exception any more.

    Parameters
    ----------
    results : sequence of OrderResult
    """
    found = []
    by_evidence = sorted(results, key=lambda r: -(r.log_evidence or 0.0))
    best = by_evidence[0].posterior
    if isinstance(best, Posterior):
        return []
    if len(results) > 1:
        second = by_evidence[1]
        error = math.hypot(best.log_evidence_error, second.posterior.log_evidence_error or 0.0)
        if best.log_evidence - (second.log_evidence or 0.0) < ERRORS * error:
            found.append(
                f"the lead of order {by_evidence[0].order} over order {second.order} is within "
                f"the Monte Carlo error of their evidences, {error:.2g} nat"
            )
    if isinstance(best.model, RobustLinearModel) and _sd_as_scale(best.model):
        found.append(
            "the known sigma, a standard deviation, is taken as the scale of the t, whose own "
            "standard deviation is sqrt(nu / (nu - 2)) times larger; --sigma inferred assumes less"
        )
    if "bad_fraction" in best.names and best["bad_fraction"].mean > MANY_BAD:
        found.append(
            f"{100 * best['bad_fraction'].mean:.0f} % of the points are bad under the mixture, "
            "whose bound is 50 %: bad is no exception here, and the labels may mean little"
        )
    return found


def _sd_as_scale(model: RobustLinearModel) -> bool:
    """Whether a known standard deviation stands for the scale of Student-t noise."""
    return model.noise.name == "student-t" and not model.infers_sigma
