"""Quadrature over the strengths tau of a lens's groups: Gauss-Legendre in their logarithms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.calibration.model.lens_model import LensModel

NODES = {1: 16, 2: 16, 3: 9}  # a group, by the number of groups
FEWEST = 5
COARSE = 6  # nodes of each while modes are looked for and error models compared


@dataclass(frozen=True, eq=False)
class Strengths:
    """Combinations of tau.

    Attributes
    ----------
    precision : Array
        Prior precision of each coordinate, ``(n_combinations, dimension)``.
    log_density : Array
        Log of the prior's normalisation at its mean, ``(n_combinations,)``.
    log_weight : Array
        Log share of each combination in the prior, ``(n_combinations,)``.
    mean : Array
        Prior mean of the coordinates, ``(dimension,)``.
    """

    precision: Array
    log_density: Array
    log_weight: Array
    mean: Array

    def only(self, kept: IntArray) -> Strengths:
        """Keep some of the combinations."""
        return Strengths(
            self.precision[kept], self.log_density[kept], self.log_weight[kept], self.mean
        )


@lru_cache(maxsize=64)
def strengths(model: LensModel, nodes: int | None = None) -> Strengths:
    """Nodes of tau for a lens model's groups; so many of each, by default as is accurate."""
    mean = np.zeros(model.dimension)
    sd = np.ones(model.dimension)
    mean[: model.n_plain], sd[: model.n_plain] = model.plain_prior
    groups = model.groups
    x, w = np.polynomial.legendre.leggauss(nodes or NODES.get(len(groups), FEWEST))
    n = len(x) ** len(groups)
    sds, log_weight = np.tile(sd, (n, 1)), np.zeros(n)
    for group, chosen in zip(groups, np.indices((len(x),) * len(groups)), strict=True):
        low, high = np.log(group.bounds)
        tau = np.exp((low + high) / 2 + (high - low) / 2 * x)
        sds[:, list(group.columns)] = group.unit * tau[chosen.ravel(), None]
        log_weight += np.log(w / 2)[chosen.ravel()]
    log_density = -np.log(sds).sum(axis=1) - model.dimension / 2 * LOG_2PI
    return Strengths(sds**-2, log_density, log_weight, mean)
