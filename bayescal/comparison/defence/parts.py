"""What answers to a referee share: closed forms of orders, resamples, groups left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.defence.stability import Bootstrap, bootstrap
from bayescal.comparison.orders.result import OrderResult
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.model import LinearModel
from bayescal.points.groups import Groups
from bayescal.polynomials.axis_data import AxisData


def closed_forms(results: Sequence[OrderResult]) -> dict[int, ExactPosterior]:
    """Give closed forms of the orders that have one."""
    return {found.order: found.exact for found in results if found.exact is not None}


def group_elpd(
    exact: Mapping[int, ExactPosterior], without: Mapping[int, Array]
) -> dict[int, float | None]:
    """Sum the log densities of groups left out, by order; None where one can't be left out."""
    found = {k: exact[k].log_integral - left for k, left in without.items()}
    return {k: None if np.isnan(terms).any() else float(terms.sum()) for k, terms in found.items()}


def resamples(
    data: AxisData,
    exact: Mapping[int, ExactPosterior],
    groups: Groups | None,
    rng: np.random.Generator,
) -> tuple[Bootstrap, ...]:
    """Resample points and, where there are some, groups."""
    models = models_of(exact)
    found = [bootstrap(data, models, rng)]
    if groups is not None:
        found.append(bootstrap(data, models, rng, groups.members))
    return tuple(found)


def models_of(exact: Mapping[int, ExactPosterior]) -> dict[int, LinearModel]:
    """Likelihoods and priors of orders."""
    return {k: found.model for k, found in exact.items()}
