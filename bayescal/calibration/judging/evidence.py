"""Evidence of a lens model from fresh draws of a mixture of t about its Laplace approximations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.special import logsumexp, softmax

from bayescal.arrays import Array
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.expansion import Expansion
from bayescal.calibration.judging.laplace import ENOUGH
from bayescal.calibration.model.strengths import COARSE, strengths
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.optimum import Mode
from bayescal.inference.proposals.adaptation import adapt
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.t_mixture import TMixture, cholesky
from bayescal.inference.weighting import resampled

SETTLE_STEPS, HALVINGS = 20, 6
HEADROOM = 5.0  # nat: the likelihood is largest somewhat beside the posterior's mean
SLACK = 1.0  # nat: a posterior's mean may lie lower than where a step begins
NEAR = 0.02  # posterior deviations: a reference whose step would be shorter is settled
COMPONENTS, COVERED = 40, 0.999  # of the mixture; share of the mass they hold
DRAWS = 2000
CORRECTED = 50  # draws at which an expansion is corrected
NEAR_SHARE = 0.05  # of the evidence, root mean square: an expansion that lacks more is of no use
SHRUNK, MET, MODES = 8, 0.5, 3  # halvings of a proposal; share of its draws; modes that are held


def settled(problem: Problem) -> Problem:
    """Move the reference to the posterior's mean, lens and poses together.

    Steps that lead out of what the lens can see, or downhill, are halved: a lens far from the
    points would be thrown to and fro.

    Returns
    -------
    Problem
        The problem as it was where even a short step does.
    """
    prior, highest = strengths(problem.model, COARSE), height(problem)
    for _ in range(SETTLE_STEPS):
        found = problem.laplace_over(prior)
        step, sd = found.mean, np.sqrt(np.diag(found.covariance))
        far = float(np.abs(step / sd).max())
        if far < NEAR:
            break
        for _ in range(HALVINGS):
            moved = problem.moved(step)
            new = height(moved)
            if new > highest - SLACK:
                break
            step = step / 2
        else:
            break
        problem, highest = moved, new
        if far < 1:
            prior = prior.only(found.likely(ENOUGH))
            problem.__dict__["likely_strengths"] = prior
    return problem


def height(problem: Problem) -> float:
    """Log density at the reference, poses at their next step; -inf where it can't see a point."""
    if not problem.stack.possible:
        return -math.inf
    try:
        likelihood = _log_likelihood(problem)
    except np.linalg.LinAlgError:  # so far off that rounding is all that is left
        return -math.inf
    return likelihood + float(problem.log_prior(problem.x[None])[0])


def ceiling(problem: Problem) -> float:
    """Bound a settled problem's log evidence from above: none exceeds the likelihood."""
    return _log_likelihood(problem) + HEADROOM


def _log_likelihood(problem: Problem) -> float:
    squares = np.array([problem.reduced.sum_of_squares])
    return float(problem.likelihood_of(squares, np.zeros(1))[0])


def proposal(problem: Problem) -> tuple[TMixture, tuple[Mode, ...]]:
    """Mixture of t close to the posterior, and the modes it is about."""
    found = problem.laplace
    order = np.argsort(-found.log_mass)
    shares = np.exp(found.log_mass[order] - logsumexp(found.log_mass))
    n = min(int(np.searchsorted(np.cumsum(shares), COVERED)) + 1, COMPONENTS)
    some = order[:n]
    roots = cholesky(found.covariances[some])
    modes = tuple(
        Mode(problem.x + step, float(mass), root)
        for step, mass, root in zip(found.step[some], found.log_mass[some], roots, strict=True)
    )
    return mixture_about(modes, found.log_mass[some]), modes


def weighed(
    density: Problem | Expansion, rng: np.random.Generator, n: int = DRAWS
) -> tuple[EvidenceEstimate, Array, Array]:
    """Evidence by importance sampling, with the draws and the logs of their weights.

    An expansion weighs all of the draws; what it lacks is the mean difference from the density
    itself over the first of them, whose error counts; where they are not near, the density
    weighs all.

    Parameters
    ----------
    density : Problem or Expansion
        Settled.
    n : int, optional
        Number of draws.
    """
    problem = density.problem
    mixture, _ = proposal(problem)
    draws = mixture.draw(rng, n)
    log_q = mixture.log_density(draws)
    log_weights = density.log_prob(draws) - log_q
    found = from_weights(log_weights)
    if density is problem:
        return found, draws, log_weights
    few = min(n, CORRECTED)
    log_weights[:few], before = (
        problem.log_prob(draws[:few]) - log_q[:few],
        log_weights[:few].copy(),
    )
    with np.errstate(over="ignore", invalid="ignore"):
        shares = np.exp(np.stack([log_weights[:few], before]) - found.log_evidence)
        lacking = shares[0] - shares[1]
        far = not np.sqrt(np.mean(lacking**2)) <= NEAR_SHARE  # of what overflowed, too
    if far:
        log_weights[few:] = problem.log_prob(draws[few:]) - log_q[few:]
        return from_weights(log_weights), draws, log_weights
    error = math.hypot(found.error, float(lacking.std(ddof=1)) / math.sqrt(few))
    log_evidence = found.log_evidence + math.log1p(float(lacking.mean()))
    return replace(found, log_evidence=log_evidence, error=error), draws, log_weights


def adapted(problem: Problem, rng: np.random.Generator, n: int) -> EvidenceEstimate:
    """Evidence by a proposal that follows a ridge or a bound, where expansions do not."""
    mixture, modes = proposal(problem)
    draws = mixture.draw(rng, n)
    for shrunk in 0.5 ** np.arange(SHRUNK):  # until some of the draws can be seen
        if np.isfinite(problem.squares(problem.x + shrunk * (draws - problem.x))).mean() > MET:
            break
    near = (
        Mode(problem.x + shrunk * (m.theta - problem.x), m.log_mass, shrunk * m.root) for m in modes
    )
    found = adapt(problem.log_prob, tuple(near)[:MODES], rng, even=0.0).proposal
    draws = found.draw(rng, n)
    return from_weights(problem.log_prob(draws) - found.log_density(draws))


def drawn(density: Problem | Expansion, rng: np.random.Generator, n: int) -> Array:
    """Draw lenses, picked from importance draws by their weights, ``(n, dimension)``."""
    mixture, _ = proposal(density.problem)
    draws = mixture.draw(rng, n)
    log_weights = density.log_prob(draws) - mixture.log_density(draws)
    return np.asarray(draws[resampled(softmax(log_weights), n, rng)])
