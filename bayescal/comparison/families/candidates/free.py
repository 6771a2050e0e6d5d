"""Linear families at a free camera position.

The most probable pair of orders by Laplace's approximation is sampled, the others are weighed by
draws about it, or of a proposal that is adapted to them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria.information import robust_criteria
from bayescal.comparison.families.candidates.joint import Likelihood, LinearPair, judged_by
from bayescal.comparison.families.linearised import Linearised, of_pair
from bayescal.comparison.families.models import (
    Wanted,
    checked_axes,
    free_model,
    joint_data,
    moving_axes,
)
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.key import FREE, Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import RobustOrder
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Once, Store
from bayescal.density.free_position import FreePositionModel
from bayescal.density.position_search import position_mode, position_sd
from bayescal.density.robust_position import Found, RobustFreePosition, robust_start
from bayescal.errors import InputError
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.optimum import Mode, find_modes
from bayescal.inference.proposals.adaptation import adapt
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.proposals.tempering import effective_fraction
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import FITTED, Guess, SampledPosterior, sample_model
from bayescal.inference.t_mixture import TMixture
from bayescal.inference.weighting import WeightedDraws, drawn, weigh
from bayescal.points.correspondences import Correspondences
from bayescal.prior.camera import position_prior

# Draws of the evidence where each costs a quadrature: of a family's best model, which is sampled,
# and of the others, which are weighted only.
POSITION_DRAWS, WEIGHTED_DRAWS = 4000, 2000
# Draws of the evidence without a point that leave-one-out from the draws fails for.
REFIT_DRAWS = 600
# Draws that a robust pair is weighed by, of the best of so many proposals.
ADAPTED_DRAWS, TRIES = 4000, 3


@dataclass(frozen=True, eq=False)
class _FreePair(LinearPair, ABC):
    """One pair of orders at a free position.

    Attributes
    ----------
    modes : tuple of Mode
        Of its density, the highest first.
    sampled : bool
        Whether it is sampled, or weighed only.
    """

    modes: tuple[Mode, ...]
    likelihood: Likelihood
    model: SampledModel
    sampled: bool = False

    @property
    def log_mass(self) -> float:
        """Laplace's approximation of the log evidence."""
        return float(logsumexp([mode.log_mass for mode in self.modes]))

    @abstractmethod
    def _sampled(self, rng: np.random.Generator, ess: int) -> SampledPosterior:
        """Sample it."""

    @abstractmethod
    def _weighed(self, rng: np.random.Generator) -> WeightedDraws:
        """Weigh draws of a proposal."""

    def _draws(self, store: Store, settings: Settings) -> SampledPosterior | WeightedDraws:
        rng = self.key.rng(settings.seed)
        if self.sampled:
            return store.posterior(self.key, self.model, partial(self._sampled, rng, settings.ess))
        return store.posterior(self.key, self.model, partial(self._weighed, rng))


@dataclass(frozen=True, eq=False)
class GaussianFreePair(_FreePair):
    """Under Gaussian noise: coefficients, sigmas and taus are integrated out."""

    model: FreePositionModel

    # Settings are of robust pairs: both kinds are made alike.
    @classmethod
    def of(cls, pair: LinearPair, settings: Settings, once: Once) -> GaussianFreePair:  # noqa: ARG003
        """Find the position of highest likelihood, and Laplace's approximation about it."""
        data = joint_data(pair.axes)
        model, rss = free_model(pair.points, pair.axes, pair.wanted.pair, once)
        mode = once("mode", Mode, partial(position_mode, model))
        count = sum(a.size for a in model.axes) + sum(data.inferred) + 3
        likelihood = Likelihood.of(data, rss, count)
        return cls(*pair.parts, (mode,), likelihood, model)

    def judge(self, store: Store, settings: Settings) -> JointModel:
        """Say what its draws, sampled or weighted, say."""
        model = self.model
        found = judged_by(
            store,
            self.key,
            self._draws(store, settings),
            self.likelihood,
            model.log_left_out,
            partial(self._without, settings.seed),
            position_sd=position_sd(model),
            **self.at(model.start),
        )
        # What a draw says given the other points is no in-sample density.
        return found if found.loo is None else replace(found, loo=replace(found.loo, p_eff=None))

    @property
    def approximate(self) -> float:
        """Log evidence, by Laplace's approximation."""
        return self.log_mass

    def without_groups(self, members: Array) -> Array:
        """Give the same without each group, `members` ``(n_groups, n_points)``."""
        rest = [self.model.without(np.flatnonzero(group)) for group in members]
        return np.array([position_mode(model).log_mass for model in rest])

    def linearised(self) -> Linearised:
        """About its highest likelihood."""
        pair, start = self.wanted.pair, self.model.start
        return of_pair(self.points, self.axes, pair, start, free=True)

    def _sampled(self, rng: np.random.Generator, ess: int) -> SampledPosterior:
        guess = Guess(mixture_about(self.modes, np.zeros(1)), self.modes)
        return sample_model(self.model, rng, ess, guess, POSITION_DRAWS)

    def _weighed(self, rng: np.random.Generator) -> WeightedDraws:
        """Weigh draws of Laplace's approximation; if they can't be trusted, of an adapted one."""
        draws = weigh(self.model, mixture_about(self.modes, np.zeros(1)), rng, WEIGHTED_DRAWS)
        if draws.estimate.certain:
            return draws
        adapted = adapt(self.model.log_prob, self.modes, rng).proposal
        return weigh(self.model, adapted, rng, POSITION_DRAWS)

    def _without(self, seed: int, point: int) -> EvidenceEstimate:
        """Evidence of the other points, by weighted draws."""
        rest, rng = self.model.without(point), self.key.rng(seed, point + 1)
        proposal = mixture_about((position_mode(rest),), np.zeros(1))
        return from_weights(drawn(rest, proposal, rng, REFIT_DRAWS)[1])


@dataclass(frozen=True, eq=False)
class RobustFreePair(_FreePair):
    """Under noise without a closed form: everything but tau is drawn."""

    model: RobustFreePosition

    @classmethod
    def of(cls, pair: LinearPair, settings: Settings, once: Once) -> RobustFreePair:
        """Find the modes of its density."""
        named = zip(pair.axes, pair.wanted.pair, strict=True)
        r, c = (RobustOrder.of(axis, k, settings.noise_model(axis.data)).model for axis, k in named)
        moving = moving_axes(pair.points, pair.axes, pair.wanted.pair)
        prior = position_prior(pair.points)
        found = once("position", Found, partial(robust_start, moving, prior))
        model = RobustFreePosition((r, c), moving, prior, found.start, found.ridges)
        modes = once("modes", tuple[Mode, ...], lambda: find_modes(model.log_prob, model.starts()))
        if not modes:
            raise InputError(
                f"{pair.points.source}: no position in front of the points has a likelihood for "
                f"{pair.key.family} {pair.wanted.named}; check the camera position of the setup"
            )
        likelihood = Likelihood(robust_criteria(model.names))
        return cls(*pair.parts, modes, likelihood, model)

    def judge(self, store: Store, settings: Settings) -> JointModel:
        """Say what its draws, sampled or weighted, say."""
        model = self.model
        place = frozen(model.position(self.modes[0].theta[None])[0])
        return judged_by(
            store,
            self.key,
            self._draws(store, settings),
            self.likelihood,
            model.log_likelihood,
            **self.at(place),
        )

    def _sampled(self, rng: np.random.Generator, ess: int) -> SampledPosterior:
        return sample_model(self.model, rng, ess)

    def _weighed(self, rng: np.random.Generator) -> WeightedDraws:
        """Weigh draws of an adapted proposal, of the best of a few where they fit badly.

        Draws that the choice was made by would favour proposals whose heavy weights they missed.
        """
        found: list[tuple[float, TMixture]] = []
        for _ in range(TRIES):
            proposal = adapt(self.model.log_prob, self.modes, rng).proposal
            _, log_weights = drawn(self.model, proposal, rng, ADAPTED_DRAWS)
            found.append((effective_fraction(log_weights), proposal))
            if found[-1][0] > FITTED:
                break
        best = max(found, key=lambda pair: pair[0])[1]
        return weigh(self.model, best, rng, ADAPTED_DRAWS)


def free_pairs(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Sequence[Wanted],
    points: Correspondences,
    settings: Settings,
    store: Store,
) -> list[GaussianFreePair | RobustFreePair]:
    """List the candidates of a linear family at a free position; the best is sampled."""
    pair = checked_axes(axes, orders)
    keys = [Key(family, w.named, FREE, settings.noise) for w in orders]
    named = [LinearPair(key, points, pair, w) for key, w in zip(keys, orders, strict=True)]
    kind: type[GaussianFreePair | RobustFreePair]
    kind = RobustFreePair if settings.choice.robust else GaussianFreePair
    made = [kind.of(p, settings, store.once_of(p.key)) for p in named]
    best = max(made, key=lambda candidate: candidate.log_mass)
    return [replace(one, sampled=True) if one is best else one for one in made]
