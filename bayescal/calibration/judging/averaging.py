"""Draws and covariance of a lens with the error models averaged by their probabilities."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.evidence import drawn, settled
from bayescal.calibration.judging.expansion import Expansion
from bayescal.calibration.judging.judge import LensEvidence, Setting
from bayescal.calibration.model.error_grid import Node
from bayescal.calibration.model.strengths import strengths
from bayescal.inference.weighting import resampled

FEWEST = 50  # draws at a time from an error model: fewer can't be picked by their weights


class ErrorAverage:
    """A lens under each of its error models, linearised where the best of them has its mode."""

    def __init__(self, evidence: LensEvidence, setting: Setting) -> None:
        self.evidence, self.setting = evidence, setting
        self._made: dict[Node, Problem | Expansion] = {evidence.errors.nodes[0]: evidence.density}

    @cached_property
    def _offering(self) -> Problem:
        """Offer other error models the strengths that matter under the best of them."""
        problem = self.evidence.problem
        likely = strengths(problem.model).only(problem.laplace.likely())
        found = replace(problem, offered=likely)
        found.__dict__["stack"] = problem.stack
        return found

    def density(self, node: Node) -> Problem | Expansion:
        """Put the lens under an error model."""
        if node not in self._made:
            base, problem = self.evidence.density, self.setting.under(self._offering, node)
            if isinstance(base, Expansion):
                self._made[node] = Expansion(problem, base.terms)
            else:
                self._made[node] = settled(problem)
        return self._made[node]

    def problem(self, node: Node) -> Problem:
        """Give the lens as it is linearised under an error model."""
        return self.density(node).problem

    def parts(
        self, rng: np.random.Generator, n: int
    ) -> Iterator[tuple[Problem | Expansion, Array]]:
        """Give draws of each error model, as many as its probability is worth (`allotted`).

        They are picked from its importance draws by their weights, ``(count, dimension)``.
        """
        errors = self.evidence.errors
        counts = allotted(np.array(errors.weights), n, rng)
        for node, count in zip(errors.nodes, counts, strict=True):
            if count:
                density = self.density(node)
                yield density, drawn(density, rng.spawn(1)[0], count)

    def draws(self, rng: np.random.Generator, n: int) -> Array:
        """Draw the lens's coordinates, the error models averaged, ``(about n, dimension)``."""
        return np.concatenate([draws for _, draws in self.parts(rng, n)])

    def covariance(self) -> Array:
        """Covariance of the lens's coordinates, the error models averaged, ``(d, d)``."""
        errors = self.evidence.errors
        shares = np.array(errors.weights)
        kept = np.flatnonzero(shares > 0.01 * shares[0])
        shares = shares[kept] / shares[kept].sum()
        problems = [self.problem(errors.nodes[i]) for i in kept]
        means = np.array([p.x + p.laplace.mean for p in problems])
        gap = means - shares @ means
        within = np.einsum("k,kij->ij", shares, np.array([p.laplace.covariance for p in problems]))
        return np.asarray(within + (gap * shares[:, None]).T @ gap)


def allotted(shares: Array, n: int, rng: np.random.Generator) -> IntArray:
    """Share out about `n` draws in lots of `FEWEST`, on average as the shares say, ``(n_shares,)``.

    Improbable error models get a lot now and then, so that no part of the probability is lost.
    """
    lots = max(round(n / FEWEST), 1)
    picked = resampled(shares / shares.sum(), lots, rng)
    return np.asarray(FEWEST * np.bincount(picked, minlength=len(shares)))
