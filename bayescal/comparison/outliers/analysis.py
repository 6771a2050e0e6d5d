"""From points to their bad ones: the axes one by one, then what holds for both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from threadpoolctl import threadpool_limits

from bayescal.comparison.choosing import needs_sigma
from bayescal.comparison.criteria.information import criteria
from bayescal.comparison.families.hint import Stated, decisively_better
from bayescal.comparison.finding import ordered
from bayescal.comparison.findings.surroundings import another_model
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.outliers.axis import AxisStudy
from bayescal.comparison.outliers.request import OutlierRequest
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.noise.world_errors import WorldErrors
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.polynomials.separable import NAME, axis_data


def find_outliers(
    points: Correspondences,
    request: OutlierRequest,
    settings: Settings,
    tell: Callable[[str], None] = lambda _: None,
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
    data, highest = {name: axis_data(points, name) for name in AXES}, request.orders[-1]
    for name in request.axes:
        data[name].check(highest)
    axes, kept = {}, store or Store()
    with threadpool_limits(1):
        for name in request.axes:
            other = data[PIXEL_AXES[name].other].x
            axis = Axis.of(
                data[name],
                settings,
                family=NAME,
                highest=highest,
                other=other,
                stated=points.setup.priors.get(name),
            )
            if axis.shape.name == WorldErrors.name:
                raise needs_sigma(axis.data, "a look for bad points")
            axes[name] = AxisStudy(points, axis, other, request, settings, kept).found(tell)
    study = OutlierStudy(
        axes,
        points,
        request.rejection.significance,
        settings,
        request.noises,
        derived=kept.derived,
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
