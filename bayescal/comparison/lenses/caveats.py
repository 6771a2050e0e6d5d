"""What stands against a comparison of lenses: one function each, one line where they are listed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from bayescal.comparison.lenses.results import Evidenced
from bayescal.comparison.lenses.view_caveats import (
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
from bayescal.rounding import counted


def lens_caveats(basis: Evidenced) -> tuple[str, ...]:
    """All caveats that apply, the gravest first."""
    return tuple(line for make in CAVEATS if (line := make(basis)) is not None)


def untrusted(basis: Evidenced) -> str | None:
    """Evidences that their own diagnostics speak against."""
    broken = [
        f"{j.name} ({j.warnings[0]})" for j in basis.lenses if j.warnings and j.probability > 1e-3
    ]
    return f"the evidence should not be trusted of {', '.join(broken)}" if broken else None


def unconverged(basis: Evidenced) -> str | None:
    """Draws that did not reach the rule."""
    return None if basis.posterior.converged else "the draws of emcee did not converge"


def failed(basis: Evidenced) -> str | None:
    """Fits worse than those of a model they contain."""
    if not basis.failures:
        return None
    return (
        f"the optimiser failed for {', '.join(basis.failures)}: fits stayed worse than those of "
        "lenses they contain"
    )


def edge(basis: Evidenced) -> str | None:
    """Error models at the largest level offered."""
    best = basis.best.evidence.errors.nodes[0]
    levels = [
        name
        for name in basis.setting.grid.at_edge(best)
        if name != "length" or basis.setting.grid.error(best).length < 2
    ]
    if not levels:
        return None
    return (
        f"the error model is at the largest level tried ({', '.join(levels)}): look for a lens "
        "that fits, or a better target"
    )


def folds(basis: Evidenced) -> str | None:
    """Find a lens that turns back, or has a pole, before the image's corner."""
    size = basis.setting.data.size
    corners = np.array([[0, 0], [size[0] - 1, 0], [0, size[1] - 1], [size[0] - 1, size[1] - 1]])
    _, found = basis.best.view.rays(corners.astype(np.float64))
    if found.all():
        return None
    return (
        f"{basis.best.name} turns back before {counted(int(np.sum(~found)), 'corner')} of the "
        "image: no ray is seen there"
    )


def influence(basis: Evidenced) -> str | None:
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
    return f"without view {names}{more}{alone} {second.name} would win over {first.name}"


def views_disagree(basis: Evidenced) -> str | None:
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
            return (
                f"leaving views out prefers {judged.name} (by {total:.1f} +- {se:.1f} nat), though "
                f"{best.name} is more probable"
            )
    return None


CAVEATS: tuple[Callable[[Evidenced], str | None], ...] = (
    untrusted,
    unconverged,
    failed,
    few_views,
    parallel,
    undetermined,
    folds,
    edge,
    sigma_unusual,
    loud_views,
    by_place,
    drift,
    wider,
    influence,
    views_disagree,
    cover,
)
