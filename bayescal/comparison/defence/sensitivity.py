"""Which order wins at each fixed strength of the non-linearity, tau."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array, frozen
from bayescal.linear.evidence import log_evidence_over_tau
from bayescal.linear.model import LinearModel

# Steps of the grid per decade of tau, down from 1.
STEPS = 60
# 2 ln B beyond which evidence is very strong (Kass & Raftery 1995).
VERY_STRONG = 10.0


@dataclass(frozen=True)
class Win:
    """An interval of tau on which one order is the most probable."""

    order: int
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class TauSensitivity:
    """Evidence and probability of every order over fixed tau.

    Attributes
    ----------
    tau : Array
        Fractions of the image, ``(n_tau,)``, log-spaced.
    log_evidence, probability : Array
        ``(n_orders, n_tau)``.
    wins : tuple of Win
        In ascending tau.
    """

    tau: Array
    orders: tuple[int, ...]
    log_evidence: Array
    probability: Array
    wins: tuple[Win, ...]

    @property
    def possible(self) -> tuple[Win, ...]:
        """The wins where tau is not ruled out: no tau is better by 2 ln B > 10."""
        best = self.log_evidence.max(axis=0)
        kept = self.tau[best > best.max() - VERY_STRONG / 2]
        low, high = float(kept[0]), float(kept[-1])
        return tuple(
            Win(w.order, max(w.lower, low), min(w.upper, high))
            for w in self.wins
            if w.lower < high and w.upper > low
        )


def tau_sensitivity(models: Mapping[int, LinearModel]) -> TauSensitivity:
    """Evaluate every order's evidence at tau fixed from the inferred one's lower bound to 1.

    Parameters
    ----------
    models : mapping of int to LinearModel
        By order, with the field prior.
    """
    orders = tuple(models)
    lowest, _ = models[orders[-1]].prior.log_tau_bounds
    log_tau = _grid(lowest)
    rows = []
    for model in models.values():
        at = log_tau if model.prior.scaled.any() else log_tau[:1]
        row = log_evidence_over_tau(model.reduced, model.noise, model.prior, at)
        rows.append(np.broadcast_to(row, log_tau.shape))
    evidence = np.array(rows)
    return TauSensitivity(
        frozen(np.exp(log_tau)),
        orders,
        frozen(evidence),
        frozen(softmax(evidence, axis=0)),
        _wins(log_tau, orders, evidence),
    )


def _grid(lowest: float) -> Array:
    """Grid of ln tau from `lowest` to 0 that holds every decade, ascending."""
    steps = math.floor(-lowest / math.log(10) * STEPS)
    down = -np.arange(steps + 1) * math.log(10) / STEPS
    return np.unique(np.append(down, lowest))


def _wins(log_tau: Array, orders: tuple[int, ...], evidence: Array) -> tuple[Win, ...]:
    """Intervals between the tau at which the lead changes, found by interpolation."""
    best = evidence.argmax(axis=0)
    wins, start = [], float(log_tau[0])
    for i in np.flatnonzero(np.diff(best)):
        old, new = best[i], best[i + 1]
        before, after = (evidence[old, j] - evidence[new, j] for j in (i, i + 1))
        share = before / (before - after)
        change = float(log_tau[i] + share * (log_tau[i + 1] - log_tau[i]))
        wins.append(Win(orders[old], math.exp(start), math.exp(change)))
        start = change
    wins.append(Win(orders[best[-1]], math.exp(start), math.exp(float(log_tau[-1]))))
    return tuple(wins)
