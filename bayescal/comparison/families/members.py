"""Members of a comparison across families, each with evidence and leave-one-out.

Each function fits its models at once, so that what can't be fitted is refused before anything is
sampled, and gives an iterator that samples and judges one after the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from bayescal.arrays import frozen
from bayescal.comparison.criteria import Criteria
from bayescal.comparison.families.judged import from_posterior, from_weighted, judged_model
from bayescal.comparison.families.models import (
    Axis,
    NoiseLevels,
    Wanted,
    check_orders,
    free_model,
    joint_criteria,
    joint_data,
    joint_goodness,
    orders_of,
    pinhole_model,
)
from bayescal.comparison.families.results import FamilyRequest, JointLeaveOneOut, JointModel
from bayescal.comparison.key import FREE, PINHOLE, Key
from bayescal.comparison.leave_one_out import LeaveOneOut, leave_one_out
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.density.free_position import FreePositionModel
from bayescal.density.gaussian_pinhole import GaussianPinhole
from bayescal.density.pinhole import PinholeModel
from bayescal.density.pinhole_proposal import ladder, weighted_evidence
from bayescal.density.position_search import position_mode
from bayescal.inference.adaptation import adapt
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.laplace_mixture import mixture_about
from bayescal.inference.optimum import Mode
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior, sample_model
from bayescal.inference.t_mixture import TMixture
from bayescal.inference.weighting import WeightedDraws, drawn, weigh
from bayescal.linear.closed_form import ExactPosterior, exact_posterior
from bayescal.points.correspondences import Correspondences

# Draws of the evidence where each costs a quadrature: of a family's best model at a free
# position, which is sampled, and of the others, which are weighted only.
POSITION_DRAWS, WEIGHTED_DRAWS = 4000, 2000
# Draws of the evidence without a point that leave-one-out from the draws fails for.
REFIT_DRAWS = 600
Progress = Callable[[str, int], None]


def stated_members(
    family: str, axes: tuple[Axis, Axis], orders: Wanted, points: Correspondences
) -> Iterator[JointModel]:
    """Models at the stated position: products of two axes, each in closed form."""
    check_orders(axes, orders)
    return _products(family, axes, orders, points)


def _products(
    family: str, axes: tuple[Axis, Axis], orders: Wanted, points: Correspondences
) -> Iterator[JointModel]:
    data = joint_data(axes)
    exact: list[dict[int, tuple[ExactPosterior, float, float, LeaveOneOut | None]]] = []
    for i, axis in enumerate(axes):
        by_order = {}
        for k in orders_of(orders, i):
            posterior = exact_posterior(axis.model(k))
            value, error = posterior.log_evidence, posterior.log_evidence_error
            assert value is not None, "a proper prior has an evidence"
            assert error is not None, "a proper prior has an evidence"
            by_order[k] = posterior, value, error, leave_one_out(axis.data, posterior)
        exact.append(by_order)
    for named, k, m in orders:
        (r, zr, er, lr), (c, zc, ec, lc) = exact[0][k], exact[1][m]
        rss = np.array([r.model.factors.rss(k), c.model.factors.rss(m)])
        count = r.model.size + c.model.size + sum(data.inferred)
        loo = None
        if lr is not None and lc is not None:
            loo = JointLeaveOneOut(frozen(lr.pointwise + lc.pointwise))
        yield JointModel(
            Key(family, named),
            joint_criteria(data, rss, count),
            zr + zc,
            math.hypot(er, ec),
            loo,
            frozen(points.setup.position),
            exact=(r, c),
            goodness=joint_goodness(data, rss, count),
        )


def free_members(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Wanted,
    points: Correspondences,
    settings: Settings,
    store: Store,
) -> Iterator[JointModel]:
    """Models at a free position: Laplace for all, draws for those that may matter."""
    check_orders(axes, orders)
    data, built = joint_data(axes), []
    for named, k, m in orders:
        model, rss = free_model(points, axes, (k, m))
        count = sum(a.size for a in model.axes) + sum(data.inferred) + 3
        likelihood = joint_criteria(data, rss, count), joint_goodness(data, rss, count)
        built.append((Key(family, named, FREE), model, likelihood, position_mode(model)))
    best = max(built, key=lambda b: b[3].log_mass)[0]

    def judged() -> Iterator[JointModel]:
        for name, model, (criteria, goodness), mode in built:
            proposal, rng = _about(mode), name.rng(settings.seed)
            without = partial(_without_position, model, settings, name)
            if name == best:
                guess = proposal, (mode,)
                sample = partial(sample_model, model, rng, settings.ess, guess, POSITION_DRAWS)
                posterior = store.posterior(name, model, sample)
                found = from_posterior(posterior, model.log_left_out, without)
            else:
                draw = partial(_weighed, model, mode, proposal, rng)
                weighted = store.posterior(name, model, draw)
                found = from_weighted(weighted, model.log_left_out, without)
            yield judged_model(name, criteria, found, model.start, goodness)

    return judged()


def _about(mode: Mode) -> TMixture:
    return mixture_about((mode,), np.zeros(1))


def _without_position(
    model: FreePositionModel, settings: Settings, name: Key, point: int
) -> EvidenceEstimate:
    """Evidence of the other points, by weighted draws."""
    rest, rng = model.without(point), name.rng(settings.seed, point + 1)
    proposal = _about(position_mode(rest))
    return from_weights(drawn(rest, proposal, rng, REFIT_DRAWS)[1])


def _weighed(
    model: SampledModel, mode: Mode, proposal: TMixture, rng: np.random.Generator
) -> WeightedDraws:
    """Weigh draws of Laplace's approximation; where they can't be trusted, of an adapted one."""
    draws = weigh(model, proposal, rng, WEIGHTED_DRAWS)
    if from_weights(draws.log_weights).certain:
        return draws
    adapted = adapt(model.log_prob, (mode,), rng).proposal
    return weigh(model, adapted, rng, POSITION_DRAWS)


def pinhole_members(
    points: Correspondences,
    request: FamilyRequest,
    position: str,
    levels: NoiseLevels,
    settings: Settings,
    store: Store,
) -> Iterator[JointModel]:
    """Sample the pinhole of each order at one kind of position."""
    fitted = [
        (k, pinhole_model(points, k, position, request.radial, levels.data, settings))
        for k in request.radial_orders
    ]

    def judged() -> Iterator[JointModel]:
        for k, model in fitted:
            name = Key(PINHOLE, (k,), position, settings.noise)
            sample = partial(_sample_pinhole, model, name.rng(settings.seed), settings.ess)
            posterior = store.posterior(name, model, sample)
            count = sum(levels.data.inferred) + 2 * model.noise.dimension
            count += model.geometry.dimension
            criteria, goodness = Criteria(count), None
            if model.gaussian:
                criteria = joint_criteria(levels.data, model.fit.rss, count)
                goodness = joint_goodness(levels.data, model.fit.rss, count)
            theta = model.geometry.full(model.fit.free[None])
            place = frozen(model.geometry.position(theta)[0])
            found = from_posterior(posterior, model.log_likelihood, _without(model, settings, name))
            yield judged_model(name, criteria, found, place, goodness)

    return judged()


def _sample_pinhole(model: PinholeModel, rng: np.random.Generator, ess: int) -> SampledPosterior:
    guess = None
    if isinstance(model, GaussianPinhole):
        modes, log_mass = ladder(model)
        guess = mixture_about(modes, log_mass), modes[:1]
    return sample_model(model, rng, ess, guess)


def _without(
    model: PinholeModel, settings: Settings, name: Key
) -> Callable[[int], EvidenceEstimate] | None:
    """How to have the evidence without a point, where that takes no sampling."""
    if not isinstance(model, GaussianPinhole):
        return None

    def evidence(point: int) -> EvidenceEstimate:
        rng = name.rng(settings.seed, point + 1)
        return weighted_evidence(model.without(point), rng, REFIT_DRAWS)

    return evidence
