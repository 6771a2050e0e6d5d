"""From points and settings to a comparison across families: the loop over joint models."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import softmax
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array, frozen
from bayescal.comparison.families import (
    FREE,
    STATED,
    FamilyComparison,
    JointModel,
    ModelName,
    judge_families,
    model_probabilities,
)
from bayescal.comparison.leave_one_out import LeaveOneOut, leave_one_out
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.inference.closed_form import exact_posterior
from bayescal.inference.estimate import from_weights
from bayescal.inference.free_position import FreePositionModel, MovingAxis
from bayescal.inference.laplace_mixture import mixture_about
from bayescal.inference.least_squares import factorise
from bayescal.inference.model import LinearModel
from bayescal.inference.pinhole import PinholeModel
from bayescal.inference.pinhole_fit import JointData, PinholeFit, fit_pinhole
from bayescal.inference.pinhole_proposal import ladder
from bayescal.inference.position_search import best_position, position_mode
from bayescal.inference.sampled_posterior import SampledPosterior, sample_model
from bayescal.inference.t_mixture import TMixture
from bayescal.models import bivariate, separable
from bayescal.models.camera_prior import PinholePrior, pinhole_prior, position_prior
from bayescal.models.linear import AxisData
from bayescal.models.noise.choice import NoiseChoice
from bayescal.models.noise.level import NoiseLevel
from bayescal.models.pinhole import PinholeGeometry, Radial
from bayescal.models.priors import PriorRule
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.settings import Settings, noise_level, prior_rule

PINHOLE = "pinhole"
LINEAR = {separable.NAME: separable.axis_data, bivariate.NAME: bivariate.axis_data}
FAMILIES = (*LINEAR, PINHOLE)
PINHOLE_ORDERS = (0, 1, 2, 3)
# Draws of the evidence where each costs a quadrature: of a family's best model at a free
# position, which is sampled, and of the others, which are weighted only.
POSITION_DRAWS, WEIGHTED_DRAWS = 4000, 600
EQUAL = ("families are equally probable beforehand; within one its positions, then its orders",)
Progress = Callable[[str, int], None]
Wanted = list[tuple[tuple[int, ...], int, int]]  # orders as named, of r, of c


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a linear family: its data, noise level and prior rule.

    Attributes
    ----------
    data : AxisData
    noise : NoiseLevel
    rule : PriorRule
    source : str
        How the noise level was chosen, in words.
    """

    data: AxisData
    noise: NoiseLevel
    rule: PriorRule
    source: str

    def model(self, order: int) -> LinearModel:
        """Make the likelihood model of an order."""
        self.data.check(order)
        prior = self.rule.of_degrees(self.data.degrees(order))
        return LinearModel(factorise(self.data, order), order, self.noise, prior, self.data.symbol)


def compare_joint(
    points: Correspondences,
    families: Sequence[str],
    orders: Sequence[int],
    positions: Sequence[str] | None,
    radial: Radial,
    settings: Settings,
    pinhole_orders: Sequence[int] = PINHOLE_ORDERS,
    progress: Progress | None = None,
    pairs: Sequence[tuple[int, int]] | None = None,
) -> FamilyComparison:
    """Compare families of models of both axes.

    Parameters
    ----------
    points : Correspondences
    families : sequence of str
        Of ``"separable"``, ``"bivariate"``, ``"pinhole"``.
    orders : sequence of int
        Polynomial degrees, ascending; every pair of them in the separable family.
    positions : sequence of str or None
        ``"stated"``, ``"free"`` or both; None: stated, and free for a pinhole, whose
        position is part of its pose.
    radial : str
        Powers of the radius, ``"even"`` or ``"all"``.
    settings : Settings
    pinhole_orders : sequence of int, optional
        Numbers of radial coefficients.
    progress : callable or None
    pairs : sequence of tuple of int, optional
        The only pairs of orders, of r and c, to take in the separable family.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        Where the points can't determine a model, or a family has no such noise.
    """
    check_request(families, positions, settings)
    with threadpool_limits(1):
        axes = {f: _axes(points, f, settings, orders[-1]) for f in families if f in LINEAR}
        levels = _levels(points, settings, orders[-1])
        found: list[JointModel] = []
        for family in families:
            wanted = positions or ((FREE,) if family == PINHOLE else (STATED,))
            for position in dict.fromkeys(wanted):
                if progress is not None:
                    progress(f"{family}, position {position}", 0)
                if family == PINHOLE:
                    ks = pinhole_orders
                    found += _pinholes(points, ks, position, radial, levels, settings)
                    continue
                wanted_orders = _wanted(family, orders, pairs)
                if position == STATED:
                    found += _stated(family, axes[family], wanted_orders, points)
                else:
                    found += _free(family, axes[family], wanted_orders, points, settings)
    chances = model_probabilities(found)
    order = sorted(range(len(found)), key=lambda i: -chances[i])
    models = tuple(found[i] for i in order)
    sorted_chances = tuple(chances[i] for i in order)
    verdict = judge_families(models, sorted_chances, _caveats(points, models, sorted_chances))
    priors = _prior_words(points, families, positions, axes, settings)
    return FamilyComparison(
        points,
        models,
        sorted_chances,
        radial,
        priors,
        levels.words,
        verdict,
        EQUAL,
        settings.seed,
        settings.ess,
    )


def check_request(
    families: Sequence[str], positions: Sequence[str] | None, settings: Settings
) -> None:
    """Refuse what no family, or not this one, can do.

    Raises
    ------
    InputError
    """
    for family in families:
        if family not in FAMILIES:
            raise InputError(f"family must be {', '.join(FAMILIES)}, not {family!r}")
    for position in positions or ():
        if position not in (STATED, FREE):
            raise InputError(f"position must be stated or free, not {position!r}")
    if settings.prior == "flat":
        raise InputError("a flat prior has no evidence, which families are compared by; drop it")
    linear = [f for f in families if f in LINEAR]
    if settings.noise != "gaussian" and linear:
        raise InputError(
            f"--noise {settings.noise} across families goes with --family pinhole alone so far; "
            f"{linear[0]} has it axis by axis: drop --family"
        )


@dataclass(frozen=True, eq=False)
class _Levels:
    data: JointData
    words: tuple[str, str]


def _axes(
    points: Correspondences, family: str, settings: Settings, highest: int
) -> tuple[Axis, Axis]:
    out = []
    for axis in AXES:
        data = LINEAR[family](points, axis)
        other = separable.axis_data(points, "c" if axis == "r" else "r").x
        own = separable.axis_data(points, axis)
        usable, level, words = noise_level(own, settings, other, min(highest, 5))
        stated = points.setup.priors.get(axis) if family == separable.NAME else None
        rule = prior_rule(data, settings, stated)
        out.append(Axis(replace(data, sd=usable.sd), level, rule, words))
    return out[0], out[1]


def _levels(points: Correspondences, settings: Settings, highest: int) -> _Levels:
    """Noise levels of a joint model: as the separable family's where its regressors exist."""
    pixels = np.stack([points.pixel(axis) for axis in AXES])
    sds, levels, words = [], [], []
    for i, axis in enumerate(AXES):
        try:
            own = separable.axis_data(points, axis)
            other = separable.axis_data(points, AXES[1 - i]).x
            usable, level, text = noise_level(own, settings, other, min(highest, 5))
            sd = usable.sd
        except InputError:
            if points.world_sigma() is not None or settings.sigma in ("replicates", "scale"):
                raise
            sd = points.sigma.get(axis) if settings.sigma is None else None
            level, text = _plain_level(settings, sd)
        sds.append(sd)
        levels.append(level)
        words.append(text)
    data = JointData(frozen(pixels), (sds[0], sds[1]), (levels[0], levels[1]))
    return _Levels(data, (words[0], words[1]))


def _plain_level(settings: Settings, sd: Array | None) -> tuple[NoiseLevel, str]:
    if sd is not None:
        return NoiseLevel.known(1.0), "known per point, from the data"
    if isinstance(settings.sigma, float):
        return NoiseLevel.known(settings.sigma), f"known, {settings.sigma:g} px"
    return NoiseLevel.inferred(), "inferred"


def _wanted(family: str, orders: Sequence[int], pairs: Sequence[tuple[int, int]] | None) -> Wanted:
    """Orders as named, and of r and c."""
    if family != separable.NAME:
        return [((k,), k, k) for k in orders]
    listed = pairs if pairs is not None else [(k, m) for k in orders for m in orders]
    return [((k, m), k, m) for k, m in listed]


def joint_data(axes: tuple[Axis, Axis]) -> JointData:
    """Pixels of both axes with their noise levels."""
    r, c = axes
    return JointData(np.stack([r.data.t, c.data.t]), (r.data.sd, c.data.sd), (r.noise, c.noise))


def criteria_of(log_likelihood: float, k: int, n: int) -> tuple[float, float]:
    """Give AIC and BIC of K parameters; n counts points."""
    return -2 * log_likelihood + 2 * k, -2 * log_likelihood + k * math.log(n)


def _stated(
    family: str, axes: tuple[Axis, Axis], orders: Wanted, points: Correspondences
) -> list[JointModel]:
    """Models at the stated position: products of two axes, each in closed form."""
    data, n = joint_data(axes), len(points)
    exact: list[dict[int, tuple[LinearModel, float, float, LeaveOneOut | None]]] = []
    for i, axis in enumerate(axes):
        by_order = {}
        for k in sorted({w[1] if i == 0 else w[2] for w in orders}):
            model = axis.model(k)
            posterior = exact_posterior(model)
            value, error = posterior.log_evidence, posterior.log_evidence_error
            assert value is not None, "a proper prior has an evidence"
            assert error is not None, "a proper prior has an evidence"
            by_order[k] = model, value, error, leave_one_out(axis.data, posterior)
        exact.append(by_order)
    out = []
    for named, k, m in orders:
        (r, zr, er, lr), (c, zc, ec, lc) = exact[0][k], exact[1][m]
        rss = np.array([r.factors.rss(k), c.factors.rss(m)])
        likelihood = data.log_likelihood(rss)
        count = r.size + c.size + sum(data.inferred)
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
            )
        )
    return out


def _elpd(pointwise: Array | None) -> tuple[float | None, float | None, Array | None]:
    if pointwise is None:
        return None, None, None
    se = math.sqrt(len(pointwise)) * float(pointwise.std(ddof=1))
    return float(pointwise.sum()), se, frozen(pointwise)


def free_model(
    points: Correspondences, axes: tuple[Axis, Axis], orders: tuple[int, int]
) -> tuple[FreePositionModel, float]:
    """Build a linear family's model at a free position, and its maximised log likelihood."""
    prior = position_prior(points)
    moving = [
        MovingAxis(a.data, points.world, i, k, a.noise, a.rule.of_degrees(a.data.degrees(k)))
        for i, (a, k) in enumerate(zip(axes, orders, strict=True))
    ]
    start, likelihood = best_position(moving, prior, joint_data(axes).log_likelihood)
    return FreePositionModel((moving[0], moving[1]), prior, frozen(start)), likelihood


def _free(
    family: str,
    axes: tuple[Axis, Axis],
    orders: Wanted,
    points: Correspondences,
    settings: Settings,
) -> list[JointModel]:
    """Models at a free position: Laplace for all, draws for those that may matter."""
    for i, axis in enumerate(axes):
        axis.data.check(max(w[1] if i == 0 else w[2] for w in orders))
        if axis.data.x_sd is not None and axis.data.x_sd.any():
            raise InputError(
                f"{points.source}: errors of the world coordinates with a free camera position "
                "are not available; drop sigma_x, sigma_y, sigma_z or --position free"
            )
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
            posterior = sample_model(model, rng, settings.ess, guess, POSITION_DRAWS)
            found = _from_posterior(posterior)
        else:
            found = _from_weights(model, proposal, rng)
        start = model.start
        out.append(_joint(name, count, likelihood, len(points), found, start))
    return out


@dataclass(frozen=True, eq=False)
class _Found:
    """What draws say of a model."""

    log_evidence: float
    error: float
    pointwise: Array
    pareto_k: float
    posterior: SampledPosterior | None
    doubts: tuple[str, ...] = ()


def _from_posterior(posterior: SampledPosterior) -> _Found:
    """Evidence and leave-one-out of a sampled model, the latter from 4000 draws at most."""
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    step = max(1, len(full) // 4000)
    pointwise, _, shape = psis_loo(posterior.model.log_likelihood(full[::step]).T)
    error = posterior.log_evidence_error
    return _Found(posterior.log_evidence, error, pointwise, float(shape.max()), posterior)


def _from_weights(model: FreePositionModel, proposal: TMixture, rng: np.random.Generator) -> _Found:
    """Find the same by importance sampling: in three dimensions nearly every draw is effective."""
    theta = proposal.draw(rng, WEIGHTED_DRAWS)
    log_w = model.log_prob(theta) - proposal.log_density(theta)
    estimate = from_weights(log_w)
    again = theta[rng.choice(len(log_w), len(log_w), p=softmax(log_w))]
    likelihood = model.log_likelihood(model.complete(again, rng))
    pointwise, _, shape = psis_loo(likelihood.T)
    value, error, doubts = estimate.log_evidence, estimate.error, estimate.warnings
    return _Found(value, error, pointwise, float(shape.max()), None, doubts)


def _joint(
    name: ModelName, count: int, likelihood: float, n: int, found: _Found, position: Array
) -> JointModel:
    aic, bic = criteria_of(likelihood, count, n)
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
    )


def pinhole_model(
    points: Correspondences,
    order: int,
    position: str,
    radial: Radial,
    data: JointData,
    settings: Settings,
) -> PinholeModel:
    """Build and fit a pinhole of one order."""
    prior: PinholePrior = pinhole_prior(points, settings.tau)
    fixed = frozen(points.setup.position) if position == STATED else None
    geometry = PinholeGeometry(
        points.world, prior.orientation, prior.half_diagonal, order, radial, fixed
    )
    fit: PinholeFit = fit_pinhole(points, geometry, prior, data)
    choice = NoiseChoice(settings.noise, settings.nu, settings.bad_offset)
    return PinholeModel.of(geometry, prior, data, fit, choice.model(1.0))


def _pinholes(
    points: Correspondences,
    orders: Sequence[int],
    position: str,
    radial: Radial,
    levels: _Levels,
    settings: Settings,
) -> list[JointModel]:
    out = []
    for k in orders:
        model = pinhole_model(points, k, position, radial, levels.data, settings)
        name = ModelName(PINHOLE, (k,), position)
        guess = None
        if model.gaussian:
            modes, log_mass = ladder(model)
            guess = mixture_about(modes, log_mass), modes[:1]
        posterior = sample_model(model, _rng(settings, name), settings.ess, guess)
        count = model.geometry.dimension + sum(levels.data.inferred)
        count += 0 if model.gaussian else 2 * model.noise.dimension
        theta = model.geometry.full(model.fit.free[None])
        position_found = frozen(model.geometry.position(theta)[0])
        likelihood = model.fit.log_likelihood
        found = _from_posterior(posterior)
        out.append(_joint(name, count, likelihood, len(points), found, position_found))
    return out


def _rng(settings: Settings, name: ModelName) -> np.random.Generator:
    """Random numbers of one model, keyed by its name, so that no other changes them."""
    key = (2 + FAMILIES.index(name.family), int(name.position == FREE), *name.orders)
    return np.random.default_rng(np.random.SeedSequence(settings.seed, spawn_key=key))


def _caveats(
    points: Correspondences, models: Sequence[JointModel], chances: Sequence[float]
) -> list[str]:
    out = []
    for model, chance in zip(models, chances, strict=True):
        if chance < 0.01:
            continue
        out += [f"the evidence of {model.name}: {warning}" for warning in model.warnings]
        if model.posterior is not None and not model.posterior.converged:
            out.append(f"sampling of {model.name} did not reach the stopping rule")
        if model.pareto_k is not None and model.pareto_k > 1:
            out.append(f"leave-one-out of {model.name} rests on few draws (Pareto k > 1)")
    best = models[0]
    if best.posterior is not None and best.name.position == FREE:
        prior = position_prior(points)
        shift = np.abs(best.position - prior.mean) / prior.sd
        if shift.max() > 3:
            out.append(
                f"the position found is {shift.max():.1f} prior sds from the stated one: "
                "prior and data disagree"
            )
    if {m.name.position for m in models} == {STATED, FREE} and not position_prior(points).stated:
        # Three normal densities of twice the width are an eighth as high at the most.
        out.append(
            "the evidence of a free position depends on its prior's sd, which is a default: "
            f"twice as wide would cost it up to {3 * math.log(2):.1f} nat; the setup's position_sd "
            "sets it"
        )
    known = [m for m in models if m.elpd is not None]
    ahead = max(known, key=lambda m: m.elpd or 0.0, default=best)
    if ahead is not best and best.elpd_pointwise is not None and ahead.elpd_pointwise is not None:
        difference = ahead.elpd_pointwise - best.elpd_pointwise
        total = float(difference.sum())
        se = math.sqrt(len(difference)) * float(difference.std(ddof=1))
        if total > max(4.0, 2 * se):
            out.append(f"leave-one-out prefers {ahead.name}, by {total:.1f} +- {se:.1f}")
    return out


def _prior_words(
    points: Correspondences,
    families: Sequence[str],
    positions: Sequence[str] | None,
    axes: dict[str, tuple[Axis, Axis]],
    settings: Settings,
) -> tuple[str, ...]:
    out = []
    for family, pair in axes.items():
        r, c = pair
        names = f"{r.rule.name}" if r.rule.name == c.rule.name else f"{r.rule.name}, {c.rule.name}"
        strong = "tau inferred per axis" if settings.tau is None else f"tau = {settings.tau:g}"
        out.append(f"{family}: {names}, on Legendre amplitudes, {strong}")
    if FREE in (positions or ()) and axes:
        out.append(f"free position: {position_prior(points)}; the basis keeps its domain")
    if PINHOLE in families:
        out += [f"pinhole: {line}" for line in str(pinhole_prior(points, settings.tau)).split("\n")]
    return tuple(out)
