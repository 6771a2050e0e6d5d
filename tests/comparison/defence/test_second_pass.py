"""The defence of many points, from a second pass over them.

Truth: the defence of the same points held at once; for the bootstrap up to the spread of a
thousand resamples.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bayescal.comparison.criteria import leaving
from bayescal.comparison.criteria.leave_one_out import leave_one_out, paired_difference
from bayescal.comparison.defence.second_pass import defend_many
from bayescal.comparison.defence.stability import bootstrap, removals
from bayescal.comparison.orders.axis import Axis
from bayescal.comparison.settings import Settings
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.reduction import Reduction
from bayescal.points.chunks.stored import cut
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import Setup
from bayescal.polynomials import separable
from bayescal.polynomials.axis_data import AxisData

N, SAMPLE, HIGHEST = 2000, 300, 3
SETUP = Setup(width=6000, height=4000)


def points(case: str) -> Correspondences:
    """Points of order 2, hardly to be told from 1, with what the case says."""
    rng = np.random.default_rng(5)
    w, u, z = rng.uniform(-0.6, 0.6, N), rng.uniform(-0.3, 0.3, N), rng.uniform(300, 900, N)
    noise, sd = rng.standard_normal(N), None
    if case == "bad points":
        noise[:30] *= 12
    if case == "points far away":
        w[100:103] = (1.5, -2, 3)
    if case == "deviations":
        sd = rng.uniform(0.3, 3, N)
        noise *= sd
    r = 960 + 1500 * w + 0.75 * w**2 + noise
    world, pixels = np.column_stack([w * z, u * z, z]), np.column_stack([r, 540 + 1500 * u])
    sigma = {} if sd is None else {"sigma_r": sd, "sigma_c": sd}
    return Correspondences.from_arrays(world, pixels, setup=SETUP, **sigma)


def both(case: str, settings: Settings) -> tuple[Axis, Axis, Correspondences]:
    """The axis r of points held at once, and of a sample of them."""
    given = points(case)
    data = separable.axis_data(given, "r")
    reduction = Reduction(HIGHEST + 3)
    for start in range(0, N, 700):
        part = slice(start, start + 700)
        sd = None if data.sd is None else data.sd[part]
        reduction.add(data.x[part], data.t[part], sd)
    some = np.sort(np.random.default_rng(0).permutation(N)[:SAMPLE])
    held = dataclasses.replace(
        data, x=data.x[some], t=data.t[some], sd=None if data.sd is None else data.sd[some],
        labels=[data.labels[i] for i in some],
    )  # fmt: skip

    def axis(found: AxisData) -> Axis:
        return Axis.of(found, settings, family=separable.NAME, highest=HIGHEST)

    return axis(data), axis(held.sampled_from(reduction.whole())), given


CASES = {
    "plain": Settings(tau=0.01),
    "bad points": Settings(tau=0.01),
    "points far away": Settings(tau=0.01),
    "deviations": Settings(),
}


@pytest.mark.parametrize("case", CASES)
def test_leave_one_out_is_that_of_all_points(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    axis, sampled, given = both(case, CASES[case])
    orders = range(1, HIGHEST + 1)
    exact = {k: exact_posterior(axis.linear(k)) for k in orders}
    chosen = max(exact, key=lambda k: exact[k].log_integral)
    chunks = cut_into(given, 700)
    found = defend_many(
        sampled,
        {k: exact_posterior(sampled.linear(k)) for k in orders},
        chosen,
        chunks,
        np.random.default_rng(0),
    )
    monkeypatch.setattr(leaving, "MANY", N + 1)  # every node for every point
    loos = {k: leave_one_out(axis.data, e) for k, e in exact.items()}
    best = max(loos.values(), key=lambda loo: loo.elpd)
    for k, loo in loos.items():
        ours = found.prediction[k]
        difference = paired_difference(loo, best)
        assert ours.loo.elpd == pytest.approx(loo.elpd, rel=1e-10)
        assert ours.loo.se == pytest.approx(loo.se, rel=1e-10)
        assert ours.loo.p_eff == pytest.approx(loo.p_eff, abs=1e-7)
        assert ours.loo.refitted == len(loo.refitted)
        assert (ours.difference, ours.difference_se) == pytest.approx(difference, abs=1e-7)
    without = {k: e.log_integral - loos[k].pointwise for k, e in exact.items()}
    matter = removals(axis.data.labels, [1] * N, without, chosen)
    assert found.further_points == max(len(matter) - 100, 0)
    assert [r.name for r in found.points_that_matter] == [r.name for r in matter[:100]]
    models = {k: e.model for k, e in exact.items()}
    truth = bootstrap(axis.data, models, np.random.default_rng(1)).share
    for k, share in found.resampled[0].share.items():
        spread = np.sqrt(2 * max(truth[k] * (1 - truth[k]), 1 / 1000) / 1000)
        assert share == pytest.approx(truth[k], abs=4 * spread)
    assert 0.05 < max(truth.values()) < 0.999 or case == "points far away"


def cut_into(given: Correspondences, rows: int) -> list[Correspondences]:
    """Chunks of so many points."""
    places = [np.arange(start, min(start + rows, N)) for start in range(0, N, rows)]
    whole = next(cut(given, given.setup))
    return [
        Correspondences(
            whole.world[p],
            whole.pixels[p],
            [whole.labels[i] for i in p],
            None,
            {name: sd[p] for name, sd in whole.sigma.items()},
            whole.setup,
            whole.source,
        )
        for p in places
    ]
