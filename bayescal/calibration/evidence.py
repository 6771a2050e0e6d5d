"""Evidence of a lens model from fresh draws of a mixture of t about its Laplace approximations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array
from bayescal.calibration.density import Problem
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.optimum import Mode
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.proposals.t_mixture import TMixture, cholesky

SETTLE_STEPS = 6
NEAR = 1e-3  # posterior deviations: a reference this near its mode is settled
COMPONENTS, COVERED = 40, 0.999  # of the mixture; share of the mass they hold
DRAWS = 2000


def settled(problem: Problem) -> Problem:
    """Move the reference to the posterior's mean, lens and poses together.

    Returns
    -------
    Problem
        Where a step leads out of what the lens can see, the problem as it was before it.
    """
    for _ in range(SETTLE_STEPS):
        step = problem.laplace.mean
        size = np.abs(np.linalg.solve(problem.spread, step)).max()
        moved = replace(problem, x=problem.x + step, poses=problem.poses_at(problem.x + step))
        if not moved.stack.possible:
            break
        problem = moved
        if size < NEAR:
            break
    return problem


def proposal(problem: Problem) -> tuple[TMixture, tuple[Mode, ...]]:
    """Mixture of t close to the posterior, and the modes it is about."""
    found = problem.laplace
    order = np.argsort(-found.log_mass)
    shares = np.exp(found.log_mass[order] - logsumexp(found.log_mass))
    n = min(int(np.searchsorted(np.cumsum(shares), COVERED)) + 1, COMPONENTS)
    modes = tuple(
        Mode(
            problem.x + found.step[i],
            float(found.log_mass[i]),
            cholesky(np.linalg.inv(found.precision[i])),
        )
        for i in order[:n]
    )
    return mixture_about(modes, found.log_mass[order[:n]]), modes


def weighed(
    problem: Problem, rng: np.random.Generator, n: int = DRAWS
) -> tuple[EvidenceEstimate, Array, Array]:
    """Evidence by importance sampling, with the draws and the logs of their weights.

    Parameters
    ----------
    problem : Problem
        Settled.
    n : int, optional
        Number of draws.
    """
    mixture, _ = proposal(problem)
    draws = mixture.draw(rng, n)
    log_weights = problem.log_prob(draws) - mixture.log_density(draws)
    return from_weights(log_weights), draws, log_weights
