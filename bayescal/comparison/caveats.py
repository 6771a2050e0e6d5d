"""What a comparison assumed and what it can't vouch for, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.inference.posterior import Posterior
from bayescal.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.points.notes import behind_notes, point_notes

# Posterior mass of sigma near a bound that is worth a caveat.
PILE = 0.01


def caveats(results: Sequence[OrderResult], noise: NoiseLevel) -> list[str]:
    """Say what the comparison of one axis under Gaussian noise can't vouch for.

    Parameters
    ----------
    results : sequence of OrderResult
    noise : NoiseLevel

    Returns
    -------
    list of str
    """
    exact = {r.order: r.posterior for r in results if isinstance(r.posterior, Posterior)}
    found = common_caveats(results, noise, lambda r: exact[r.order].exact.sigma_at_bounds())
    wrong = [str(k) for k, posterior in exact.items() if not posterior.agrees_with_exact]
    if wrong:
        found.append(
            f"the draws of order {', '.join(wrong)} disagree with the closed form beyond Monte "
            "Carlo error: an error of the program"
        )
    return found


def common_caveats(
    results: Sequence[OrderResult],
    noise: NoiseLevel,
    sigma_at_bounds: Callable[[OrderResult], tuple[float, float]],
) -> list[str]:
    """Say what a comparison can't vouch for under any noise.

    Parameters
    ----------
    results : sequence of OrderResult
    noise : NoiseLevel
    sigma_at_bounds : callable
        Posterior probability that sigma lies near its lower, upper bound.

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
                ("lower", "upper"), noise.bounds, sigma_at_bounds(result), strict=True
            ):
                if mass > PILE:
                    found.append(
                        f"order {result.order}: {100 * mass:.0f} % of sigma's posterior lies at "
                        f"its {side} bound, {bound:.4g} px; the evidence depends on that bound"
                    )
    failed = [str(r.order) for r in results if not r.posterior.converged]
    if failed:
        found.append(f"sampling of order {', '.join(failed)} did not reach the stopping rule")
    found += [
        f"the evidence of order {r.order} should not be trusted: {'; '.join(r.evidence_warnings)}"
        for r in results
        if r.evidence_warnings
    ]
    return found


def notes(points: Correspondences, axes: Iterable[AxisComparison]) -> tuple[str, ...]:
    """Say what is odd about the points, and what was assumed because nobody said otherwise.

    Parameters
    ----------
    points : Correspondences
    axes : iterable of AxisComparison

    Returns
    -------
    tuple of str
    """
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
