"""Members of a comparison across families, each with evidence and leave-one-out."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array, frozen
from bayescal.comparison.families import (
    FREE,
    PINHOLE,
    STATED,
    FamilyRequest,
    JointModel,
    ModelName,
)
from bayescal.comparison.leave_one_out import LeaveOneOut, leave_one_out
from bayescal.comparison.psis import good_k
from bayescal.family_models import (
    FAMILIES,
    Axis,
    NoiseLevels,
    Wanted,
    check_free,
    criteria_of,
    free_model,
    joint_data,
    orders_of,
    pinhole_model,
)
from bayescal.inference.adaptation import adapt
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.closed_form import ExactPosterior, exact_posterior
from bayescal.inference.estimate import EvidenceEstimate
from bayescal.inference.estimate import from_weights as evidence_of
from bayescal.inference.gaussian_pinhole import GaussianPinhole
from bayescal.inference.laplace_mixture import mixture_about
from bayescal.inference.optimum import Mode
from bayescal.inference.pinhole import PinholeModel
from bayescal.inference.pinhole_proposal import ladder, weighted_evidence
from bayescal.inference.position_search import position_mode
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.sampled_posterior import SampledPosterior, sample_model
from bayescal.inference.t_mixture import TMixture
from bayescal.inference.weighting import WeightedDraws, weigh
from bayescal.points.correspondences import Correspondences
from bayescal.settings import Settings
from bayescal.sources import DrawsSource

# Draws of the evidence where each costs a quadrature: of a family's best model at a free
# position, which is sampled, and of the others, which are weighted only.
POSITION_DRAWS, WEIGHTED_DRAWS = 4000, 600
# Share of the weight of all that one weighted draw may have: of its copies the tail that tells
# of a point left out would be made.
HEAVIEST = 0.02
LOO_DRAWS = 4000  # of a sampled model, at most twice as many
# Draws of the evidence without a point that leave-one-out from the draws fails for, and the
# most such points that are worth it.
REFIT_DRAWS, MOST_REFITS = 4000, 20
Progress = Callable[[str, int], None]


def stated_members(
    family: str, axes: tuple[Axis, Axis], orders: Wanted, points: Correspondences
) -> list[JointModel]:
    """Models at the stated position: products of two axes, each in closed form."""
    data, n = joint_data(axes), len(points)
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
    out = []
    for named, k, m in orders:
        (r, zr, er, lr), (c, zc, ec, lc) = exact[0][k], exact[1][m]
        rss = np.array([r.model.factors.rss(k), c.model.factors.rss(m)])
        likelihood = data.log_likelihood(rss)
        count = r.model.size + c.model.size + sum(data.inferred)
        pointwise = lr.pointwise + lc.pointwise if lr is not None and lc is not None else None
        aic, bic = criteria_of(likelihood, count, n)
        out.append(
            JointModel(
                ModelName(family, named, STATED),
                count,
                likelihood,
                aic,
                bic,
                zr + zc,
                math.hypot(er, ec),
                *_elpd(pointwise),
                None,
                frozen(points.setup.position),
                exact=(r, c),
            )
        )
    return out


def _elpd(pointwise: Array | None) -> tuple[float | None, float | None, Array | None]:
    if pointwise is None:
        return None, None, None
    se = math.sqrt(len(pointwise)) * float(pointwise.std(ddof=1))
    return float(pointwise.sum()), se, frozen(pointwise)


def free_members(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Wanted,
    points: Correspondences,
    settings: Settings,
    source: DrawsSource,
) -> list[JointModel]:
    """Models at a free position: Laplace for all, draws for those that may matter."""
    check_free(axes, orders, points)
    built = []
    for named, k, m in orders:
        model, likelihood = free_model(points, axes, (k, m))
        built.append((ModelName(family, named, FREE), model, likelihood, position_mode(model)))
    best = max(built, key=lambda b: b[3].log_mass)[0]
    out = []
    for name, model, likelihood, mode in built:
        count = sum(a.size for a in model.axes) + sum(a.noise.value is None for a in axes) + 3
        proposal, rng = mixture_about((mode,), np.zeros(1)), _rng(settings, name)
        if name == best:
            guess = proposal, (mode,)
            sample = partial(sample_model, model, rng, settings.ess, guess, POSITION_DRAWS)
            found = from_posterior(source.sampled(name.key, model, sample))
        else:
            draw = partial(_weighed, model, mode, proposal, rng)
            found = from_weights(model, source.weighted(name.key, model, draw))
        start = model.start
        out.append(judged_model(name, count, likelihood, len(points), found, start))
    return out


def _weighed(
    model: SampledModel, mode: Mode, proposal: TMixture, rng: np.random.Generator
) -> WeightedDraws:
    """Weigh draws of Laplace's approximation; where they can't be trusted, of an adapted one."""
    draws = weigh(model, proposal, rng, WEIGHTED_DRAWS)
    if evidence_of(draws.log_weights).certain:
        return draws
    adapted = adapt(model.log_prob, (mode,), rng).proposal
    return weigh(model, adapted, rng, POSITION_DRAWS)


@dataclass(frozen=True, eq=False)
class Found:
    """What draws say of a model."""

    log_evidence: float
    error: float
    pointwise: Array | None
    pareto_k: float
    k_limit: float | None
    posterior: SampledPosterior | None
    doubts: tuple[str, ...] = ()
    weighted: WeightedDraws | None = None
    refitted: tuple[int, ...] = ()


def shortened(posterior: SampledPosterior) -> Array:
    """Completed draws, every so many of them, ``(n, n_full)``."""
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    return full[:: max(1, len(full) // LOO_DRAWS)]


def from_posterior(
    posterior: SampledPosterior, without: Callable[[int], EvidenceEstimate] | None = None
) -> Found:
    """Evidence and leave-one-out of a sampled model.

    Where a point's weights have too heavy a tail, its term comes from the evidence `without`
    it, if that is to be had: ln p(t_i | the others) = ln Z - ln Z_-i.
    """
    kept = shortened(posterior)
    pointwise, _, shape = psis_loo(posterior.model.log_likelihood(kept).T)
    value, error, limit = posterior.log_evidence, posterior.log_evidence_error, good_k(len(kept))
    heavy = [int(i) for i in np.flatnonzero(~(shape < limit))]
    refitted = []
    if without is not None and len(heavy) <= MOST_REFITS:
        for i in heavy:
            rest = without(i)
            if rest.certain:
                pointwise[i], shape[i] = value - rest.log_evidence, rest.pareto_k
                refitted.append(i)
    told, largest = finite(pointwise), float(shape.max())
    return Found(value, error, told, largest, limit, posterior, refitted=tuple(refitted))


def from_weights(model: SampledModel, draws: WeightedDraws) -> Found:
    """Find the same by importance sampling alone."""
    estimate = evidence_of(draws.log_weights)
    value, error, doubts = estimate.log_evidence, estimate.error, estimate.warnings
    if float(softmax(draws.log_weights).max()) > HEAVIEST:
        return Found(value, error, None, math.inf, None, None, doubts, draws)
    pointwise, _, shape = psis_loo(model.log_likelihood(draws.full).T)
    limit, largest = good_k(len(draws.full)), float(shape.max())
    return Found(value, error, finite(pointwise), largest, limit, None, doubts, draws)


def finite(pointwise: Array) -> Array | None:
    """Leave-one-out of every point; None where too few draws count to tell of one."""
    return pointwise if np.isfinite(pointwise).all() else None


def judged_model(
    name: ModelName, count: int, likelihood: float | None, n: int, found: Found, position: Array
) -> JointModel:
    """Make a member of what was found; without a likelihood there are no AIC and BIC."""
    aic, bic = (None, None) if likelihood is None else criteria_of(likelihood, count, n)
    return JointModel(
        name,
        count,
        likelihood,
        aic,
        bic,
        found.log_evidence,
        found.error,
        *_elpd(found.pointwise),
        found.pareto_k,
        position,
        found.posterior,
        found.doubts,
        found.k_limit,
        weighted=found.weighted,
        refitted=found.refitted,
    )


def pinhole_members(
    points: Correspondences,
    request: FamilyRequest,
    position: str,
    levels: NoiseLevels,
    settings: Settings,
    source: DrawsSource,
) -> list[JointModel]:
    """Sample the pinhole of each order at one kind of position."""
    fitted = [
        (k, pinhole_model(points, k, position, request.radial, levels.data, settings))
        for k in request.radial_orders
    ]  # what can't be fitted is refused before anything is sampled
    out = []
    for k, model in fitted:
        name = ModelName(PINHOLE, (k,), position)
        sample = partial(_sample_pinhole, model, _rng(settings, name), settings.ess)
        posterior = source.sampled(name.key, model, sample)
        count = model.geometry.dimension + sum(levels.data.inferred)
        count += 0 if model.gaussian else 2 * model.noise.dimension
        theta = model.geometry.full(model.fit.free[None])
        position_found = frozen(model.geometry.position(theta)[0])
        likelihood = model.fit.log_likelihood if model.gaussian else None
        found = from_posterior(posterior, _without(model, settings, name))
        out.append(judged_model(name, count, likelihood, len(points), found, position_found))
    return out


def _sample_pinhole(model: PinholeModel, rng: np.random.Generator, ess: int) -> SampledPosterior:
    guess = None
    if isinstance(model, GaussianPinhole):
        modes, log_mass = ladder(model)
        guess = mixture_about(modes, log_mass), modes[:1]
    return sample_model(model, rng, ess, guess)


def _without(
    model: PinholeModel, settings: Settings, name: ModelName
) -> Callable[[int], EvidenceEstimate] | None:
    """How to have the evidence without a point, where that takes no sampling."""
    if not isinstance(model, GaussianPinhole):
        return None

    def evidence(point: int) -> EvidenceEstimate:
        rng = _rng(settings, name, point + 1)
        return weighted_evidence(model.without(point), rng, REFIT_DRAWS)

    return evidence


def random_numbers(settings: Settings, family: str, key: tuple[int, ...]) -> np.random.Generator:
    """Random numbers of one model of a family, by a key of its own: no other changes them.

    The key of a pair of axes begins with 1 at a free position and with 0 at the stated one.
    """
    whole = (2 + FAMILIES.index(family), *key)
    return np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=whole))


def _rng(settings: Settings, name: ModelName, *further: int) -> np.random.Generator:
    key = (int(name.position == FREE), *name.orders, *further)
    return random_numbers(settings, name.family, key)
