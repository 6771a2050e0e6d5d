"""Whether a comparison of orders should have been one of families: the line that says so."""

from __future__ import annotations

import contextlib
import itertools
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp
from threadpoolctl import threadpool_limits

from bayescal.comparison.criteria.information import criteria
from bayescal.comparison.families.models import (
    fitted_pinhole,
    free_model,
    gaussian_pinhole,
    joint_criteria,
    joint_data,
)
from bayescal.comparison.key import FREE, STATED
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.results import Comparison
from bayescal.comparison.settings import Settings
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.proposal import ladder
from bayescal.density.position_search import position_mode
from bayescal.errors import InputError
from bayescal.linear.closed_form import exact_posterior
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES

# Points that no such model can be fitted to: a comparison of orders goes on without the line.
NO_MODEL = (InputError, np.linalg.LinAlgError, ValueError)
# 2 ln B worth a line in a comparison of orders: very strong (Kass & Raftery 1995).
DECISIVE = 10.0


def family_hint(points: Correspondences, result: Comparison, settings: Settings) -> str | None:
    """Say in one line whether another family, or a free position, is decisively better."""
    axes = result.axes
    if set(axes) != set(AXES) or settings.noise != "gaussian":
        return None
    chosen = [axes[name].chosen for name in AXES]
    if any(c.log_evidence is None or c.criteria.bic is None for c in chosen):
        return None
    r, c = (
        Axis(a.data.alone, a.noise, a.noise_source, a.prior, result.family, a.orders[-1].order)
        for a in (axes[name] for name in AXES)
    )
    orders = chosen[0].order, chosen[1].order
    stated = Stated(
        orders,
        sum(c.log_evidence or 0.0 for c in chosen),
        sum(c.criteria.bic or 0.0 for c in chosen),
    )
    if points.drawn_from is not None:
        stated = _of_sample((r, c), orders)
    return decisively_better(points, (r, c), stated, settings)


@dataclass(frozen=True)
class Stated:
    """The recommended orders at the stated position: log evidence and BIC of both axes."""

    orders: tuple[int, int]
    log_evidence: float
    bic: float


def _of_sample(axes: tuple[Axis, Axis], orders: tuple[int, int]) -> Stated:
    """Evidence and BIC of the recommended orders on a sample, as its rivals have them."""
    evidence, bic = 0.0, 0.0
    for axis, order in zip(axes, orders, strict=True):
        evidence += exact_posterior(axis.linear(order)).log_integral
        found = criteria(axis.fit(order), axis.noise, axis.factors.n, axis.factors.log_sd)
        bic += found.bic or 0.0
    return Stated(orders, evidence, bic)


def decisively_better(
    points: Correspondences, axes: tuple[Axis, Axis], stated: Stated, settings: Settings
) -> str | None:
    """Say in one line which model is decisively better than the orders at the stated position.

    The pinhole of orders 0 and 1, at a free and at the stated position, and the pair of orders
    at a free position, by Laplace approximations of the evidence. None where 2 ln B is below
    10, or where no such model can be fitted.
    """
    with threadpool_limits(1), np.errstate(all="ignore"):
        found = _rivals(points, axes, stated, settings)
    if not found:
        return None
    best = max(found, key=lambda rival: rival.log_evidence)
    gain = 2 * (best.log_evidence - stated.log_evidence)
    if gain < DECISIVE:
        return None
    changed = ""
    if best.bic is not None:
        less = stated.bic - best.bic
        changed = f", BIC {'lower' if less > 0 else 'higher'} by {abs(less):.0f}"
    where = "at the stated camera position"
    if best.position is not None:
        x, y, z = best.position
        where = f"with a free camera position (near {x:.4g}, {y:.4g}, {z:.4g})"
    return (
        f"{best.name} {where} describes these points decisively better: 2 ln B about {gain:.0f} "
        f"(Laplace){changed}; see compare --family separable,pinhole --position stated,free"
    )


@dataclass(frozen=True)
class _Rival:
    """A model that might beat the recommended orders at the stated position."""

    log_evidence: float
    bic: float | None  # None of an exact fit
    name: str
    position: tuple[float, ...] | None  # None where it is the stated one


def _rivals(
    points: Correspondences, axes: tuple[Axis, Axis], stated: Stated, settings: Settings
) -> list[_Rival]:
    """Fit the models of the hint that may be decisively better, as far as the points allow."""
    k, m = stated.orders
    needed = stated.log_evidence + DECISIVE / 2
    data, out = joint_data(axes), []
    with contextlib.suppress(*NO_MODEL):
        model, rss = free_model(points, axes, (k, m))
        bic = joint_criteria(data, rss, k + m + 5 + sum(data.inferred)).bic
        mass = position_mode(model).log_mass
        out.append(_Rival(mass, bic, f"separable ({k}, {m})", tuple(model.start.tolist())))
    for where, order in itertools.product((FREE, STATED), (0, 1)):
        # Points of one plane leave a free position open, not the stated one.
        with contextlib.suppress(*NO_MODEL):
            out += _pinhole(points, order, where, data, settings, needed)
    return out


def _pinhole(
    points: Correspondences,
    order: int,
    where: str,
    data: JointData,
    settings: Settings,
    needed: float,
) -> list[_Rival]:
    """Fit a pinhole, and weigh it by its Laplace approximation; none where it can't be enough.

    No evidence, an average of the likelihood, exceeds the likelihood's maximum.
    """
    fitted = fitted_pinhole(points, order, where, "even", data, settings)
    if fitted.fit.log_likelihood < needed:
        return []
    model = gaussian_pinhole(fitted)
    mass = float(logsumexp(ladder(model)[1]))
    count = model.geometry.dimension + sum(data.inferred)
    bic = joint_criteria(data, model.fit.rss, count).bic
    position = None
    if where == FREE:
        at = model.geometry.position(model.geometry.full(model.fit.free[None]))[0]
        position = tuple(at.tolist())
    return [_Rival(mass, bic, f"pinhole of order {order}", position)]
