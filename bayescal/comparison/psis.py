"""Leave-one-out from the draws, by Pareto-smoothed importance sampling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array, frozen
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.sampled_posterior import SampledPosterior

# Log densities held at once, and the fewest draws worth it.
NUMBERS = 20_000_000
FEWEST_DRAWS = 400
GOOD_K = 0.7


@dataclass(frozen=True, eq=False)
class SampledLeaveOneOut:
    """Expected log pointwise predictive density of a sampled model.

    Attributes
    ----------
    pointwise : Array
        elpd_i = ln p(unit i | all other units), ``(n_units,)``.
    elpd, se : float
        Sum, and sqrt(n) times the sd (n - 1) of the terms.
    p_eff : float
        Effective number of parameters: in-sample log predictive density less elpd.
    mcse : float
        Monte Carlo standard error of elpd.
    pareto_k : Array
        Shape of each unit's weights, ``(n_units,)``; inf where there is none.
    k_limit : float
        Good below it.
    """

    pointwise: Array
    elpd: float
    se: float
    p_eff: float
    mcse: float
    pareto_k: Array
    k_limit: float

    @property
    def unreliable(self) -> tuple[int, ...]:
        """Units whose Pareto k is not good, the worst first."""
        order = np.argsort(-self.pareto_k, kind="stable")
        return tuple(int(i) for i in order if self.pareto_k[i] >= self.k_limit)


def sampled_leave_one_out(posterior: SampledPosterior) -> SampledLeaveOneOut | None:
    """Leave each unit of data out of a sampled model, from its draws.

    Parameters
    ----------
    posterior : SampledPosterior

    Returns
    -------
    SampledLeaveOneOut or None
        None where the data are too many, a density is not finite, or there is only one
        unit.

    Notes
    -----
    Vehtari, Simpson, Gelman, Yao & Gabry 2024, J. Mach. Learn. Res. 25(72).
    """
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    units = posterior.model.log_likelihood(full[:1]).shape[1]
    kept = thinned(full, units)
    if kept is None or units < 2:
        return None
    log_likelihood = posterior.model.log_likelihood(kept).T
    if not np.isfinite(log_likelihood).all():
        return None
    found = psis_loo(log_likelihood)
    pointwise, shape = found.pointwise, found.pareto_k
    density = logsumexp(log_likelihood, axis=1) - math.log(len(kept))
    elpd = float(pointwise.sum())
    # Dependent draws are worth fewer independent ones; the mcse counts them as such.
    worth = min(1.0, min(p.ess_bulk for p in posterior.parameters) / len(full))
    return SampledLeaveOneOut(
        frozen(pointwise),
        elpd,
        math.sqrt(units) * float(pointwise.std(ddof=1)),
        float(density.sum()) - elpd,
        found.mcse_of_sum / math.sqrt(worth),
        frozen(np.where(np.isfinite(shape), shape, np.inf)),
        good_k(len(kept)),
    )


def thinned(draws: Array, units: int) -> Array | None:
    """Every so many of the draws, ``(n, ...)``, so that all units fit into memory.

    None where fewer than 400 would.
    """
    room = NUMBERS // units
    if room < FEWEST_DRAWS:
        return None
    return draws[:: -(-len(draws) // room)]


def good_k(draws: int) -> float:
    """Pareto k below which a weight's tail is good, min(1 - 1 / log10 S, 0.7)."""
    return min(1 - 1 / math.log10(draws), GOOD_K)
