"""Where draws or evidences can't be trusted, and where labels or leads mean little."""

from __future__ import annotations

import math
from collections.abc import Iterator

from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.case import Case

# Posterior mean of the bad fraction above which "bad" is no exception.
MANY_BAD = 0.35
# Combined Monte Carlo errors within which a lead is none.
ERRORS = 3.0


def sampling(case: Case) -> Iterator[Finding]:
    """Find draws that failed their checks, and evidences that should not be trusted."""
    results = case.results
    wrong = [str(r.order) for r in results if r.posterior.agrees_with_exact is False]
    if wrong:
        yield overturns(
            "draws",
            f"the draws of order {', '.join(wrong)} disagree with the closed form beyond Monte "
            "Carlo error: an error of the program",
            "draws disagree with the closed form",
        )
    exact = [str(r.order) for r in results if r.fit.exact]
    if exact:
        yield limits(
            "exact-fit",
            f"order {', '.join(exact)} fits exactly (residuals are rounding): "
            "likelihood criteria do not exist",
        )
    failed = [str(r.order) for r in results if not r.posterior.converged]
    if failed:
        yield limits(
            "convergence", f"sampling of order {', '.join(failed)} did not reach the stopping rule"
        )
    for r in results:
        if r.warnings:
            why = "; ".join(r.warnings)
            yield limits(
                "evidence", f"the evidence of order {r.order} should not be trusted: {why}"
            )


def sampled(case: Case) -> Iterator[Finding]:
    """Find leads within Monte Carlo error, and bad points that are no exception any more."""
    by_evidence = sorted(case.results, key=lambda r: -(r.log_evidence or 0.0))
    best = by_evidence[0]
    if best.exact is not None:
        return
    if len(by_evidence) > 1:
        second = by_evidence[1]
        error = math.hypot(best.log_evidence_error or 0.0, second.log_evidence_error or 0.0)
        if (best.log_evidence or 0.0) - (second.log_evidence or 0.0) < ERRORS * error:
            yield limits(
                "lead",
                f"the lead of order {best.order} over order {second.order} is within "
                f"the Monte Carlo error of their evidences, {error:.2g} nat",
            )
    if best.key.noise == "student-t" and case.axis.noise.bounds is None:
        yield limits(
            "scale",
            "the known sigma, a standard deviation, is taken as the scale of the t, whose own "
            "standard deviation is sqrt(nu / (nu - 2)) times larger; --sigma inferred assumes less",
        )
    if "bad_fraction" in best.posterior.names:
        share = best.posterior["bad_fraction"].mean
        if share > MANY_BAD:
            yield limits(
                "bad-fraction",
                f"{100 * share:.0f}% of the points are bad under the mixture, "
                "whose bound is 50%: bad is no exception here, and the labels may mean little",
            )
