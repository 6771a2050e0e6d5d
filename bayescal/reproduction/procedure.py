"""The thesis's own procedure: its two model variants, orders, and elimination of points."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array, IntArray, frozen
from bayescal.comparison.criteria.information import criteria_from
from bayescal.comparison.outliers.rejection import RejectionRule, point_tests, reject
from bayescal.comparison.settings import DEFAULT_ORDERS, checked_orders
from bayescal.errors import InputError
from bayescal.linear.design_fit import DesignFit, fit_design
from bayescal.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import load
from bayescal.points.setup import AXES
from bayescal.polynomials.separable import axis_data
from bayescal.reproduction.models import VARIANTS, ThesisModel
from bayescal.reproduction.results import (
    AxisReproduction,
    OrderReproduction,
    Reproduction,
    ThesisFit,
)


def reproduce(
    points: Any,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    significance: float = 0.05,
    per_point: bool = False,
    sigma: float | str = "inferred",
    common: bool = False,
) -> Reproduction:
    """Run the thesis's procedure, as written and as coded.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `thesis` or `load`, or anything `load` takes.
    orders : iterable of int, optional
        Polynomial degrees, 1 to 5 by default as in the thesis.
    significance : float, optional
        Level of the elimination of bad points, family-wise.
    per_point : bool, optional
        Take the level for each point by itself instead.
    sigma : float or str, optional
        Noise level: a known number of px, or ``"inferred"``.
    common : bool, optional
        Fit all orders also to the points that every one of them kept.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputError
        Where the points can't determine an order, or a setting is not usable.

    Examples
    --------
    >>> import bayescal as bc
    >>> r = bc.reproduce(bc.thesis())["as-coded"]["r"]
    >>> [round(o.before.rss, 1) for o in r.orders]
    [3074.6, 1571.3, 1524.2, 1522.6, 1461.3]
    """
    if not isinstance(points, Correspondences):
        points = load(points)
    wanted = checked_orders(orders)
    if isinstance(sigma, str) and sigma != "inferred":
        raise InputError(f"sigma must be 'inferred' or a number of px, not {sigma!r}")
    known = None if isinstance(sigma, str) else float(sigma)
    rule = RejectionRule(significance, per_point, known)
    data = {axis: axis_data(points, axis) for axis in AXES}
    for axis in AXES:
        data[axis].check(wanted[-1])
    w, u = data["r"].x, data["c"].x
    # One thread: a sum split over cores rounds differently from machine to machine.
    with threadpool_limits(1):
        variants = {
            variant: {
                axis: _axis(
                    [ThesisModel(variant, axis, k) for k in wanted],
                    w,
                    u,
                    data[axis].t,
                    rule,
                    common,
                )
                for axis in AXES
            }
            for variant in VARIANTS
        }
    found = Reproduction(points, rule, common, variants, ())
    return dataclasses.replace(found, warnings=_warnings(found))


def _axis(
    models: list[ThesisModel], w: Array, u: Array, t: Array, rule: RejectionRule, common: bool
) -> AxisReproduction:
    everything = np.arange(len(t))
    designs = [model.design(w, u) for model in models]
    rejections = [reject(design, t, rule) for design in designs]
    shared = np.ones(len(t), dtype=bool)
    for rejection in rejections:
        shared[list(rejection.removed)] = False
    common_kept = np.flatnonzero(shared)
    common_kept.setflags(write=False)
    orders = []
    for model, design, rejection in zip(models, designs, rejections, strict=True):
        fitted = partial(_thesis_fit, model, design, t, rule)
        on_common = _fit_where_possible(design[common_kept], t[common_kept]) if common else None
        orders.append(
            OrderReproduction(
                model.order,
                fitted(rejection.before, everything),
                point_tests(rejection.before, rule.sigma),
                rejection,
                fitted(rejection.after, rejection.kept),
                None if on_common is None else fitted(on_common, common_kept),
            )
        )
    return AxisReproduction(models[0].variant, models[0].axis, tuple(orders), common_kept)


def _thesis_fit(
    model: ThesisModel,
    design: Array,
    t: Array,
    rule: RejectionRule,
    fit: DesignFit,
    kept: IntArray,
) -> ThesisFit:
    """Judge a fit to some of the points: its criteria, and its residuals of all."""
    noise = NoiseLevel.inferred() if rule.sigma is None else NoiseLevel.known(rule.sigma)
    residuals = t - design @ fit.coefficients
    residuals[kept] = fit.residuals  # of the factorisation itself
    found = criteria_from(fit.rss, fit.n_coefficients, noise, len(fit), exact=fit.exact)
    return ThesisFit(model, kept, fit, frozen(residuals), found)


def _fit_where_possible(design: Array, t: Array) -> DesignFit | None:
    try:
        return fit_design(design, t)
    except InputError:
        return None


def _warnings(found: Reproduction) -> tuple[str, ...]:
    n = len(found.points)
    unused = [f"sigma_{name}" for name in found.points.sigma]
    if found.points.setup.world_sigma is not None:
        unused.append("the setup's world sigma")
    warnings = []
    if unused:
        warnings.append(
            f"{', '.join(unused)}: not used, for the thesis's least squares have no weights"
        )
    for model in found.models:
        shared = len(model.common_kept)
        if not model.same_points and not found.common:
            counts = ", ".join(str(len(o.after.kept)) for o in model.orders)
            warnings.append(
                f"{model.name}: after elimination the orders rest on different points ({counts} "
                f"of {n}) and can't be compared; the option common compares them on the {shared} "
                "that all keep"
            )
        missing = [str(o.order) for o in model.orders if found.common and o.common is None]
        if missing:
            warnings.append(
                f"{model.name}: the points that all orders keep, {shared}, do not determine order "
                f"{', '.join(missing)}"
            )
    return tuple(warnings)
