"""A lens model as emcee samples it: sigma and the strengths are drawn afterwards."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.expansion import Expansion
from bayescal.calibration.judging.laplace import SIGMA_BOUNDS, degrees
from bayescal.prior.strength import Strength


@dataclass(frozen=True, eq=False)
class SampledLens:
    """The density of a problem with what the general sampler asks of a model.

    Attributes
    ----------
    density : Problem or Expansion
        Settled.
    """

    density: Problem | Expansion

    @property
    def problem(self) -> Problem:
        """The lens under its error model."""
        return self.density.problem

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        return self.problem.model.dimension

    @property
    def names(self) -> tuple[str, ...]:
        """Lens, bow, sigma where it is inferred, and a tau for each group."""
        model = self.problem.model
        sigma = ("sigma",) if self.problem.level.sigma is None else ()
        return (*model.names, *sigma, *(f"tau {g.name}" for g in model.groups))

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior, ``(n_draws,)``."""
        return self.density.log_prob(theta)

    def starts(self) -> Array:
        """Where the problem was linearised."""
        return self.problem.x[None]

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw ln sigma and ln tau given the lens, in further columns."""
        columns = [theta]
        if self.problem.level.sigma is None:
            low, high = (math.log(b) for b in SIGMA_BOUNDS)
            squares = self.density.squares(theta)
            columns.append(
                Strength((low, high), degrees(self.problem.data)).draw(squares, rng)[:, None]
            )
        for group in self.problem.model.groups:
            low, high = (math.log(b) for b in group.bounds)
            q = ((theta[:, list(group.columns)] / group.unit) ** 2).sum(axis=1)
            columns.append(Strength((low, high), len(group.columns)).draw(q, rng)[:, None])
        return np.concatenate(columns, axis=1)

    def report(self, full: Array) -> Array:
        """Completed draws in reported units, ``(n_draws, n_names)``."""
        model, data = self.problem.model, self.problem.data
        lens = model.report(full[:, : model.dimension], data.diagonal)
        return np.concatenate([lens, np.exp(full[:, model.dimension :])], axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of all views together: poses are integrated, so no point stands alone."""
        return self.density.log_likelihood(full[:, : self.dimension])[:, None]
