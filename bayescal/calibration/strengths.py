"""Quadrature over the strengths tau of a lens's groups: Gauss-Legendre in their logarithms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.lens_model import LensModel

NODES = {1: 16, 2: 16, 3: 9}  # a group, by the number of groups
FEWEST = 5


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


def strengths(model: LensModel, nodes: int | None = None) -> Strengths:
    """Nodes of tau for a lens model's groups; so many of each, by default as is accurate."""
    mean = np.zeros(model.dimension)
    sd = np.ones(model.dimension)
    mean[: model.n_plain], sd[: model.n_plain] = model.plain_prior
    groups = model.groups
    x, w = np.polynomial.legendre.leggauss(nodes or NODES.get(len(groups), FEWEST))
    rows, weights = [], []
    for chosen in product(range(len(x)), repeat=len(groups)):
        row = sd.copy()
        for group, j in zip(groups, chosen, strict=True):
            low, high = np.log(group.bounds)
            tau = math.exp((low + high) / 2 + (high - low) / 2 * x[j])
            row[list(group.columns)] = tau * group.unit
        rows.append(row)
        weights.append(math.fsum(math.log(w[j] / 2) for j in chosen))
    sds = np.array(rows)
    log_density = -np.log(sds).sum(axis=1) - model.dimension / 2 * math.log(2 * math.pi)
    return Strengths(sds**-2, log_density, np.array(weights), mean)
