"""What stands against a comparison of lenses: one function each, one line where they are listed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.special import chdtrc

from bayescal.calibration.judging.laplace import degrees
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.misfit import GRAVE
from bayescal.comparison.lenses.caveats.bounds import sigma_bound, tau_bound
from bayescal.comparison.lenses.caveats.gross import many_bad, points_off
from bayescal.comparison.lenses.caveats.views import (
    by_place,
    cover,
    drift,
    few_views,
    loud_views,
    parallel,
    sigma_unusual,
    undetermined,
    wider,
)
from bayescal.comparison.lenses.results import Evidenced
from bayescal.rounding import counted


def lens_findings(basis: Evidenced) -> list[Finding]:
    """All findings that apply."""
    return [found for make in FINDINGS if (found := make(basis)) is not None]


def untrusted(basis: Evidenced) -> Finding | None:
    """Evidences that their own diagnostics speak against."""
    broken = [
        f"{j.name} ({j.warnings[0]})" for j in basis.lenses if j.warnings and j.probability > 1e-3
    ]
    if not broken:
        return None
    text = f"the evidence of {', '.join(broken)} should not be trusted"
    return overturns("evidence", text, "an evidence should not be trusted")


def unconverged(basis: Evidenced) -> Finding | None:
    """Draws that did not reach the rule."""
    if basis.posterior.converged:
        return None
    text = f"the draws of emcee of {basis.best.name} did not converge"
    return overturns("convergence", text, "its draws did not converge")


def failed(basis: Evidenced) -> Finding | None:
    """Fits worse than those of a model they contain, or that no posterior was found about."""
    if not basis.failures:
        return None
    return overturns(
        "optimiser",
        f"the optimiser failed for {', '.join(basis.failures)}: fits stayed worse than those of "
        "lenses they contain, or no draw met the posterior",
        f"the optimiser failed for {', '.join(basis.failures)}",
    )


def edge(basis: Evidenced) -> Finding | None:
    """Error models at the largest level offered."""
    best = basis.best.evidence.errors.nodes[0]
    levels = [
        name
        for name in basis.setting.grid.at_edge(best)
        if name != "length" or basis.setting.grid.error(best).length < 2
    ]
    if not levels:
        return None
    return overturns(
        "errors-edge",
        f"the error model is at the largest level tried ({', '.join(levels)}): look for a lens "
        "that fits, or a better target",
        "the error model is at the largest level tried",
    )


def chi_squared(basis: Evidenced) -> Finding | None:
    """Find residuals too large for the known sigma, under the most probable error model."""
    sigma, problem = basis.setting.level.sigma, basis.problem
    if sigma is None:
        return None
    # Offsets of the target have normal priors: they take no degrees of freedom.
    dof = degrees(problem.data) - problem.model.dimension
    value = problem.reduced.sum_of_squares / sigma**2
    if chdtrc(dof, value) >= GRAVE:
        return None
    return overturns(
        "chi-squared",
        f"chi-squared rejects {basis.best.name} at the known sigma (chi2/dof {value / dof:.3g}, "
        "shared errors allowed for): sigma is stated too small, or no lens compared is the right "
        "one",
        "it does not describe the points to within the known sigma",
    )


def folds(basis: Evidenced) -> Finding | None:
    """Find a lens that turns back, or has a pole, before the image's corner."""
    size = basis.setting.data.size
    corners = np.array([[0, 0], [size[0] - 1, 0], [0, size[1] - 1], [size[0] - 1, size[1] - 1]])
    _, found = basis.best.view.rays(corners.astype(np.float64))
    if found.all():
        return None
    return limits(
        "fold",
        f"{basis.best.name} turns back before {counted(int(np.sum(~found)), 'corner')} of the "
        "image: no ray is seen there",
    )


def influence(basis: Evidenced) -> Finding | None:
    """Name views without which another lens would win."""
    if len(basis.lenses) < 2:
        return None
    first, second = basis.lenses[:2]
    if first.loo is None or second.loo is None:
        return None
    lead = first.log_evidence - second.log_evidence
    without = lead - (first.loo.pointwise - second.loo.pointwise)
    deciding = np.flatnonzero(without < 0)
    if not len(deciding):
        return None
    names = ", ".join(basis.views.names[v] for v in deciding[:4])
    more = f" and {len(deciding) - 4} more" if len(deciding) > 4 else ""
    alone = " (each alone)" if len(deciding) > 1 else ""
    return overturns(
        "influence",
        f"without view {names}{more}{alone} {second.name} would win over {first.name}",
        f"with one view left out {second.name} would win",
    )


def views_disagree(basis: Evidenced) -> Finding | None:
    """Find a lens that predicts new views better than the most probable one."""
    best = basis.best
    if best.loo is None:
        return None
    for judged in basis.lenses[1:]:
        if judged.loo is None:
            continue
        gain = judged.loo.pointwise - best.loo.pointwise
        total, se = float(gain.sum()), float(gain.std(ddof=1)) * math.sqrt(len(gain))
        if total > 4 and total > 2 * se:
            return limits(
                "leave-one-out",
                f"leaving views out prefers {judged.name} (by {total:.1f} ± {se:.1f} nat), though "
                f"{best.name} is more probable",
            )
    return None


FINDINGS: tuple[Callable[[Evidenced], Finding | None], ...] = (
    untrusted,
    unconverged,
    failed,
    chi_squared,
    points_off,
    many_bad,
    few_views,
    parallel,
    undetermined,
    folds,
    edge,
    sigma_bound,
    tau_bound,
    sigma_unusual,
    loud_views,
    by_place,
    drift,
    wider,
    influence,
    views_disagree,
    cover,
)
