"""A model's posterior as other libraries hold it: data frames of pandas, trees of ArviZ."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.criteria.pointwise import gaussian_density
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import arviz_object

if TYPE_CHECKING:  # pandas is imported where somebody asks for it
    import pandas as pd

    from bayescal.inference.posterior import Posterior
    from bayescal.polynomials.axis_data import AxisData

# An OrderResult, whose methods call what follows.
OrderResult: TypeAlias = Any
# Log densities of one order that are held at once.
LARGEST = 50_000_000
# And that a run keeps of a model: 16 MB.
LARGEST_KEPT = 2_000_000
NORMAL_95 = 1.959963984540054


class Held(NamedTuple):
    """What a result holds that other libraries can take.

    Attributes
    ----------
    draws : Array or None
        Of the reported parameters, ``(n_chains, n_draws, n_parameters)``; None where a closed
        form leaves nothing to draw.
    names : tuple of str
        Of the parameters.
    density : callable or None
        Gives the log density of each observation at each draw, ``(n_chains, n_draws, n_points)``.
    observed : dict of str to Array
        Data, ``(n_points,)``, px.
    """

    draws: Array | None
    names: tuple[str, ...]
    density: Callable[[], Array] | None
    observed: dict[str, Array]


class Converts(ABC):
    """A model that hands its posterior to other libraries."""

    @abstractmethod
    def held(self) -> Held:
        """Give draws, densities and data, as far as there are any."""

    @property
    @abstractmethod
    def summaries(self) -> Sequence[Any]:
        """Summaries of the parameters."""

    def summary(self) -> pd.DataFrame:
        """Parameters in a data frame: mean, sd, 95 % interval, diagnostics, closed form."""
        import pandas as pd

        rows = [{"parameter": p.name, **_numbers(p)} for p in self.summaries]
        return pd.DataFrame(rows).set_index("parameter")

    def named_covariance(self) -> tuple[tuple[str, ...], Array]:
        """Names of the reported parameters, and their posterior covariance: of the draws."""
        held = self.held()
        draws = _drawn(held)
        with threadpool_limits(1):  # the same on any number of cores
            found = np.cov(draws.reshape(-1, draws.shape[2]), rowvar=False)
        return held.names, np.atleast_2d(found)

    def covariance(self) -> pd.DataFrame:
        """Posterior covariance of the reported parameters in a data frame.

        Of the draws, or of the coefficients where a closed form leaves nothing to draw.

        Raises
        ------
        InputError
            Where there is neither.
        """
        import pandas as pd

        names, matrix = self.named_covariance()
        return pd.DataFrame(matrix, index=list(names), columns=list(names))

    def to_arviz(self) -> Any:
        """Draws, pointwise log likelihood and data for ArviZ: ``az.loo``, ``az.compare``.

        Returns
        -------
        xarray.DataTree
            With the groups ``posterior``, ``log_likelihood`` and ``observed_data``;
            ``arviz.InferenceData`` where an ArviZ before 1.0 is installed.

        Raises
        ------
        InputError
            Where there are no draws, or their log likelihoods would not fit into memory.
        """
        held = self.held()
        draws = _drawn(held)
        count, points = draws.shape[0] * draws.shape[1], _points(held)
        if count * points > LARGEST:
            raise InputError(
                f"the log likelihood of {count} draws at {points} points "
                "is too large to hold; compare with a smaller ess"
            )
        groups = {"posterior": {name: draws[:, :, j] for j, name in enumerate(held.names)}}
        return arviz_object(groups | pointwise_groups(held))


def pointwise_groups(held: Held) -> dict[str, dict[str, Array]]:
    """Log likelihood and data as ArviZ's groups; a point's readings have one density together."""
    if held.density is None:
        return {}
    name = next(iter(held.observed)) if len(held.observed) == 1 else "pixels"
    return {"log_likelihood": {name: held.density()}, "observed_data": held.observed}


def kept_groups(held: Held) -> dict[str, dict[str, Array]]:
    """Give the same for a run, without log likelihoods that would be most of it."""
    groups = pointwise_groups(held) if _numbers_of(held) <= LARGEST_KEPT else {}
    return groups or {"observed_data": held.observed}


def _numbers_of(held: Held) -> int:
    return 0 if held.draws is None else held.draws[:, :, 0].size * _points(held)


def _points(held: Held) -> int:
    return len(next(iter(held.observed.values()), ()))


def _drawn(held: Held) -> Array:
    if held.draws is None:
        raise InputError("has no draws: it was judged in closed form or by linear algebra")
    return held.draws


class Moments(NamedTuple):
    """What draws or a closed form say of a parameter, without diagnostics."""

    name: str
    mean: float
    sd: float
    interval: tuple[float, float]


def normal_moments(names: Sequence[str], mean: Array, sd: Array) -> list[Moments]:
    """Summarise normal densities: mean, sd and central 95 % interval."""
    ends = zip(mean - NORMAL_95 * sd, mean + NORMAL_95 * sd, strict=True)
    rows = zip(names, mean.tolist(), sd.tolist(), ends, strict=True)
    return [Moments(n, m, s, (float(low), float(high))) for n, m, s, (low, high) in rows]


def moments(names: Sequence[str], draws: Array) -> list[Moments]:
    """Summarise draws ``(n_draws, n_parameters)``: mean, sd and central 95 % interval."""
    lower, upper = np.quantile(draws, [0.025, 0.975], axis=0).tolist()
    means, sds = draws.mean(axis=0).tolist(), draws.std(axis=0, ddof=1).tolist()
    ends = zip(lower, upper, strict=True)
    return [Moments(*row) for row in zip(names, means, sds, ends, strict=True)]


def _numbers(p: Any) -> dict[str, float]:
    """Give a summary's numbers; what can't be had is NaN."""
    stated = {"mean": p.mean, "sd": p.sd, "lower": p.interval[0], "upper": p.interval[1]}
    more = ("mcse_mean", "ess_bulk", "ess_tail", "rhat", "exact_mean", "exact_sd")
    found = {name: getattr(p, name, None) for name in more}
    return stated | {name: np.nan if value is None else value for name, value in found.items()}


def pointwise(found: OrderResult) -> Array:
    """Log density of each pixel given each draw, ``(n_chains, n_draws, n_points)``."""
    return order_density(found.posterior, found.data)


def order_density(posterior: Posterior, data: AxisData) -> Array:
    """Log density of each pixel given each draw of one order, ``(n_chains, n_draws, n_points)``."""
    full, exact = posterior.full, posterior.exact
    flat = full.reshape(-1, full.shape[2])
    if exact is not None:
        values = gaussian_density(data, exact)(flat)
    else:
        model: Any = posterior.model
        values = model.log_likelihood(flat)
    return np.asarray(values.reshape(*full.shape[:2], -1))


def order_held(posterior: Posterior, data: AxisData) -> Held:
    """Give what one order of an axis holds; of many points no densities: it holds a sample."""
    density = None if data.whole is not None else partial(order_density, posterior, data)
    return Held(posterior.chain.draws, posterior.names, density, {"pixel": data.t})
