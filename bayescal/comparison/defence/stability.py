"""Would the choice hold with other points? Removals, resamples, orders beyond."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.key import Key
from bayescal.linear.evidence import log_evidences
from bayescal.linear.model import LinearModel
from bayescal.linear.quadrature import COARSE, FINE
from bayescal.linear.reweighting import DataSets, Rows
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import distinct_values

Named = TypeVar("Named", int, Key)
RESAMPLES = 1000


@dataclass(frozen=True)
class Removal:
    """A point or group without which another order would win.

    Attributes
    ----------
    name : str
        Label of the point, or name of the group.
    size : int
        Points removed.
    order : int or Key
        The order, or the model of r and c together, that wins without them.
    log_bayes_factor : float
        ln B of it against the recommended one, without them.
    """

    name: str
    size: int
    order: int | Key
    log_bayes_factor: float

    @property
    def winner(self) -> str:
        """What wins without them, in words."""
        return str(self.order) if isinstance(self.order, Key) else f"order {self.order}"


@dataclass(frozen=True)
class Bootstrap:
    """How often each order wins over resamples of the data.

    Attributes
    ----------
    unit : str
        ``"point"`` or ``"group"``: what is resampled with replacement.
    share : dict of int to float
        Share of the resamples that each order wins.
    """

    unit: str
    resamples: int
    share: dict[int, float]


def removals(
    names: Sequence[str], sizes: Sequence[int], without: Mapping[Named, Array], chosen: Named
) -> tuple[Removal, ...]:
    """Find the points or groups whose removal changes the winner.

    Parameters
    ----------
    names, sizes : sequence
        Of the points or groups.
    without : mapping of int or Key to Array
        By order or model, log evidence without each of them, ``(n_removed,)``.
    chosen : int or Key
        The recommended one.

    Returns
    -------
    tuple of Removal
        Strongest first.
    """
    orders = list(without)
    table = np.array([without[k] for k in orders])
    best = table.argmax(axis=0)
    found = [
        Removal(names[i], sizes[i], orders[best[i]], float(table[best[i], i] - without[chosen][i]))
        for i in np.flatnonzero(best != orders.index(chosen)).tolist()
    ]
    return tuple(sorted(found, key=lambda r: -r.log_bayes_factor))


def without_groups(
    data: AxisData, models: Mapping[int, LinearModel], members: Array
) -> dict[int, Array]:
    """Log evidence of every order without each group.

    Parameters
    ----------
    members : Array
        1 where a point belongs to a group, ``(n_groups, n_points)``.

    Returns
    -------
    dict of int to Array
        ``(n_groups,)`` by order.
    """
    sets = Rows.of(data, max(models)).without(members)
    left = [distinct_values(data.x[row == 0]) if (row == 0).any() else 0 for row in members]
    return {
        k: np.full(len(members), np.nan)
        if not model.prior.proper and min(left) < model.size
        else log_evidences(sets.reduced(k), model.noise, model.prior, FINE)
        for k, model in models.items()
    }


def bootstrap(
    data: AxisData,
    models: Mapping[int, LinearModel],
    rng: np.random.Generator,
    members: Array | None = None,
    resamples: int = RESAMPLES,
) -> Bootstrap:
    """Resample points or groups and count which order wins.

    Domain and prior stay those of the full data.

    Parameters
    ----------
    models : mapping of int to LinearModel
        With a proper prior.
    members : Array, optional
        1 where a point belongs to a group, ``(n_groups, n_points)``; points are
        resampled one by one without it.
    """
    unit = "point" if members is None else "group"
    units = len(data) if members is None else len(members)
    drawn = rng.multinomial(units, np.full(units, 1 / units), size=resamples).astype(float)
    counts = drawn if members is None else drawn @ members
    return bootstrap_of(Rows.of(data, max(models)).counted(counts), models, unit)


def bootstrap_of(sets: DataSets, models: Mapping[int, LinearModel], unit: str) -> Bootstrap:
    """Count which order wins over data sets of which a `unit` was resampled."""
    resamples = len(sets.triangles)
    table = np.array(
        [
            log_evidences(sets.reduced(k), model.noise, model.prior, COARSE)
            for k, model in models.items()
        ]
    )
    wins = np.bincount(table.argmax(axis=0), minlength=len(models)) / resamples
    return Bootstrap(
        unit,
        resamples,
        {k: float(share) for k, share in zip(models, wins, strict=True)},
    )


def joint_probabilities(first: Mapping[int, float], second: Mapping[int, float]) -> Array:
    """Probability of every pair of orders of two independent axes, ``(n_first, n_second)``."""
    return np.outer(list(first.values()), list(second.values()))
