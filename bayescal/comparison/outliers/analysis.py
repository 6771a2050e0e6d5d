"""From points to their bad ones: orders times ways of treating bad points, and records of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.comparison.adequacy.block import adequacy
from bayescal.comparison.adequacy.normality import NAME as NORMALITY
from bayescal.comparison.choosing import needs_sigma
from bayescal.comparison.criteria.information import criteria
from bayescal.comparison.families.hint import Stated, decisively_better
from bayescal.comparison.finding import ordered
from bayescal.comparison.findings.misfit import concerning
from bayescal.comparison.findings.surroundings import another_model
from bayescal.comparison.judged import Judged, with_probabilities
from bayescal.comparison.judging import judge_all
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.candidates import GaussianOrder, RobustOrder
from bayescal.comparison.outliers.records import (
    Elimination,
    RobustView,
    eliminate,
    point_records,
)
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy
from bayescal.comparison.outliers.shared_errors import shared_errors
from bayescal.comparison.outliers.treatments import Treatment
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.noise.world_errors import WorldErrors
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.rows import ALL
from bayescal.polynomials.separable import NAME, axis_data


def find_outliers(
    points: Correspondences,
    names: Sequence[str],
    orders: tuple[int, ...],
    settings: Settings,
    noises: tuple[StudentT, OutlierMixture],
    rejection: RejectionRule,
    tell: Callable[[str], None],
    store: Store | None = None,
) -> OutlierStudy:
    """Study the bad points of each axis wanted.

    `tell` is called with the axis before each noise model is sampled; by default all are sampled
    now.

    Raises
    ------
    InputError
        Where the points can't determine an order.
    """
    data = {name: axis_data(points, name) for name in AXES}
    for name in names:
        data[name].check(orders[-1])
    axes, kept = {}, store or Store()
    with threadpool_limits(1):
        for name in names:
            axis = Axis.of(
                data[name],
                settings,
                family=NAME,
                highest=orders[-1],
                other=data[PIXEL_AXES[name].other].x,
                stated=points.setup.priors.get(name),
            )
            if axis.shape.name == WorldErrors.name:
                raise needs_sigma(axis.data, "a look for bad points")
            axes[name] = _axis(points, axis, orders, noises, rejection, settings, tell, kept)
    study = OutlierStudy(
        axes, points, rejection.significance, settings, noises, derived=kept.derived
    )
    return _with_hint(study, settings, kept)


def _with_hint(study: OutlierStudy, settings: Settings, store: Store) -> OutlierStudy:
    """Say on both axes where another model is decisively better than their curves."""
    if set(study.axes) != set(AXES):
        return study
    found = [study.axes[name] for name in AXES]
    orders = tuple(axis.treatments[0].order for axis in found)
    r, c = (
        Axis(a.data, a.level, a.noise_source, a.prior, NAME, max(a.treatments[0].log_evidence))
        for a in found
    )
    bics = [
        criteria(a.fit(k), a.noise, len(a.data), a.factors.log_sd).bic
        for a, k in zip((r, c), orders, strict=True)
    ]
    if None in bics:
        return study
    evidence = sum(a.treatments[0].log_evidence[k] for a, k in zip(found, orders, strict=True))
    stated = Stated((orders[0], orders[1]), evidence, sum(b or 0.0 for b in bics))
    find = partial(decisively_better, study.points, (r, c), stated, settings)
    hint = store.once("another model", str | None, find)
    if hint is None:
        return study
    axes = {
        name: replace(axis, findings=ordered((*axis.findings, another_model(hint))))
        for name, axis in study.axes.items()
    }
    return replace(study, axes=axes)


def _axis(
    points: Correspondences,
    axis: Axis,
    orders: tuple[int, ...],
    noises: tuple[StudentT, OutlierMixture],
    rejection: RejectionRule,
    settings: Settings,
    tell: Callable[[str], None],
    store: Store,
) -> AxisOutliers:
    axis.check_resolved()
    data, level = axis.data, axis.noise
    plain = [GaussianOrder(axis, k, GAUSSIAN) for k in orders]
    elimination = eliminate(
        data, orders, RejectionRule(rejection.significance, sigma=level.plug_in)
    )
    gaussian = Treatment(
        "Gaussian noise", len(data), with_probabilities([c.beside(store, settings) for c in plain])
    )
    removed = len(elimination.highest.removed)
    without = Treatment(
        f"Gaussian noise without {removed} eliminated"
        if removed
        else "Gaussian noise, nothing eliminated",
        len(data) - removed,
        _without(axis, orders, elimination),
    )
    robust = {noise.name: {k: RobustOrder.of(axis, k, noise) for k in orders} for noise in noises}
    sampled = []
    named = "Student-t noise", "the outlier mixture"
    for found, words in zip(robust.values(), named, strict=True):
        tell(data.axis)
        sampled.append(Treatment(words, len(data), judge_all(found.values(), store, settings)))
    order = max((gaussian, *sampled), key=lambda t: t.total).order
    heavy, mixture = (found[order] for found in robust.values())
    posterior = mixture.posterior(store, settings)
    find = partial(_robust_view, heavy, heavy.posterior(store, settings), mixture, posterior)
    view = store.once(f"{data.axis} robust view", RobustView, find)
    loo = {c.order: left for c in plain if (left := c.left_out(store)) is not None}
    records = point_records(data, elimination, order, loo, gaussian.log_evidence, view)
    scale = level.value or posterior[level.parameter].mean
    own = data.deviations
    slope = _slope(data, posterior, order) / points.camera_frame()[:, 2]
    shared = shared_errors(data, records, points.world, slope, scale * own)
    treatments = gaussian, without, *sampled
    other = axis_data(points, PIXEL_AXES[data.axis].other).x
    depth = points.camera_frame()[:, 2]
    rng = Key.of_axis(data.axis, 0, GAUSSIAN.name).rng(settings.seed, 1)
    fit = axis.fit(gaussian.order)
    tests = adequacy(data, fit, level, other, depth, points.groups, rng=rng)
    # Bad points alone make the noise look as if it were not normal.
    curve = [test for test in tests if test.name != NORMALITY]
    return AxisOutliers(
        data,
        level,
        axis.rule,
        axis.source,
        order,
        records,
        elimination,
        treatments,
        shared,
        ordered(concerning(curve)),
    )


def _without(axis: Axis, orders: Sequence[int], elimination: Elimination) -> tuple[Judged, ...]:
    """Evidence of the points that the highest order keeps; domain and prior stay."""
    members = np.zeros((1, len(axis.data)))
    members[0, list(elimination.highest.removed)] = 1
    sets = Rows.of(axis.data, orders[-1]).without(members)
    values = {k: log_evidences(sets.reduced(k), axis.noise, axis.prior(k), FINE) for k in orders}
    return with_probabilities(
        [
            Judged(
                key=Key.of_axis(axis.data.axis, k, GAUSSIAN.name),
                log_evidence=float(value[0]),
                log_evidence_error=0.0,
            )
            for k, value in values.items()
        ]
    )


def _robust_view(
    heavy: RobustOrder, heavy_draws: SampledPosterior, mixture: RobustOrder, draws: SampledPosterior
) -> RobustView:
    """Say what Student-t noise and the mixture say of every point."""
    full, model = draws.completed, mixture.model
    amplitudes = full[:, : model.size]
    covariance = np.atleast_2d(np.cov(amplitudes, rowvar=False))
    design = model.design[ALL]
    variance = ((design @ covariance) * design).sum(axis=1)
    bad = model.bad_probability(full)
    assert bad is not None, "the mixture knows bad points"
    return RobustView(
        design @ amplitudes.mean(axis=0),
        np.sqrt(variance),
        bad,
        heavy.model.weight(heavy_draws.completed),
    )


def _slope(data: AxisData, posterior: SampledPosterior, order: int) -> Array:
    """Slope of the mean prediction over the regressor at every point, px, ``(n_points,)``."""
    theta = posterior.chain.theta
    amplitudes = theta.reshape(-1, theta.shape[2])[:, : order + 1].mean(axis=0)
    derivative = np.polynomial.legendre.legder(amplitudes) / data.domain.half_range
    return np.asarray(np.polynomial.legendre.legval(data.domain.scale(data.x), derivative))
