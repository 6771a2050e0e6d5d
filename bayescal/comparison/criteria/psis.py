"""Leave-one-out from the draws: importance sampling, and evidences without a unit beside it.

Vehtari, Simpson, Gelman, Yao & Gabry 2024, J. Mach. Learn. Res. 25(72).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.estimate import EvidenceEstimate

# Log densities held at once, those worked on at once, and the fewest draws worth it.
NUMBERS, BLOCK = 20_000_000, 2_000_000
FEWEST_DRAWS = 400
ENOUGH = 4000  # draws, at most twice as many
GOOD_K = 0.7
# Pareto k from which a unit's term comes from the evidence without it, of so many units at most.
# Good k are below 0.7; but terms between these were too high, together by half a nat.
REFITTED, MOST_REFITS = 0.4, 20

# Log density of each unit given draws, and given the other units where these say more.
LeftOut: TypeAlias = Callable[[Array], Array]
# Evidence without a unit.
Without: TypeAlias = Callable[[int], EvidenceEstimate]


class Drawn(Protocol):
    """What leave-one-out needs of draws, sampled or weighted."""

    @property
    def completed(self) -> Array:
        """Completed draws, ``(n_draws, n_full)``."""
        ...

    @property
    def effective(self) -> float:
        """Number of independent draws that they are worth."""
        ...

    @property
    def estimate(self) -> EvidenceEstimate | None:
        """Evidence from draws; None where it has a closed form."""
        ...


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of a model whose evidence has a closed form, as `Drawn`."""

    completed: Array
    effective: float
    estimate: None = None


def sampled_leave_one_out(
    drawn: Drawn, left_out: LeftOut, without: Without | None = None, numbers: int = NUMBERS
) -> LeaveOneOut | None:
    """Leave each unit out by the weights of the draws.

    Where a unit's weights have a heavy tail, its term comes from the evidence `without` it, if
    that can be computed, and that of all is certain: ln p(t_i | the others) = ln Z - ln Z_-i.
    None where the units are too many, too few, or the draws can't tell of one. At most so many
    log densities are looked at: `numbers` of them.
    """
    units = left_out(drawn.completed[:1]).shape[1]
    draws = thinned(drawn.completed, units, numbers)
    if draws is None or units < 2:
        return None
    density = _densities(left_out, draws, units)
    if not np.isfinite(density).all():
        return None
    pointwise, shape, shared, apart = _smoothed(density)
    refitted, variance, whole = [], 0.0, drawn.estimate
    if without is not None and whole is not None and whole.certain:
        heavy = np.flatnonzero(shape >= REFITTED)
        for i in heavy[np.argsort(-shape[heavy], kind="stable")].tolist()[:MOST_REFITS]:
            rest = without(i)
            if rest.certain:
                pointwise[i], shape[i] = whole.log_evidence - rest.log_evidence, -np.inf
                variance += rest.error**2
                refitted.append(i)
        # Refitted terms share the error of the whole, the others their draws.
        variance += (len(refitted) * whole.error) ** 2
    if not np.isfinite(pointwise).all():
        return None
    shared += sum(row for i, row in apart.items() if i not in refitted)
    # Dependent draws are worth fewer independent ones; the mcse counts them as such.
    variance += float(shared @ shared) / min(1.0, drawn.effective / len(draws))
    inside = math.fsum(logsumexp(row) - math.log(len(draws)) for row in density)
    return LeaveOneOut(
        frozen(pointwise),
        inside - float(pointwise.sum()),
        tuple(sorted(refitted)),
        frozen(shape),
        good_k(len(draws)),
        math.sqrt(variance),
    )


def _densities(left_out: LeftOut, draws: Array, units: int) -> Array:
    """Log density of each unit at each draw, ``(n_units, n_draws)``; few draws at a time."""
    out = np.empty((units, len(draws)))
    step = max(1, BLOCK // units)
    for start in range(0, len(draws), step):
        part = slice(start, start + step)
        out[:, part] = left_out(draws[part]).T
    return out


def _smoothed(density: Array) -> tuple[Array, Array, Array, dict[int, Array]]:
    """Leave units out, few at a time.

    Returns
    -------
    pointwise, shape : Array
        Terms and Pareto k, ``(n_units,)``.
    shared : Array
        Sum of the draws' influences on the terms of good k, ``(n_draws,)``.
    apart : dict of int to Array
        Those on the others, ``(n_draws,)`` by unit.
    """
    terms, shapes, shared = [], [], np.zeros(density.shape[1])
    apart: dict[int, Array] = {}
    step = max(1, BLOCK // density.shape[1])
    for start in range(0, len(density), step):
        found = psis_loo(density[start : start + step])
        shape = np.where(np.isfinite(found.pareto_k), found.pareto_k, np.inf)
        heavy = shape >= REFITTED
        shared += found.influence[~heavy].sum(axis=0)
        apart |= {start + i: found.influence[i] for i in np.flatnonzero(heavy).tolist()}
        terms.append(found.pointwise)
        shapes.append(shape)
    return np.concatenate(terms), np.concatenate(shapes), shared, apart


def of_both(r: LeaveOneOut, c: LeaveOneOut) -> LeaveOneOut:
    """Leave-one-out of two axes that have nothing in common: a unit is r and c of a point."""
    shapes = [loo.pareto_k for loo in (r, c) if loo.pareto_k is not None]
    limits = [loo.k_limit for loo in (r, c) if loo.k_limit is not None]
    return LeaveOneOut(
        frozen(r.pointwise + c.pointwise),
        None if r.p_eff is None or c.p_eff is None else r.p_eff + c.p_eff,
        tuple(sorted({*r.refitted, *c.refitted})),
        frozen(np.max(shapes, axis=0)) if shapes else None,
        min(limits, default=None),
        math.hypot(r.mcse, c.mcse),
    )


def thinned(draws: Array, units: int, numbers: int = NUMBERS) -> Array | None:
    """Every so many of the draws, ``(n, ...)``: enough, and so few that all units fit into memory.

    None where fewer than 400 would.
    """
    room = numbers // units
    if room < FEWEST_DRAWS:
        return None
    enough = draws[:: max(1, len(draws) // ENOUGH)]
    return enough[:: -(-len(enough) // room)]


def good_k(draws: int) -> float:
    """Pareto k below which a weight's tail is good, min(1 - 1 / log10 S, 0.7)."""
    return min(1 - 1 / math.log10(draws), GOOD_K)
