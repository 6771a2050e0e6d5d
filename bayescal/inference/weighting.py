"""A model judged by weighted draws of an approximation: where nearly every draw is effective."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from bayescal.arrays import Array
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.t_mixture import TMixture


@dataclass(frozen=True, eq=False)
class WeightedDraws:
    """Draws of a proposal, and the posterior's that were picked of them by their weights.

    Attributes
    ----------
    log_weights : Array
        ln of likelihood times prior over the proposal's density, ``(n_draws,)``.
    full : Array
        Completed draws, picked with replacement, ``(n_draws, n_full)``.
    estimate : EvidenceEstimate
        Evidence by importance sampling alone.
    """

    model: SampledModel
    log_weights: Array
    full: Array
    estimate: EvidenceEstimate

    @property
    def completed(self) -> Array:
        """Completed draws, ``(n_draws, n_full)``."""
        return self.full

    @property
    def reported(self) -> Array:
        """Reported parameters of each draw, ``(n_draws, n_parameters)``."""
        return self.model.report(self.full)

    @property
    def effective(self) -> float:
        """Effective number of draws."""
        return self.estimate.effective_fraction * self.estimate.draws

    @property
    def heaviest(self) -> float:
        """Share of the weight of all that one draw has."""
        return float(softmax(self.log_weights).max())


def drawn(
    model: SampledModel, proposal: TMixture, rng: np.random.Generator, n: int
) -> tuple[Array, Array]:
    """Draws of a proposal, ``(n, dimension)``, and the log of their weights, ``(n,)``."""
    theta = proposal.draw(rng, n)
    return theta, model.log_prob(theta) - proposal.log_density(theta)


def weigh(
    model: SampledModel, proposal: TMixture, rng: np.random.Generator, n: int
) -> WeightedDraws:
    """Draw from a proposal, weigh the draws, and pick and complete as many by their weights.

    Parameters
    ----------
    proposal : TMixture
        Near the posterior, with heavier tails.
    n : int
        Number of draws.
    """
    theta, log_weights = drawn(model, proposal, rng, n)
    picked = theta[resampled(softmax(log_weights), n, rng)]
    full = model.complete(picked, rng)
    return WeightedDraws(model, log_weights, full, from_weights(log_weights))


def resampled(weights: Array, n: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Pick `n` by weights that sum to 1, systematically: most are taken once or not at all.

    Kitagawa 1996, J. Comput. Graph. Stat. 5, 1, section A.
    """
    at = (np.arange(n) + rng.random()) / n
    return np.minimum(np.searchsorted(np.cumsum(weights), at), len(weights) - 1)
