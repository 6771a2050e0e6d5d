"""The one place that talks to ArviZ, whatever its version.

ArviZ 1.x is made of arviz_base and arviz_stats; 0.23, the last for Python 3.11,
brings the same packages as its "preview". Both are used through those two names.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array


class Diagnostics(NamedTuple):
    """Convergence diagnostics of one parameter (Vehtari et al. 2021)."""

    rhat: float
    ess_bulk: float
    ess_tail: float
    ess_mean: float
    ess_sd: float


def diagnose(draws: Array) -> Diagnostics:
    """Rank-normalised split R-hat and effective sample sizes of one parameter.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws)``.
    """
    from arviz_stats.base import array_stats

    def ess(method: str, **options: float) -> float:
        value = array_stats.ess(draws, chain_axis=0, draw_axis=1, method=method, **options)
        return float(value)

    return Diagnostics(
        rhat(draws),
        ess("bulk"),
        ess("tail", prob=0.95),
        ess("mean"),
        ess("sd"),
    )


def rhat(draws: Array) -> float:
    """Rank-normalised split R-hat of one parameter.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws)``.
    """
    from arviz_stats.base import array_stats

    return float(array_stats.rhat(draws, chain_axis=0, draw_axis=1))


def autocovariance(draws: Array) -> Array:
    """Autocovariance of each chain at every lag.

    Parameters
    ----------
    draws : Array
        ``(n_chains, n_draws)``.

    Returns
    -------
    Array
        ``(n_chains, n_draws)``.
    """
    from arviz_stats.base import array_stats

    return np.asarray(array_stats.autocov(draws, axis=1))


def psis_loo(log_likelihood: Array) -> tuple[Array, Array, Array]:
    """Leave-one-out by Pareto-smoothed importance sampling from draws.

    Parameters
    ----------
    log_likelihood : Array
        ln p(t_i | draw), ``(n_points, n_draws)``.

    Returns
    -------
    elpd : Array
        Pointwise, ``(n_points,)``.
    mcse : Array
        Its Monte Carlo standard error, ``(n_points,)`` (Vehtari et al. 2024, eq. 6).
    pareto_k : Array
        Shape of the weights' tail, ``(n_points,)``.
    """
    from arviz_stats.base import array_stats

    # Where all weights of a tail are alike to rounding, its shape is no number: bad.
    with np.errstate(divide="ignore", invalid="ignore"):
        log_weights, pareto_k = array_stats.psislw(log_likelihood, axis=-1)
    log_weights = log_weights - logsumexp(log_weights, axis=-1, keepdims=True)
    elpd = np.asarray(logsumexp(log_weights + log_likelihood, axis=-1))
    # Both terms sum to 1 over the draws, so that neither can overflow.
    terms = np.exp(log_weights + log_likelihood - elpd[:, None]) - np.exp(log_weights)
    mcse = np.sqrt((terms**2).sum(axis=-1))
    return elpd, mcse, np.asarray(pareto_k)


def pareto_shape(log_weights: Array) -> float:
    """Pareto k of the upper tail of importance weights (Vehtari et al. 2024).

    Parameters
    ----------
    log_weights : Array
        ``(n_draws,)``; -inf for draws outside the support.

    Returns
    -------
    float
        inf where the tail has no shape.
    """
    from arviz_stats.base import array_stats

    # psislw smooths 1 / likelihood: the weights it is given are negated logs.
    finite = np.maximum(log_weights, log_weights.max() - 700.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        _, shape = array_stats.psislw(-finite, axis=-1)
    k = float(np.asarray(shape))
    return k if np.isfinite(k) else np.inf


def write_netcdf(
    path: Path,
    posterior: dict[str, Array],
    sample_stats: dict[str, Array],
    observed: dict[str, Array],
    attributes: dict[str, Any],
) -> None:
    """Write draws as NetCDF with ArviZ's groups.

    Parameters
    ----------
    path : Path
    posterior, sample_stats : dict of str to Array
        ``(n_chains, n_draws)`` each.
    observed : dict of str to Array
        Data, ``(n_points,)`` each.
    attributes : dict
        Written on the posterior group.
    """
    import arviz_base

    tree = arviz_base.from_dict(
        {"posterior": posterior, "sample_stats": sample_stats, "observed_data": observed}
    )
    tree["posterior"].attrs = attributes
    for name in ("sample_stats", "observed_data"):
        tree[name].attrs = {}
    # Made in memory first: HDF5 does not survive a disk that fills up under it.
    path.write_bytes(tree.to_netcdf(engine="h5netcdf"))
