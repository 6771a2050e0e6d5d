"""What a referee asks of a verdict: prediction, prior, other points, other orders, other noise.

Without a closed form leave-one-out comes from the draws (PSIS) alone, and so do the removals of
single points; orders beyond the range are sampled. Bootstrap, groups and the evidence over fixed
tau would take thousands of sampled evidences, and the adequacy tests assume Gaussian noise: they
are left out, and `LEFT_OUT` says so.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.criteria.pointwise import gaussian_density
from bayescal.comparison.criteria.psis import Draws, sampled_leave_one_out
from bayescal.comparison.defence.other_noise import other_noises
from bayescal.comparison.defence.parts import closed_forms, group_elpd, models_of, resamples
from bayescal.comparison.defence.prediction import predictions, worth
from bayescal.comparison.defence.results import Defence
from bayescal.comparison.defence.sensitivity import tau_sensitivity
from bayescal.comparison.defence.stability import Removal, removals, without_groups
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.orders.beyond import Beyond, beyond, beyond_of, orders_beyond
from bayescal.comparison.orders.candidates import RobustOrder
from bayescal.comparison.orders.result import OrderResult
from bayescal.comparison.orders.verdict import AxisVerdict
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.linear.closed_form import ExactPosterior
from bayescal.noise.model import NoiseModel
from bayescal.points.correspondences import Correspondences
from bayescal.points.groups import Groups

# Log densities that leave-one-out by draws looks at where it checks the exact one: of many points
# fewer draws are enough, and all would take longer than the rest of a defence.
CHECKED = 4_000_000
# In a store, by axis.
NAME = "{} defence"
LEFT_OUT = (
    "Unavailable without a closed form: exact leave-one-out (PSIS takes its place), bootstrap, "
    "removal of groups, the evidence over fixed tau; the adequacy tests assume Gaussian noise."
)


def defend(
    axis: Axis,
    noise: NoiseModel,
    results: Sequence[OrderResult],
    verdict: AxisVerdict,
    groups: Groups | None,
    store: Store,
    settings: Settings,
    rng: np.random.Generator,
    again: Iterable[Correspondences] | None = None,
) -> Defence:
    """Answer a referee's questions about one axis; `rng` is the bootstrap's.

    Under a flat prior, which recommends no order, only prediction is compared. Where the data are
    a sample, all points are read `again`.
    """
    held = axis.data.whole is None

    def find() -> Defence:
        exact = closed_forms(results)
        if again is not None:
            from bayescal.comparison.defence.second_pass import defend_many

            return defend_many(axis, exact, verdict.order, again, rng)
        if exact:
            return _in_closed_form(axis, results, exact, verdict.order, groups, rng)
        return _from_draws(axis, noise, results, verdict.order, store, settings)

    answers = store.once(NAME.format(axis.data.axis), Defence, find)
    if verdict.order is None:
        return answers
    by_order = {r.order: r for r in results}
    # No spare point tells the shape of the noise, and a sample does not weigh it for all.
    spare = held and by_order[verdict.order].fit.dof > 0
    return replace(
        answers,
        worth=worth(axis.data, by_order, verdict.order, verdict.plausible),
        noises=other_noises(axis, noise, verdict.order, store, settings) if spare else (),
    )


def _in_closed_form(
    axis: Axis,
    results: Sequence[OrderResult],
    exact: Mapping[int, ExactPosterior],
    order: int | None,
    groups: Groups | None,
    rng: np.random.Generator,
) -> Defence:
    data, models = axis.data, models_of(exact)
    integrals = {k: e.log_integral for k, e in exact.items()}
    grouped = None if groups is None else without_groups(data, models, groups.members)
    psis = {r.order: _psis(axis, r, exact[r.order]) for r in results}
    prediction = predictions(data, results, psis, group_elpd(exact, grouped or {}))
    source = None if groups is None else groups.source
    if order is None:
        return Defence(prediction, group_source=source)
    names, sizes = data.labels, [1] * len(data)
    without = {r.order: integrals[r.order] - r.loo.pointwise for r in results if r.loo is not None}
    groups_out: tuple[Removal, ...] = ()
    if groups is not None and grouped is not None:
        counts = groups.members.sum(axis=1).astype(int).tolist()
        groups_out = removals(groups.names, counts, grouped, order)
    return Defence(
        prediction,
        tau_sensitivity(models) if axis.rule.scaled else None,
        source,
        removals(names, sizes, without, order),
        groups_out,
        resamples(data, exact, groups, rng),
        beyond(data, integrals, axis.noise, axis.rule),
    )


def _psis(axis: Axis, result: OrderResult, exact: ExactPosterior) -> LeaveOneOut | None:
    """Leave-one-out from the draws, beside the exact one."""
    posterior = result.posterior
    theta = posterior.chain.theta.reshape(-1, exact.model.dimension)
    draws = Draws(theta, min(p.ess_bulk for p in posterior.parameters))
    return sampled_leave_one_out(draws, gaussian_density(axis.data, exact), numbers=CHECKED)


def _from_draws(
    axis: Axis,
    noise: NoiseModel,
    results: Sequence[OrderResult],
    order: int | None,
    store: Store,
    settings: Settings,
) -> Defence:
    data, found = axis.data, {r.order: r.loo for r in results if r.loo is not None}
    evidence = {r.order: r.log_evidence for r in results if r.log_evidence is not None}
    prediction = predictions(data, results, found, {})
    if order is None:
        return Defence(prediction)
    # Points whose leave-one-out the draws of every order can tell.
    usable = sorted(set(range(len(data))).difference(*(loo.unreliable for loo in found.values())))
    points: tuple[Removal, ...] = ()
    if found:
        without = {k: evidence[k] - loo.pointwise[usable] for k, loo in found.items()}
        points = removals([data.labels[i] for i in usable], [1] * len(usable), without, order)
    further = _beyond(axis, noise, evidence, store, settings)
    return Defence(prediction, points_that_matter=points, beyond=further)


def _beyond(
    axis: Axis, noise: NoiseModel, evidence: dict[int, float], store: Store, settings: Settings
) -> Beyond:
    """Sample up to three orders above the compared range."""
    more, _ = orders_beyond(axis.data, max(evidence), axis.rule)
    posteriors = {
        k: RobustOrder.of(axis, k, noise).posterior(store, settings, beside=True) for k in more
    }
    return beyond_of(evidence | {k: p.log_evidence for k, p in posteriors.items()}, more)
