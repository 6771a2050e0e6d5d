"""What a referee asks of a verdict: prediction, prior, other points, other orders."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.comparison.defence.sensitivity import TauSensitivity, tau_sensitivity
from bayescal.comparison.defence.stability import (
    Beyond,
    Bootstrap,
    Removal,
    beyond,
    bootstrap,
    removals,
    without_groups,
)
from bayescal.comparison.leave_one_out import LeaveOneOut, leave_one_out, paired_difference
from bayescal.comparison.psis import good_k, thinned
from bayescal.inference.arviz_bridge import PsisLoo, psis_loo
from bayescal.inference.posterior import Posterior
from bayescal.linear.evidence import LOG_2PI
from bayescal.linear.model import LinearModel
from bayescal.points.groups import Groups
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design
from bayescal.prior.amplitudes import PriorRule

if TYPE_CHECKING:
    from bayescal.comparison.defence.noise_evidence import NoiseEvidence


@dataclass(frozen=True, eq=False)
class Prediction:
    """Leave-one-out of one order, exact and from the draws.

    Attributes
    ----------
    loo : LeaveOneOut
        Exact.
    difference, difference_se : float
        elpd less the best order's, and its paired standard error.
    group_elpd : float or None
        Sum of ln p(group | all other points); None where there are no groups.
    psis_elpd : float or None
        The sum from the draws (Pareto-smoothed importance sampling); None where the
        data are too many for it, or a weight's tail has no shape.
    psis_mcse : float or None
        Its Monte Carlo standard error.
    pareto_k : Array or None
        ``(n_points,)``.
    k_limit : float or None
        Good below it: min(1 - 1 / log10 of the number of draws, 0.7) (Vehtari et al.
        2024).
    influential : tuple of str
        Labels of the points beyond it, worst first.
    """

    loo: LeaveOneOut
    difference: float
    difference_se: float
    group_elpd: float | None
    psis_elpd: float | None
    psis_mcse: float | None
    pareto_k: Array | None = None
    k_limit: float | None = None
    influential: tuple[str, ...] = ()


@dataclass(frozen=True)
class Worth:
    """How far another order's prediction is from the recommended one's.

    Attributes
    ----------
    order : int
    largest : float
        Largest difference over the domain, px.
    sd : float
        Posterior sd of the larger order's prediction there, px.
    at : float
        Regressor where it is.
    """

    order: int
    largest: float
    sd: float
    at: float


@dataclass(frozen=True, eq=False)
class Defence:
    """Answers to a referee, on one axis.

    Attributes
    ----------
    prediction : dict of int to Prediction
        By order; empty where leave-one-out does not exist.
    tau : TauSensitivity or None
        None where the prior has no tau.
    group_source : str or None
        What makes a group: ``"column group"`` or ``"plane z"``.
    points_that_matter, groups_that_matter : tuple of Removal
        Whose removal changes the winner.
    resampled : tuple of Bootstrap
        By point and, where there are groups, by group.
    beyond : Beyond or None
    worth : tuple of Worth
        Of every other plausible order.
    noises : tuple of NoiseEvidence
        Evidence of the recommended order under the other noise models.
    """

    prediction: dict[int, Prediction]
    tau: TauSensitivity | None
    group_source: str | None
    points_that_matter: tuple[Removal, ...]
    groups_that_matter: tuple[Removal, ...]
    resampled: tuple[Bootstrap, ...]
    beyond: Beyond | None
    worth: tuple[Worth, ...]
    noises: tuple[NoiseEvidence, ...] = ()


def defend(
    data: AxisData,
    models: Mapping[int, LinearModel],
    posteriors: Mapping[int, Posterior],
    rule: PriorRule,
    order: int | None,
    plausible: tuple[int, ...],
    groups: Groups | None,
    rng: np.random.Generator,
    wins: Callable[[str], Mapping[int, float] | None] = lambda _: None,
) -> Defence:
    """Answer a referee's questions about one axis.

    Parameters
    ----------
    data : AxisData
    models, posteriors : mapping of int
        By order.
    rule : PriorRule
    order : int or None
        The recommended order; None under a flat prior, where only prediction is
        compared.
    plausible : tuple of int
    groups : Groups or None
    rng : numpy.random.Generator
        For the bootstrap.
    wins : callable, optional
        From ``"point"`` or ``"group"`` to the bootstrap's shares, where an earlier run of
        the same found them.

    Returns
    -------
    Defence
    """
    integrals = {k: p.exact.log_integral for k, p in posteriors.items()}
    left_out = {k: leave_one_out(data, p.exact) for k, p in posteriors.items()}
    loos = {k: loo for k, loo in left_out.items() if loo is not None}
    members = groups.members if groups is not None else None
    grouped = without_groups(data, models, members) if members is not None else None
    prediction = _predictions(data, posteriors, loos, integrals, grouped)
    if order is None:
        return Defence(prediction, None, groups.source if groups else None, (), (), (), None, ())
    points = removals(
        data.labels,
        [1] * len(data),
        {k: integrals[k] - loo.pointwise for k, loo in loos.items()},
        order,
    )
    groups_out: tuple[Removal, ...] = ()
    resampled = [bootstrap(data, models, rng, known=wins("point"))]
    if groups is not None and grouped is not None:
        sizes = groups.members.sum(axis=1).astype(int).tolist()
        groups_out = removals(groups.names, sizes, grouped, order)
        resampled.append(bootstrap(data, models, rng, groups.members, known=wins("group")))
    scaled = rule.name == "field"
    return Defence(
        prediction,
        tau_sensitivity(models) if scaled else None,
        groups.source if groups is not None else None,
        points,
        groups_out,
        tuple(resampled),
        beyond(data, integrals, models[order].noise, rule),
        tuple(_worth(data, posteriors, order, k) for k in plausible if k != order),
    )


def _predictions(
    data: AxisData,
    posteriors: Mapping[int, Posterior],
    loos: Mapping[int, LeaveOneOut],
    integrals: Mapping[int, float],
    grouped: Mapping[int, Array] | None,
) -> dict[int, Prediction]:
    if not loos:
        return {}
    best = max(loos, key=lambda k: loos[k].elpd)
    out = {}
    for k, loo in loos.items():
        difference, se = paired_difference(loo, loos[best])
        group = (
            None
            if grouped is None or np.isnan(grouped[k]).any()
            else float((integrals[k] - grouped[k]).sum())
        )
        psis = _psis(data, posteriors[k])
        if psis is None:
            out[k] = Prediction(loo, difference, se, group, None, None)
            continue
        sound = bool(np.isfinite(psis.pointwise).all() and np.isfinite(psis.mcse).all())
        limit = good_k(psis.influence.shape[1])
        shape = np.where(np.isfinite(psis.pareto_k), psis.pareto_k, np.inf)
        worst = [int(i) for i in np.argsort(-shape, kind="stable") if shape[i] >= limit]
        out[k] = Prediction(
            loo,
            difference,
            se,
            group,
            float(psis.pointwise.sum()) if sound else None,
            psis.mcse_of_sum if sound else None,
            frozen(shape),
            limit,
            tuple(data.labels[i] for i in worst),
        )
    return out


def _psis(data: AxisData, posterior: Posterior) -> PsisLoo | None:
    """Leave-one-out from the draws; None where they'd be too few."""
    model = posterior.exact.model
    theta = thinned(posterior.chain.theta.reshape(-1, model.dimension), len(data))
    if theta is None:
        return None
    design = legendre_design(data.domain.scale(data.x), model.order)
    sd = data.sd if data.sd is not None else np.ones(len(data))
    if model.infers_sigma:
        log_sigma = theta[:, model.size]
    else:
        log_sigma = np.full(len(theta), np.log(posterior.exact.sigma[0]))
    z = (data.t[:, None] - design @ theta[:, : model.size].T) / sd[:, None] * np.exp(-log_sigma)
    log_likelihood = -(z**2 + LOG_2PI) / 2 - log_sigma - np.log(sd)[:, None]
    return psis_loo(log_likelihood)


def _worth(data: AxisData, posteriors: Mapping[int, Posterior], order: int, other: int) -> Worth:
    s = np.linspace(-1, 1, 401)
    means = {}
    for k in (order, other):
        exact = posteriors[k].exact
        means[k] = legendre_design(s, k) @ exact.mean
    difference = np.abs(means[other] - means[order])
    place = int(difference.argmax())
    larger = max(order, other)
    row = legendre_design(s[place : place + 1], larger)[0]
    sd = float(np.linalg.norm(row @ posteriors[larger].exact.root))
    at = data.domain.middle + data.domain.half_range * float(s[place])
    return Worth(other, float(difference[place]), sd, at)
