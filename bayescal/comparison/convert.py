"""Results as other libraries hold them: data frames of pandas, trees of ArviZ."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.pointwise import gaussian_density
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import arviz_object

if TYPE_CHECKING:  # pandas is imported where somebody asks for it
    import pandas as pd

# An OrderResult, whose methods call what follows.
OrderResult: TypeAlias = Any
# Log densities of one order that are held at once.
LARGEST = 50_000_000


def orders_frame(orders: Iterable[tuple[str, OrderResult]]) -> pd.DataFrame:
    """Make a data frame with a row per axis and order; what is unavailable is NaN."""
    import pandas as pd

    rows = [
        {
            "axis": axis,
            "order": found.order,
            "p": len(found.fit.coefficients),
            "rss_px2": found.rss_px2,
            "sigma_hat": found.fit.sigma_hat,
            "chi2": found.goodness.chi2,
            "dof": found.fit.dof,
            "aic": found.criteria.aic,
            "aicc": found.criteria.aicc,
            "bic": found.criteria.bic,
            "log_evidence": found.log_evidence,
            "probability": found.probability,
            "elpd": None if found.loo is None else found.loo.elpd,
            "sound": found.sound,
        }
        for axis, found in orders
    ]
    return pd.DataFrame(rows).set_index(["axis", "order"]).infer_objects()


def parameters_frame(found: OrderResult) -> pd.DataFrame:
    """Make a data frame with a row per parameter: of the draws, and of the closed form."""
    import pandas as pd

    rows = [
        {
            "parameter": p.name,
            "mean": p.mean,
            "sd": p.sd,
            "lower": p.interval[0],
            "upper": p.interval[1],
            "mcse_mean": p.mcse_mean,
            "ess_bulk": p.ess_bulk,
            "ess_tail": p.ess_tail,
            "rhat": p.rhat,
            "exact_mean": np.nan if p.exact_mean is None else p.exact_mean,
            "exact_sd": np.nan if p.exact_sd is None else p.exact_sd,
        }
        for p in found.posterior.parameters
    ]
    return pd.DataFrame(rows).set_index("parameter")


def covariance_frame(found: OrderResult) -> pd.DataFrame:
    """Make a data frame of the posterior covariance of the reported parameters, of the draws."""
    import pandas as pd

    draws = found.posterior.chain.draws
    names = list(found.posterior.names)
    flat = draws.reshape(-1, draws.shape[2])
    return pd.DataFrame(np.atleast_2d(np.cov(flat.T)), index=names, columns=names)


def arviz_of(found: OrderResult) -> Any:
    """Hand draws, pointwise log likelihood and data to ArviZ.

    Raises
    ------
    InputError
        Where the log likelihood of all draws would not fit into memory.
    """
    posterior, data = found.posterior, found.data
    draws = posterior.chain.draws
    if draws.shape[0] * draws.shape[1] * len(data) > LARGEST:
        raise InputError(
            f"the log likelihood of {draws.shape[0] * draws.shape[1]} draws at {len(data)} points "
            "is too large to hold; compare with a smaller ess"
        )
    return arviz_object(
        {
            "posterior": {name: draws[:, :, j] for j, name in enumerate(posterior.names)},
            "log_likelihood": {"pixel": pointwise(found)},
            "observed_data": {"pixel": data.t},
        }
    )


def pointwise(found: OrderResult) -> Array:
    """Log density of each pixel given each draw, ``(n_chains, n_draws, n_points)``."""
    full = found.posterior.full
    flat = full.reshape(-1, full.shape[2])
    exact = found.posterior.exact
    if exact is not None:
        values = gaussian_density(found.data, exact)(flat)
    else:
        values = found.posterior.model.log_likelihood(flat)
    return np.asarray(values.reshape(*full.shape[:2], -1))
