"""What a comparison assumed and what it can't vouch for, in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import behind_notes, point_notes

# Posterior mass of sigma near a bound that is worth a caveat.
PILE = 0.01
# Posterior mean of the bad fraction above which "bad" is no exception.
MANY_BAD = 0.35
# Combined Monte Carlo errors within which a lead is none.
ERRORS = 3.0


def caveats(results: Sequence[OrderResult], noise: NoiseLevel) -> list[str]:
    """Say what the comparison of the orders of one axis can't vouch for."""
    found = []
    exact = [str(r.order) for r in results if r.fit.exact]
    if exact:
        found.append(
            f"order {', '.join(exact)} fits exactly (residuals are rounding): "
            "likelihood criteria do not exist"
        )
    if noise.bounds is not None:
        found += [line for result in results for line in _at_bounds(result, noise, noise.bounds)]
    failed = [str(r.order) for r in results if not r.posterior.converged]
    if failed:
        found.append(f"sampling of order {', '.join(failed)} did not reach the stopping rule")
    found += [
        f"the evidence of order {r.order} should not be trusted: {'; '.join(r.warnings)}"
        for r in results
        if r.warnings
    ]
    wrong = [str(r.order) for r in results if r.posterior.agrees_with_exact is False]
    if wrong:
        found.append(
            f"the draws of order {', '.join(wrong)} disagree with the closed form beyond Monte "
            "Carlo error: an error of the program"
        )
    return found + sampled_caveats(results, noise)


def _at_bounds(
    result: OrderResult, noise: NoiseLevel, bounds: tuple[float, float]
) -> Iterator[str]:
    masses = result.posterior.at_bounds(noise.parameter, bounds)
    for side, bound, mass in zip(("lower", "upper"), bounds, masses, strict=True):
        if mass > PILE:
            yield (
                f"order {result.order}: {100 * mass:.0f} % of sigma's posterior lies at "
                f"its {side} bound, {bound:.4g} px; the evidence depends on that bound"
            )


def sampled_caveats(results: Sequence[OrderResult], noise: NoiseLevel) -> list[str]:
    """Say where a lead is within Monte Carlo error, or bad points are no exception any more."""
    found = []
    by_evidence = sorted(results, key=lambda r: -(r.log_evidence or 0.0))
    best = by_evidence[0]
    if best.exact is not None:
        return []
    if len(results) > 1:
        second = by_evidence[1]
        error = math.hypot(best.log_evidence_error or 0.0, second.log_evidence_error or 0.0)
        if (best.log_evidence or 0.0) - (second.log_evidence or 0.0) < ERRORS * error:
            found.append(
                f"the lead of order {best.order} over order {second.order} is within "
                f"the Monte Carlo error of their evidences, {error:.2g} nat"
            )
    if best.key.noise == "student-t" and noise.bounds is None:
        found.append(
            "the known sigma, a standard deviation, is taken as the scale of the t, whose own "
            "standard deviation is sqrt(nu / (nu - 2)) times larger; --sigma inferred assumes less"
        )
    if "bad_fraction" in best.posterior.names:
        share = best.posterior["bad_fraction"].mean
        if share > MANY_BAD:
            found.append(
                f"{100 * share:.0f} % of the points are bad under the mixture, "
                "whose bound is 50 %: bad is no exception here, and the labels may mean little"
            )
    return found


def notes(points: Correspondences, axes: Iterable[AxisComparison]) -> tuple[str, ...]:
    """Say what is odd about the points, and what was assumed because nobody said otherwise."""
    return (
        *point_notes(points),
        *behind_notes(points),
        *(
            f"{axis.data.axis}: the image size is not known; the span of the pixels, "
            f"{axis.data.size:g} px, stands for it in the prior"
            for axis in axes
            if not axis.data.size_known
        ),
    )
