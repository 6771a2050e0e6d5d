"""What a comparison assumed and what it can't vouch for, in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.inference.posterior import Posterior
from bayescal.inference.robust_linear import RobustLinearModel
from bayescal.models.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences

# Posterior mass of sigma near a bound that is worth a caveat.
PILE = 0.01
# Posterior mean of the bad fraction above which "bad" is no exception.
MANY_BAD = 0.35
# Combined Monte Carlo errors within which a lead is none.
ERRORS = 3.0


def caveats(results: Sequence[OrderResult], noise: NoiseLevel) -> list[str]:
    """Say what the comparison of one axis can't vouch for.

    Parameters
    ----------
    results : sequence of OrderResult
    noise : NoiseLevel

    Returns
    -------
    list of str
    """
    found = []
    exact = [str(r.order) for r in results if r.fit.exact]
    if exact:
        found.append(
            f"order {', '.join(exact)} fits exactly (residuals are rounding): "
            "likelihood criteria do not exist"
        )
    if noise.bounds is not None:
        for result in results:
            for side, bound, mass in zip(
                ("lower", "upper"),
                noise.bounds,
                _sigma_at_bounds(result),
                strict=True,
            ):
                if mass > PILE:
                    found.append(
                        f"order {result.order}: {100 * mass:.0f} % of sigma's posterior lies at "
                        f"its {side} bound, {bound:.3g} px; the evidence depends on that bound"
                    )
    failed = [str(r.order) for r in results if not r.posterior.converged]
    if failed:
        found.append(f"sampling of order {', '.join(failed)} did not reach the stopping rule")
    found += [
        f"the evidence of order {r.order} should not be trusted: {'; '.join(r.evidence_warnings)}"
        for r in results
        if r.evidence_warnings
    ]
    found += sampled_caveats(results)
    wrong = [
        str(r.order)
        for r in results
        if isinstance(r.posterior, Posterior) and not r.posterior.agrees_with_exact
    ]
    if wrong:
        found.append(
            f"the draws of order {', '.join(wrong)} disagree with the closed form beyond Monte "
            "Carlo error: an error of the program"
        )
    return found


def _sigma_at_bounds(result: OrderResult) -> tuple[float, float]:
    """Posterior probability that sigma lies near its lower, upper bound."""
    posterior = result.posterior
    if isinstance(posterior, Posterior):
        return posterior.exact.sigma_at_bounds()
    model = posterior.model
    if not isinstance(model, RobustLinearModel):
        return 0.0, 0.0
    return model.sigma_at_bounds(posterior.chain.theta.reshape(-1, model.dimension))


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


def notes(points: Correspondences, axes: Iterable[AxisComparison]) -> tuple[str, ...]:
    """Say what was assumed because nobody said otherwise.

    Parameters
    ----------
    points : Correspondences
    axes : iterable of AxisComparison

    Returns
    -------
    tuple of str
    """
    setup = points.setup
    found = []
    if "position" in setup.assumed:
        found.append(f"camera position {setup.position} is assumed")
    found += [
        f"image {name} {getattr(setup, name):g} px is assumed"
        for name in ("width", "height")
        if name in setup.assumed
    ]
    for axis in axes:
        if not axis.data.size_known:
            found.append(
                f"{axis.data.axis}: the image size is not known; the span of the pixels, "
                f"{axis.data.size:g} px, stands for it in the prior"
            )
    behind = int((points.camera_frame()[:, 2] < 0).sum())
    if behind:
        found.append(f"{behind} of {len(points)} points lie behind the camera (z < 0)")
    return tuple(found)
