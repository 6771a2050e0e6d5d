"""Members of linear families under a noise model without a closed form.

At the stated position r and c have nothing in common: each axis is sampled once for each of
its orders, and pairs are made of independent draws. At a free position every pair is a model
of its own: the most probable by Laplace's approximation is sampled, the others are weighed by
draws of a proposal that is adapted alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import frozen
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.families.judged import (
    Found,
    from_posterior,
    from_weighted,
    judged_model,
    leave_one_out_of,
    shortened,
)
from bayescal.comparison.families.models import Axis, Wanted, check_orders, moving_axes, orders_of
from bayescal.comparison.families.results import JointModel
from bayescal.comparison.key import FREE, Key
from bayescal.comparison.psis import good_k
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.density.robust_pair import RobustPair, paired
from bayescal.density.robust_position import RobustFreePosition
from bayescal.errors import InputError
from bayescal.inference.adaptation import adapt, effective_fraction
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.optimum import Mode, find_modes
from bayescal.inference.sampled_posterior import FITTED, SampledPosterior, sample_model
from bayescal.inference.t_mixture import TMixture
from bayescal.inference.weighting import WeightedDraws, drawn, weigh
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.prior.camera import position_prior

# Draws that a pair of orders at a free position is weighed by, where it is not sampled.
ADAPTED_DRAWS = 4000
TRIES = 3


def stated_robust(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Wanted,
    points: Correspondences,
    settings: Settings,
    store: Store,
) -> Iterator[JointModel]:
    """Models at the stated position: products of two axes, each sampled."""
    models = [
        {k: _axis_model(axis, k, settings) for k in orders_of(orders, i)}
        for i, axis in enumerate(axes)
    ]

    def posterior(i: int, order: int) -> SampledPosterior:
        """Sample an axis, as a comparison of its orders would."""
        key, model = Key.of_axis(AXES[i], order, settings.noise, family), models[i][order]
        sample = partial(sample_model, model, key.rng(settings.seed), settings.ess)
        return store.posterior(key, model, sample, beside=True)

    def judged() -> Iterator[JointModel]:
        for named, k, m in orders:
            pair = RobustPair((models[0][k], models[1][m]))
            name = Key(family, named, noise=settings.noise)

            def sample(k: int = k, m: int = m, pair: RobustPair = pair) -> SampledPosterior:
                return paired(posterior(0, k), posterior(1, m), pair)

            found = _from_pair(store.posterior(name, pair, sample))
            place = frozen(points.setup.position)
            yield judged_model(name, _no_criteria(pair.names), found, place)

    return judged()


def _axis_model(axis: Axis, order: int, settings: Settings) -> RobustLinearModel:
    axis.data.check(order)
    prior = axis.rule.of_degrees(axis.data.degrees(order))
    shape = settings.noise_model(axis.data)
    return RobustLinearModel.of_order(axis.data, order, axis.noise, prior, shape)


def _no_criteria(names: tuple[str, ...]) -> Criteria:
    """Give K alone: everything inferred but tau, a hyperparameter."""
    k = sum(not name.startswith("tau") for name in names)
    return Criteria(k)


def _from_pair(posterior: SampledPosterior) -> Found:
    """Evidence and leave-one-out of two independent axes: the sum of theirs."""
    pair = posterior.model
    assert isinstance(pair, RobustPair), "it was built as one"
    kept = shortened(posterior)
    loos = [psis_loo(likelihood.T) for likelihood in pair.log_likelihoods(kept)]
    pointwise = np.sum([loo.pointwise for loo in loos], axis=0)
    shape = np.concatenate([loo.pareto_k for loo in loos])
    mcse = math.hypot(*(loo.mcse_of_sum for loo in loos))
    loo = leave_one_out_of(pointwise, shape, good_k(len(kept)), mcse)
    return Found(posterior.log_evidence, posterior.log_evidence_error, loo, posterior)


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A pair of orders at a free position, before its draws."""

    name: Key
    model: RobustFreePosition
    modes: tuple[Mode, ...]

    @property
    def log_mass(self) -> float:
        """Laplace's approximation of the log evidence."""
        return float(logsumexp([mode.log_mass for mode in self.modes]))


def free_robust(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Wanted,
    points: Correspondences,
    settings: Settings,
    store: Store,
) -> Iterator[JointModel]:
    """Models at a free position: the best is sampled, the others are weighed."""
    check_orders(axes, orders)
    candidates = [_candidate(family, axes, wanted, points, settings) for wanted in orders]
    best = max(candidates, key=lambda c: c.log_mass)

    def judged() -> Iterator[JointModel]:
        for made in candidates:
            key, model = made.name, made.model
            rng = key.rng(settings.seed)
            if made is best:
                sample = partial(sample_model, model, rng, settings.ess)
                found = from_posterior(store.posterior(key, model, sample), model.log_likelihood)
            else:
                draw = partial(_weighed, made, rng)
                found = from_weighted(store.posterior(key, model, draw), model.log_likelihood)
            place = frozen(model.position(made.modes[0].theta[None])[0])
            yield judged_model(made.name, _no_criteria(model.names), found, place)

    return judged()


def _candidate(
    family: str,
    axes: tuple[Axis, Axis],
    wanted: tuple[tuple[int, ...], int, int],
    points: Correspondences,
    settings: Settings,
) -> _Candidate:
    named, k, m = wanted
    r, c = (_axis_model(axis, order, settings) for axis, order in zip(axes, (k, m), strict=True))
    moving = moving_axes(points, axes, (k, m))
    model = RobustFreePosition.of((r, c), moving, position_prior(points))
    modes = find_modes(model.log_prob, model.starts())
    if not modes:
        raise InputError(
            f"{points.source}: no position in front of the points has a likelihood for "
            f"{family} {named}; check the camera position of the setup"
        )
    return _Candidate(Key(family, named, FREE, settings.noise), model, modes)


def _weighed(made: _Candidate, rng: np.random.Generator) -> WeightedDraws:
    """Weigh draws of an adapted proposal, of the best of a few where they fit badly.

    Draws that the choice was made by would favour proposals whose heavy weights they missed.
    """
    found: list[tuple[float, TMixture]] = []
    for _ in range(TRIES):
        proposal = adapt(made.model.log_prob, made.modes, rng).proposal
        _, log_weights = drawn(made.model, proposal, rng, ADAPTED_DRAWS)
        found.append((effective_fraction(log_weights), proposal))
        if found[-1][0] > FITTED:
            break
    best = max(found, key=lambda pair: pair[0])[1]
    return weigh(made.model, best, rng, ADAPTED_DRAWS)
