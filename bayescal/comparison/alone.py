"""Single answers to a referee, for whoever shows one alone: a comparison need not hold the rest."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

from threadpoolctl import threadpool_limits

from bayescal.comparison.criteria.leave_one_out import LeaveOneOut, leave_one_out
from bayescal.comparison.criteria.psis import sampled_leave_one_out
from bayescal.comparison.defence.parts import closed_forms, group_elpd, models_of, resamples
from bayescal.comparison.defence.prediction import predictions
from bayescal.comparison.defence.results import Prediction
from bayescal.comparison.defence.stability import Bootstrap, without_groups
from bayescal.comparison.key import Key
from bayescal.comparison.orders.beyond import Beyond, beyond
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.results import Comparison
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.points.groups import Groups, groups_of


@lru_cache(maxsize=2)  # a figure and the words about it
def prediction_of(comparison: Comparison, name: str) -> dict[int, Prediction]:
    """Leave points of an axis out, and groups where there are some; empty where it is undefined."""
    axis = comparison[name]
    if axis.defence is not None:
        return axis.defence.prediction
    if axis.data.whole is not None:  # what is left out is not held
        return {}
    with threadpool_limits(1):
        results = [replace(found, loo=_left_out(found)) for found in axis]
        exact = closed_forms(axis.orders)
        groups = _groups(comparison)
        by_group: dict[int, float | None] = {}
        if groups is not None and exact:
            without = without_groups(axis.data, models_of(exact), groups.members)
            by_group = group_elpd(exact, without)
        return predictions(axis.data, results, {}, by_group)


@lru_cache(maxsize=2)
def stability_of(comparison: Comparison, name: str) -> tuple[tuple[Bootstrap, ...], Beyond | None]:
    """Resample the points and groups of an axis, and look beyond the orders compared.

    Nothing where some order has no closed form, or no evidence.
    """
    axis = comparison[name]
    if axis.defence is not None:
        return axis.defence.resampled, axis.defence.beyond
    exact = closed_forms(axis.orders)
    if len(exact) < len(axis) or axis.verdict.order is None or axis.data.whole is not None:
        return (), None
    rng = Key.of_axis(name, 0, GAUSSIAN.name).rng(comparison.seed)
    with threadpool_limits(1):
        resampled = resamples(axis.data, exact, _groups(comparison), rng)
        integrals = {k: found.log_integral for k, found in exact.items()}
        return resampled, beyond(axis.data, integrals, axis.noise, axis.prior)


def _left_out(found: OrderResult) -> LeaveOneOut | None:
    if found.exact is not None:
        return leave_one_out(found.data, found.exact)
    posterior: Any = found.posterior
    return sampled_leave_one_out(posterior, posterior.model.log_likelihood)


def _groups(comparison: Comparison) -> Groups | None:
    return None if comparison.points is None else groups_of(comparison.points)
