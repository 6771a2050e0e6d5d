"""The defence of a verdict under robust noise: what exists of it without a closed form.

Leave-one-out comes from the draws (PSIS) alone, and so do the removals of single points;
orders beyond the range are sampled. Bootstrap, groups and the evidence over fixed tau would
take thousands of sampled evidences, and the adequacy tests assume Gaussian noise: they are
left out, and `LEFT_OUT` says so.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bayescal.arrays import Array
from bayescal.comparison.defence.defence import Defence, Prediction, Worth
from bayescal.comparison.defence.noise_evidence import noise_evidence
from bayescal.comparison.defence.stability import Beyond, beyond_of, orders_beyond, removals
from bayescal.comparison.leave_one_out import LeaveOneOut, paired_difference
from bayescal.comparison.psis import sampled_leave_one_out
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design

PREDICTED = 2000  # draws that predictions are compared by

LEFT_OUT = (
    "Not to be had without a closed form: exact leave-one-out (PSIS takes its place), bootstrap, "
    "removal of groups, the evidence over fixed tau; the adequacy tests assume Gaussian noise."
)


def defend_robustly(axis: AxisComparison, store: Store, settings: Settings) -> Defence:
    """Answer a referee's questions about an axis whose posteriors are sampled.

    Parameters
    ----------
    axis : AxisComparison
        With a recommended order.
    store : Store
        Of the draws, those of the orders beyond the range too.
    settings : Settings

    Returns
    -------
    Defence
    """
    posteriors = sampled(axis)
    verdict, data = axis.verdict, axis.data
    assert verdict.order is not None, "a proper prior recommends an order"
    evidence = {k: p.log_evidence for k, p in posteriors.items()}
    prediction = _predictions(data, posteriors)
    usable = _usable(data, prediction)
    points = removals(
        [data.labels[i] for i in usable],
        [1] * len(usable),
        {k: evidence[k] - found.loo.pointwise[usable] for k, found in prediction.items()},
        verdict.order,
    )
    return Defence(
        prediction,
        None,
        None,
        points if prediction else (),
        (),
        (),
        _beyond(axis, evidence, store, settings),
        tuple(
            _worth(data, posteriors, verdict.order, k)
            for k in verdict.plausible
            if k != verdict.order
        ),
    )


def sampled(axis: AxisComparison) -> dict[int, SampledPosterior]:
    """Posteriors of an axis by order, where they were sampled."""
    return {r.order: r.posterior for r in axis.orders if isinstance(r.posterior, SampledPosterior)}


def _predictions(
    data: AxisData, posteriors: Mapping[int, SampledPosterior]
) -> dict[int, Prediction]:
    found = {}
    for k, posterior in posteriors.items():
        psis = sampled_leave_one_out(posterior)
        if psis is not None:
            found[k] = psis
    if not found:
        return {}
    best = max(found, key=lambda k: found[k].elpd)
    out = {}
    for k, psis in found.items():
        difference, se = paired_difference(psis, found[best])
        out[k] = Prediction(
            LeaveOneOut(psis.pointwise, psis.elpd, psis.se, psis.p_eff, 0),
            difference,
            se,
            None,
            psis.elpd,
            psis.mcse,
            psis.pareto_k,
            psis.k_limit,
            tuple(data.labels[i] for i in psis.unreliable),
        )
    return out


def _usable(data: AxisData, prediction: Mapping[int, Prediction]) -> list[int]:
    """Points whose leave-one-out the draws of every order can tell."""
    good = np.ones(len(data), dtype=bool)
    for found in prediction.values():
        assert found.pareto_k is not None, "PSIS gives it"
        assert found.k_limit is not None, "PSIS gives it"
        good &= found.pareto_k < found.k_limit
    return [int(i) for i in np.flatnonzero(good)]


def _beyond(
    axis: AxisComparison, evidence: Mapping[int, float], store: Store, settings: Settings
) -> Beyond:
    """Sample up to three orders above the compared range."""
    more, _ = orders_beyond(axis.data, max(evidence), axis.prior)
    everything = dict(evidence)
    if more:
        found = noise_evidence(
            axis.data, axis.noise, axis.prior, axis.noise_model, more, settings, store
        )
        everything |= found.log_evidence
    return beyond_of(everything, more)


def _worth(
    data: AxisData, posteriors: Mapping[int, SampledPosterior], order: int, other: int
) -> Worth:
    s = np.linspace(-1, 1, 401)
    predicted = {k: _predicted(posteriors[k], k, s) for k in (order, other)}
    difference = np.abs(predicted[other].mean(axis=0) - predicted[order].mean(axis=0))
    place = int(difference.argmax())
    sd = float(predicted[max(order, other)][:, place].std(ddof=1))
    at = data.domain.middle + data.domain.half_range * float(s[place])
    return Worth(other, float(difference[place]), sd, at)


def _predicted(posterior: SampledPosterior, order: int, s: Array) -> Array:
    """Prediction of some draws over the domain, ``(n_draws, n_places)``, px."""
    theta = posterior.chain.theta
    amplitudes = theta[..., : order + 1].reshape(-1, order + 1)
    thinned = amplitudes[:: max(1, len(amplitudes) // PREDICTED)]
    return np.asarray(thinned @ legendre_design(s, order).T)
