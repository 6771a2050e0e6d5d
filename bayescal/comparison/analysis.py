"""From points and settings to a comparison: the one place that loops over orders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.caveats import caveats, notes
from bayescal.comparison.criteria import criteria
from bayescal.comparison.evidence import probabilities
from bayescal.comparison.goodness import goodness_of_fit, reference_sigma
from bayescal.comparison.key import Key
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.comparison.settings import Settings, check_resolved, noise_level, prior_rule
from bayescal.comparison.store import Store
from bayescal.comparison.verdict import judge
from bayescal.inference.posterior import Posterior, sample_posterior
from bayescal.linear.least_squares import LeastSquaresFit, factorise, solve
from bayescal.linear.model import LinearModel
from bayescal.linear.replicates import pure_error
from bayescal.points.correspondences import Correspondences
from bayescal.points.groups import Groups, groups_of
from bayescal.points.setup import AXES, StatedPrior
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData

Progress: TypeAlias = Callable[[str, int], None]


@dataclass(frozen=True, eq=False)
class _Task:
    """One axis to compare, with what is known beside its own numbers."""

    data: AxisData
    orders: Sequence[int]
    other: Array | None = None
    camera: Array | None = None
    stated: StatedPrior | None = None
    groups: Groups | None = None
    group_names: tuple[str, ...] | None = None


def analyse_points(
    points: Correspondences,
    orders: dict[str, tuple[int, ...]],
    settings: Settings,
    progress: Progress | None,
    store: Store | None = None,
) -> Comparison:
    """Compare the orders wanted of each axis of the separable family.

    Parameters
    ----------
    points : Correspondences
    orders : dict of str to tuple of int
        Ascending orders by axis.
    settings : Settings
    progress : callable or None
        Called with axis and order before each model is sampled.
    store : Store, optional
        Where posteriors come from; by default they are sampled.

    Returns
    -------
    Comparison
    """
    data = {axis: separable.axis_data(points, axis) for axis in AXES}
    for axis, wanted in orders.items():
        # Refuse before anything is sampled.
        data[axis].check(wanted[-1])
        prior_rule(data[axis], settings, points.setup.priors.get(axis)).of_order(wanted[-1])
    groups = groups_of(points)
    tasks = {
        axis: _Task(
            data[axis],
            wanted,
            other=data["c" if axis == "r" else "r"].x,
            camera=points.camera_frame(),
            stated=points.setup.priors.get(axis),
            groups=groups,
            group_names=points.groups,
        )
        for axis, wanted in orders.items()
    }
    # One thread: a sum split over cores rounds differently from machine to machine.
    with threadpool_limits(1):
        kept = store or Store()
        axes = {a: _compare_axis(task, settings, progress, kept) for a, task in tasks.items()}
    assumed = notes(points, axes.values())
    return Comparison(axes, separable.NAME, points, settings, assumed)


def analyse_arrays(data: AxisData, orders: Sequence[int], settings: Settings) -> Comparison:
    """Compare orders of a generic one-axis problem.

    Parameters
    ----------
    data : AxisData
    orders : sequence of int
        Ascending.
    settings : Settings

    Returns
    -------
    Comparison
        With the single axis ``"y"``.
    """
    with threadpool_limits(1):
        result = _compare_axis(_Task(data, orders), settings, None, Store())
    assumed = (f"y: its span, {data.size:.6g}, stands for the image size in the prior",)
    return Comparison({"y": result}, "polynomial", None, settings, assumed)


def _compare_axis(
    task: _Task, settings: Settings, progress: Progress | None, store: Store
) -> AxisComparison:
    orders = task.orders
    data, noise, noise_source = noise_level(task.data, settings, task.other, orders[-1])
    rule = prior_rule(data, settings, task.stated)
    factors = factorise(data, orders[-1])
    priors = {k: rule.of_order(k) for k in orders}
    fits = {k: solve(factors, k, noise.plug_in) for k in orders}
    where, rss = f"{data.source}: axis {data.axis}", fits[orders[-1]].rss
    check_resolved(where, noise, rss, len(data), orders[-1])
    if settings.choice.robust:
        from bayescal.comparison.robust_analysis import compare_robustly

        level = (data, noise, noise_source)
        return compare_robustly(level, rule, fits, settings, store, progress)
    replicates = pure_error(data.x, task.other, data.t, data.sd)
    reference = reference_sigma(noise, fits[orders[-1]], replicates)
    models = {k: LinearModel(factors, k, noise, priors[k], data.symbol) for k in orders}
    posteriors: dict[int, Posterior] = {}
    for k in orders:
        if progress is not None:
            progress(data.axis, k)
        key = Key.of_axis(data.axis, k, settings.noise)
        sample = partial(sample_posterior, models[k], key.rng(settings.seed), settings.ess)
        posteriors[k] = store.posterior(key, models[k], sample)
    chances, evidences = _probabilities(posteriors)
    found = {k: criteria(fits[k], noise, factors.n, factors.log_sd) for k in orders}
    results = tuple(
        OrderResult(
            k,
            fits[k],
            _rss_px2(data, fits[k]),
            goodness_of_fit(fits[k], fits[orders[-1]], reference),
            found[k],
            posteriors[k],
            chances[k] if chances is not None else None,
        )
        for k in orders
    )
    verdict = judge(chances, evidences, found, caveats(results, noise))
    plain = AxisComparison(
        data,
        noise,
        noise_source,
        rule,
        reference,
        pure_error(data.x, None, data.t),
        results,
        verdict,
    )
    if not settings.defend:
        return plain
    if progress is not None:
        progress(data.axis, 0)
    return _defended(plain, models, task, store, settings)


def _defended(
    plain: AxisComparison,
    models: dict[int, LinearModel],
    task: _Task,
    store: Store,
    settings: Settings,
) -> AxisComparison:
    """Add the answers to a referee; a plain comparison does not pay for importing them."""
    from bayescal.comparison.adequacy.block import adequacy
    from bayescal.comparison.adequacy.outcome import concerns
    from bayescal.comparison.defence.argument import argue
    from bayescal.comparison.defence.defence import defend
    from bayescal.comparison.defence.noise_evidence import about_noise, with_noises
    from bayescal.comparison.defence.world_units import world_units

    data, verdict, chosen = plain.data, plain.verdict, plain.chosen
    rng = Key.of_axis(data.axis, 0, settings.noise).rng(settings.seed)
    posteriors = {r.order: r.posterior for r in plain.orders if isinstance(r.posterior, Posterior)}
    defence = defend(
        data,
        models,
        posteriors,
        plain.prior,
        verdict.order,
        verdict.plausible,
        task.groups,
        rng,
        partial(store.wins, data.axis),
    )
    draws = chosen.posterior.chain.draws
    tests = adequacy(
        data,
        chosen.fit,
        plain.noise,
        task.other,
        None if task.camera is None else task.camera[:, 2],
        task.group_names,
        draws.reshape(-1, draws.shape[2]),
        rng,
    )
    defence = with_noises(plain, defence, store, settings)
    argued = argue(verdict, defence, {r.order: r.criteria for r in plain.orders}, data.size)
    argued = about_noise(argued, plain, defence)
    argued = replace(argued, caveats=(*argued.caveats, *concerns(tests)))
    camera = task.camera if data.x_sd is None else None  # stated errors need no such hint
    units = () if camera is None else world_units(data, chosen.fit, camera)
    return replace(plain, verdict=argued, defence=defence, adequacy=tests, world_units=units)


def _probabilities(
    posteriors: dict[int, Posterior],
) -> tuple[dict[int, float] | None, dict[int, float] | None]:
    """Probability and log evidence by order; None where the prior has no evidence."""
    evidences = {}
    for k, posterior in posteriors.items():
        value = posterior.log_evidence
        if value is None:
            return None, None
        evidences[k] = value
    return dict(zip(evidences, probabilities(list(evidences.values())), strict=True)), evidences


def _rss_px2(data: AxisData, fit: LeastSquaresFit) -> float:
    if data.sd is None:
        return fit.rss
    return float(np.sum(residuals(data, fit) ** 2))


def residuals(data: AxisData, fit: LeastSquaresFit) -> Array:
    """Measured less predicted pixels at the maximum-likelihood coefficients.

    Parameters
    ----------
    data : AxisData
    fit : LeastSquaresFit

    Returns
    -------
    Array
        ``(n_points,)``, px.
    """
    return data.t - data.design(fit.order) @ fit.amplitudes
