"""Draws and covariance of a lens with the error models averaged by their probabilities."""

from __future__ import annotations

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array
from bayescal.calibration.density import Problem
from bayescal.calibration.error_grid import Node
from bayescal.calibration.evidence import settled, weighed
from bayescal.calibration.judge import LensEvidence, Setting
from bayescal.inference.weighting import resampled

FEWEST = 20  # draws: an error model with less is left out


def problem_at(evidence: LensEvidence, setting: Setting, node: Node) -> Problem:
    """Put a lens under an error model, settled there."""
    if node == evidence.errors.nodes[0]:
        return evidence.problem
    best = evidence.problem
    return settled(setting.problem(best.model, best.x, best.poses, node))


def averaged_draws(
    evidence: LensEvidence, setting: Setting, rng: np.random.Generator, n: int
) -> Array:
    """Draw a lens's coordinates with the error models averaged, ``(about n, dimension)``.

    From each error model as many as its probability is worth, picked from its importance draws
    by their weights.
    """
    shares = np.array(evidence.errors.weights)
    counts = np.floor(shares / shares.sum() * n + 0.5).astype(int)
    parts: list[Array] = []
    for node, count in zip(evidence.errors.nodes, counts, strict=True):
        if count < FEWEST and len(parts) > 0:
            continue
        child = rng.spawn(1)[0]
        _, draws, log_weights = weighed(problem_at(evidence, setting, node), child, count)
        parts.append(draws[resampled(softmax(log_weights), count, child)])
    return np.concatenate(parts)


def averaged_laplace(evidence: LensEvidence, setting: Setting) -> Array:
    """Covariance of a lens's coordinates with the error models averaged, ``(d, d)``."""
    shares = np.array(evidence.errors.weights)
    kept = np.flatnonzero(shares > 0.01 * shares[0])
    shares = shares[kept] / shares[kept].sum()
    problems = [problem_at(evidence, setting, evidence.errors.nodes[i]) for i in kept]
    means = np.array([p.x + p.laplace.mean for p in problems])
    gap = means - shares @ means
    within = np.einsum("k,kij->ij", shares, np.array([p.laplace.covariance for p in problems]))
    return np.asarray(within + (gap * shares[:, None]).T @ gap)
