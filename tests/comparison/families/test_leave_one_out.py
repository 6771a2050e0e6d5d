"""Leave-one-out of joint models: by weights, by evidences without a point, else marked."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import bayescal as bc
from bayescal.inference.arviz_bridge import psis_loo
from bayescal.prior.camera import position_prior
from bayescal.report.terminal import render
from bayescal.report.views.families.views import brief


@cache
def fitted(family, orders):
    return bc.fit_family(bc.thesis(), family, orders, position="free", ess=400).best


@pytest.mark.parametrize("which", ["middling", "heavy"])
@pytest.mark.parametrize(("family", "orders"), [("pinhole", (0,)), ("separable", (4, 1))])
def test_leave_one_out_is_that_of_fits_without_the_point(family, orders, which):
    """PSIS of a middling point, and the refit of one whose weights fail, are the evidences'."""
    points, model = bc.thesis(), fitted(family, orders)
    assert model.loo.reliable, "what weights can't say, refits do"
    middling = int(np.argsort(model.loo.pointwise)[len(points) // 2])
    # Among the refitted the least expected: one at the edge would take the basis's domain along.
    worst = min(model.loo.refitted, key=lambda i: model.loo.pointwise[i])
    point = middling if which == "middling" else worst
    assert (point in model.loo.refitted) == (which == "heavy")
    keep = np.arange(len(points)) != point
    rest = replace(
        points,
        world=points.world[keep],
        pixels=points.pixels[keep],
        labels=tuple(label for i, label in enumerate(points.labels) if keep[i]),
        lines=None,
    )
    sd = tuple(position_prior(points).sd.tolist())
    known = replace(points.setup.camera, position_sd=sd)
    rest = replace(rest, setup=replace(rest.setup, camera=known))
    without = bc.fit_family(rest, family, orders, position="free", ess=400)
    # p(t_i | rest) = p(all) / p(rest), from evidences with errors of their own.
    expected = model.log_evidence - without.best.log_evidence
    error = np.hypot(model.log_evidence_error, without.best.log_evidence_error)
    # The centroid, which anchors the coordinates, moves with the point: only they do. A refit's
    # 600 draws leave 0.01 nat.
    assert model.loo.pointwise[point] == pytest.approx(expected, abs=4 * (error + 0.01))


def test_leave_one_out_is_marked_where_its_weights_fail(thesis_families):
    """The pinhole's own is good; with a heavy tail it is marked, and every difference to it."""
    plain = render(brief(thesis_families), terminal=False)
    assert all(m.loo.reliable for m in thesis_families.models)
    assert "? marks" not in plain
    best = thesis_families.best
    heavy = replace(best, loo=replace(best.loo, pareto_k=np.array([0.8]), k_limit=0.7))
    marked = replace(thesis_families, models=(heavy, *thesis_families.models[1:]))
    shown = render(brief(marked), terminal=False)
    assert max(len(line) for line in shown.splitlines()) <= 100
    assert f" {best.loo.elpd:.1f}? " in shown
    assert "? marks an elpd" in shown
    assert all("? (" in line for line in shown.splitlines() if line.startswith("   bivariate"))


def test_with_the_coefficients_integrated_out_weights_of_a_point_are_lighter():
    """Of noise of one width none is heavy; by single likelihoods half a dozen are."""
    points = bc.thesis()
    away = points.camera_frame()
    exact = 1100 * away[:, :2] / away[:, 2:] * [1, -1] + [960, 540]
    noisy = exact + np.random.default_rng(1).normal(0, 2, exact.shape)
    found = bc.fit_family(
        replace(points, pixels=noisy), "bivariate", (2,), position="free", ess=400
    ).best
    assert found.loo.reliable
    posterior = found.posterior
    draws = posterior.full.reshape(-1, posterior.full.shape[2])[::2]
    lighter = psis_loo(posterior.model.log_left_out(draws).T).pareto_k
    plain = psis_loo(posterior.model.log_likelihood(draws).T).pareto_k
    assert lighter.max() < 0.7
    assert (lighter > 0.4).sum() < (plain > 0.4).sum() / 2
