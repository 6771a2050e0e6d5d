"""Clenshaw-Curtis rules, on one interval and on panels that follow a density."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array, frozen


@dataclass(frozen=True)
class Accuracy:
    """How finely a density is followed.

    A panel is fine enough when the log density varies by less than `resolve` nats over
    it, or by as much more as its mass is less than the mode's; it is dropped where the
    density is below exp(-drop) of its maximum.

    Attributes
    ----------
    resolve, drop : float
        nat.
    panel_nodes, tau_nodes : int
        Nodes of a panel in ln sigma and of the rule in ln tau; 1 plus multiples of 4.
    panels : int
        Panels to start from.
    even : bool
        Whether even steps take the place of panels where no density is highest at an end.
    """

    resolve: float
    drop: float
    panel_nodes: int
    tau_nodes: int
    panels: int
    even: bool = False


# Steps of `evenly` from one place to the next at which a density is looked at first.
SCAN = 4
# The log integral is good to about 1e-8 nat (tests/linear/test_closed_form.py).
FINE = Accuracy(resolve=3.0, drop=34.0, panel_nodes=13, tau_nodes=49, panels=24)
# To about 0.01 nat: for thousands of resamples, whose own scatter is a thousand times that.
COARSE = Accuracy(resolve=4.0, drop=14.0, panel_nodes=5, tau_nodes=17, panels=10, even=True)


@cache
def clenshaw_curtis(nodes: int) -> tuple[Array, Array]:
    """Clenshaw-Curtis rule on [-1, 1] (Waldvogel 2006, BIT 46, eq. 2.4).

    Nodes include both ends and nest: every second one is the rule of half the size.

    Parameters
    ----------
    nodes : int
        Odd, at least 3.

    Returns
    -------
    x, weights : Array
        Both ``(nodes,)``, x ascending.
    """
    n = nodes - 1
    angles = np.pi * np.arange(nodes) / n
    k = np.arange(1, n // 2 + 1)
    factor = np.where(k == n // 2, 1.0, 2.0) / (4 * k**2 - 1)
    weights = (2.0 / n) * (1 - np.cos(2 * np.outer(angles, k)) @ factor)
    weights[[0, -1]] /= 2
    return frozen(-np.cos(angles)), frozen(weights)


@dataclass(frozen=True, eq=False)
class Rule:
    """Nodes and weights of a quadrature, with those of the nested coarser one.

    Attributes
    ----------
    nodes : Array
        ``(n_nodes,)``, ascending.
    weights, coarse : Array
        ``(n_nodes,)``; `coarse` is zero at the nodes the coarser rule lacks.
    """

    nodes: Array
    weights: Array
    coarse: Array


POINT = Rule(frozen([0.0]), frozen([1.0]), frozen([1.0]))


def interval(lower: float, upper: float, nodes: int) -> Rule:
    """Rule on one interval; `nodes` is 1 plus a multiple of 4."""
    return panels(np.array([lower]), np.array([upper]), nodes)


def follow(
    log_density: Callable[[Array], Array], breaks: Array, accuracy: Accuracy = FINE
) -> tuple[Rule, Array]:
    """Place panels where families of log densities have their mass.

    Panels are halved until every density that matters in its family is resolved over
    each, and dropped where all are negligible. A log likelihood varies smoothly on the
    scale of ln sigma itself however many points there are, so a peak can't hide between
    the nodes of a panel whose ends don't show it.

    Parameters
    ----------
    log_density : callable
        From nodes ``(n_nodes,)`` to log densities ``(..., n_densities, n_nodes)``; the
        leading axes count families (models), each judged by its own maximum.
    breaks : Array
        Ascending ends of the first panels, ``(n_panels + 1,)``.

    Returns
    -------
    values : Array
        Log densities at its nodes, ``(..., n_densities, n_nodes)``.
    """
    x, _ = clenshaw_curtis(accuracy.panel_nodes)
    lower, upper = breaks[:-1], breaks[1:]
    kept: list[tuple[Array, Array]] = []
    best: Array | float = -np.inf
    while lower.size:
        nodes = (lower + upper)[:, None] / 2 + (upper - lower)[:, None] / 2 * x
        values = log_density(nodes.ravel())
        values = values.reshape(*values.shape[:-1], *nodes.shape)
        top, bottom = values.max(axis=-1), values.min(axis=-1)
        best = np.maximum(best, top.max(axis=(-2, -1), keepdims=True))
        floor = best - accuracy.drop
        # How high a density might reach between nodes, which need not have been nodes of
        # the panel it is half of: as far again as it varies.
        reach = np.minimum(2 * top - bottom, best)
        matters = reach > floor
        excess = (reach - np.maximum(bottom, floor)) - (best - reach)
        varies = _any_density(matters & (excess > accuracy.resolve))
        done = _any_density(matters) & ~varies
        kept.append((lower[done], upper[done]))
        lower, upper = lower[varies], upper[varies]
        middle = (lower + upper) / 2
        splits = (middle > lower) & (middle < upper)  # False once rounding stops a split
        lower, upper = (
            np.concatenate([lower[splits], middle[splits]]),
            np.concatenate([middle[splits], upper[splits]]),
        )
    ends = np.array([np.concatenate(side) for side in zip(*kept, strict=True)])
    ends = ends[:, np.argsort(ends[0])]
    rule = panels(ends[0], ends[1], accuracy.panel_nodes)
    return rule, log_density(rule.nodes)


def evenly(
    log_density: Callable[[Array], Array], lower: float, upper: float, width: float, drop: float
) -> tuple[Rule, Array] | None:
    """Trapezoidal rule where families of log densities have their mass; errors as of `follow`.

    Its error falls as exp(-2 (pi width / step)^2) for a normal peak (Trefethen & Weideman 2014,
    SIAM Rev. 56, 385): a step of one width is enough, where `follow` takes ten times the nodes.

    Parameters
    ----------
    width : float
        Least standard deviation of a peak.

    Returns
    -------
    Rule and values, or None where a density is highest at an end, beside which it may fall faster.
    """
    count = SCAN * math.ceil((upper - lower) / width / SCAN)
    places = np.linspace(lower, upper, count + 1)
    scanned = log_density(places[::SCAN])
    height = scanned.reshape(-1, scanned.shape[-1])
    if np.isin(height.argmax(axis=-1), (0, height.shape[-1] - 1)).any():
        return None
    # Between two of the scanned places a peak of this width is higher by less than SCAN^2 / 8.
    floor = scanned.max(axis=(-2, -1), keepdims=True) - drop - SCAN**2 / 8
    matter = np.flatnonzero(_any_density(scanned > floor))
    part = slice(SCAN * max(matter[0] - 1, 0), SCAN * (matter[-1] + 1) + 1)
    nodes = places[part]
    weights = np.full(len(nodes), places[1] - places[0])
    return Rule(nodes, weights, weights), log_density(nodes)


def _any_density(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether any density has the flag, panel by panel."""
    return np.asarray(flags.reshape(-1, flags.shape[-1]).any(axis=0))


def panels(lower: Array, upper: Array, nodes: int) -> Rule:
    """Composite rule on adjoining panels; nodes that neighbours share are merged."""
    x, fine = clenshaw_curtis(nodes)
    coarse = np.zeros(nodes)
    coarse[::2] = clenshaw_curtis(nodes // 2 + 1)[1]
    half = (upper - lower) / 2
    places = (lower + half)[:, None] + half[:, None] * x
    places[:, 0], places[:, -1] = lower, upper
    unique, index = np.unique(places.ravel(), return_inverse=True)
    return Rule(
        unique,
        np.bincount(index, weights=np.outer(half, fine).ravel()),
        np.bincount(index, weights=np.outer(half, coarse).ravel()),
    )
