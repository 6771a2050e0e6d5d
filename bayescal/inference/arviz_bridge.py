"""The one place that talks to ArviZ, whatever its version.

ArviZ 1.x is made of arviz_base and arviz_stats; 0.23, the last for Python 3.11,
brings the same packages as its "preview". Both are used through those two names.
"""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array

# The root attribute in which a file keeps what is no array.
VALUES = "bayescal"
# The group that ArviZ leaves points out by, and that nothing else reads again.
POINTWISE = "log_likelihood"


class PsisLoo(NamedTuple):
    """Leave-one-out by Pareto-smoothed importance sampling.

    Attributes
    ----------
    pointwise : Array
        ln p(t_i | the others), ``(n_points,)``.
    influence : Array
        Of each draw on each term, ``(n_points, n_draws)``: their squares sum over the draws to
        the square of the Monte Carlo standard error (Vehtari et al. 2024, eq. 6).
    pareto_k : Array
        Shape of the weights' tail, ``(n_points,)``.
    """

    pointwise: Array
    influence: Array
    pareto_k: Array

    @property
    def mcse(self) -> Array:
        """Monte Carlo standard error of each term, ``(n_points,)``."""
        return np.sqrt((self.influence**2).sum(axis=1))


def psis_loo(log_likelihood: Array) -> PsisLoo:
    """Leave-one-out by Pareto-smoothed importance sampling from draws.

    Parameters
    ----------
    log_likelihood : Array
        ln p(t_i | draw), ``(n_points, n_draws)``.
    """
    log_weights, pareto_k = _smoothed(log_likelihood)
    log_weights = log_weights - logsumexp(log_weights, axis=-1, keepdims=True)
    elpd = np.asarray(logsumexp(log_weights + log_likelihood, axis=-1))
    # Both terms sum to 1 over the draws, so that neither can overflow.
    influence = np.exp(log_weights + log_likelihood - elpd[:, None]) - np.exp(log_weights)
    return PsisLoo(elpd, influence, pareto_k)


def _smoothed(log_likelihood: Array) -> tuple[Array, Array]:
    """Smoothed log weights of each point, and the shape of their tail."""
    from arviz_stats.base import array_stats

    # Where all weights of a tail are alike to rounding, its shape is no number: bad.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        try:
            log_weights, shape = array_stats.psislw(log_likelihood, axis=-1)
        except ValueError:  # of a point that every draw predicts alike there is no tail
            if len(log_likelihood) > 1:
                rows, shapes = zip(*(_smoothed(row[None]) for row in log_likelihood), strict=True)
                return np.concatenate(rows), np.concatenate(shapes)
            flat = float(np.ptp(log_likelihood)) == 0
            return -log_likelihood, np.array([0.0 if flat else np.inf])
    return np.asarray(log_weights), np.asarray(shape)


def arviz_object(groups: dict[str, dict[str, Array]]) -> Any:
    """Make what the installed ArviZ works on: a DataTree, or InferenceData before 1.0.

    Parameters
    ----------
    groups : dict of str to dict of str to Array
        As in `Draws`; ``log_likelihood`` has the dimension of ``observed_data``.
    """
    dims = _pointwise_dims(groups)
    if find_spec("arviz") is not None and version("arviz").startswith("0."):
        import arviz

        return arviz.from_dict(**groups, dims=dims)
    import arviz_base

    return arviz_base.from_dict(groups, dims=dims)


def _pointwise_dims(groups: dict[str, dict[str, Array]]) -> dict[str, list[str]]:
    """Name the dimension of all that has a value for each point."""
    names = [*groups.get("observed_data", {}), *groups.get(POINTWISE, {})]
    return {name: ["point"] for name in names}


@dataclass(frozen=True, eq=False)
class Draws:
    """Arrays in ArviZ's groups, with what describes them.

    Attributes
    ----------
    groups : dict of str to dict of str to Array
        Variables by group: ``(n_chains, n_draws, ...)`` in ``posterior``,
        ``unconstrained_posterior`` and ``sample_stats``, ``(n_points,)`` in
        ``observed_data``.
    described : dict
        Attributes of the posterior group, for people: texts and numbers.
    values : dict
        What belongs to the draws and is no array, JSON values (NaN allowed).
    """

    groups: dict[str, dict[str, Array]]
    described: dict[str, str | float]
    values: dict[str, Any]


def write_netcdf(path: Path, draws: Draws) -> None:
    """Write draws as NetCDF with ArviZ's groups."""
    # Made in memory first: HDF5 does not survive a disk that fills up under it.
    path.write_bytes(netcdf_bytes(draws))


def netcdf_bytes(draws: Draws) -> bytes:
    """Encode draws as NetCDF with ArviZ's groups; the same draws give the same bytes."""
    import arviz_base

    dims = {"theta": ["coordinate"], **_pointwise_dims(draws.groups)}
    tree = arviz_base.from_dict(draws.groups, dims=dims)
    for name in draws.groups:
        tree[name].attrs = {}  # ArviZ writes the time here
    tree["posterior"].attrs = dict(draws.described)
    tree.attrs = {VALUES: json.dumps(draws.values)}
    return bytes(tree.to_netcdf(engine="h5netcdf"))


def parse_netcdf(raw: bytes) -> Draws:
    """Read what `write_netcdf` wrote, to the last bit.

    Through HDF5 alone: ArviZ and xarray take two seconds to import.

    Parameters
    ----------
    raw : bytes
        The file's content.

    Raises
    ------
    ValueError
        Where it is no such file, or is damaged.
    """
    import h5py

    try:
        with h5py.File(io.BytesIO(raw), "r") as file:
            groups = {
                name: {
                    key: np.asarray(variable[()], dtype=np.float64)
                    for key, variable in group.items()
                    # Dimensions are variables to HDF5.
                    if variable.attrs.get("CLASS") != b"DIMENSION_SCALE"
                }
                for name, group in file.items()
                if name != POINTWISE
            }
            described = {
                key: value if isinstance(value, str) else float(np.ravel(value)[0])
                for key, value in file["posterior"].attrs.items()
                if not key.startswith("_")
            }
            values = json.loads(file.attrs[VALUES])
    except (OSError, KeyError, RuntimeError, TypeError, AttributeError) as error:
        raise ValueError(" ".join(str(error).split())) from None
    return Draws(groups, described, values)
