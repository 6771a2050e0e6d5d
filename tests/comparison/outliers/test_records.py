"""Bad points: each number against its definition, errors that points share, the thesis's own."""

from __future__ import annotations

import json

import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.api.outliers import outliers
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.outliers.records import (
    RobustView,
    cooks_distance,
    eliminate,
    point_records,
)
from bayescal.comparison.outliers.rejection import RejectionRule
from bayescal.comparison.outliers.shared_errors import shared_errors
from bayescal.linear.design_fit import fit_design
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.document.outliers import outliers_document
from bayescal.report.document.shared import schema
from bayescal.report.terminal import render
from bayescal.report.views.outliers.views import brief


@pytest.fixture(scope="module")
def study():
    """The thesis's c, orders 1 and 2: its worst points are known."""
    return outliers(bc.thesis(), [1, 2], axis="c")


def test_cooks_distance_is_how_far_the_predictions_move_without_the_point():
    """Truth: the fit repeated without each point (Cook 1977)."""
    rng = np.random.default_rng(1)
    design = np.column_stack([np.ones(15), rng.normal(size=15), rng.normal(size=15)])
    t = design @ [3.0, 2.0, -1.0] + rng.normal(size=15)
    fit = fit_design(design, t)
    s2 = fit.rss / fit.dof
    for i in range(15):
        left = np.arange(15) != i
        moved = design @ (fit_design(design[left], t[left]).coefficients - fit.coefficients)
        assert cooks_distance(fit)[i] == pytest.approx(moved @ moved / (3 * s2), rel=1e-10)


def test_a_point_that_alone_fixes_a_coefficient_has_no_distance():
    design = np.column_stack([np.ones(5), [0, 0, 0, 0, 1.0]])
    found = cooks_distance(fit_design(design, np.array([1.0, 2.0, 3.0, 2.0, 9.0])))
    assert np.isnan(found[4])
    assert np.isfinite(found[:4]).all()


def test_what_a_point_does_to_the_order_is_the_comparison_without_it(study):
    """Truth: the evidences of the other 56 points, domain and prior those of all."""
    axis = study.axes["c"]
    rule = PriorRule("field", axis.data.size, axis.data.size / 2)
    for point in axis.points[:4]:
        left_out = np.zeros((1, 57))
        left_out[0, point.index] = 1
        sets = Rows.of(axis.data, 2).without(left_out)
        values = {
            k: log_evidences(sets.reduced(k), axis.level, rule.of_order(k), FINE)[0] for k in (1, 2)
        }
        # The quadrature's nodes serve leave-one-out too, to about 1e-5 nat.
        assert point.log_bayes_factor_without == pytest.approx(values[1] - values[2], abs=1e-4)
        assert point.order_without == max(values, key=values.get)


def test_the_thesiss_worst_points_are_found_and_named_as_one_wrong_world_value(study):
    axis = study.axes["c"]
    assert {"16", "19"} <= {p.label for p in axis.bad}
    assert {"16", "19"} <= {p.label for p in axis.suspicious}
    for label in ("16", "19"):
        (point,) = (p for p in axis.points if p.label == label)
        assert point.bad_probability > 0.99
        assert point.weight < 0.1
        assert point.rejected_at == (1, 2)
    (together,) = (s for s in axis.shared if s.together)
    assert set(together.points) == {"16", "19"}
    assert together.coordinates == {"y": 0.0, "z": 600.0}
    assert abs(together.error) == pytest.approx(15, abs=3)
    assert any("points 16 and 19 share y = 0, z = 600" in line for line in axis.explanations)
    assert {t.order for t in axis.treatments} == {1}
    assert "Gaussian noise is the wrong assumption" in axis.verdict


def test_good_points_are_most_of_them(study):
    assert len(study.axes["c"].bad) < 10
    assert len(study.axes["c"].points) == 57


def _records(data, off, bad):
    n = len(data)
    elimination = eliminate(data, [1], RejectionRule())
    view = RobustView(data.t - off, np.full(n, 0.3), np.where(bad, 0.99, 0.01), np.ones(n))
    loo = {1: LeaveOneOut(np.full(n, -2.0), 2.0)}
    return point_records(data, elimination, 1, loo, {1: -100.0}, view)


def test_errors_are_shared_only_by_points_that_err_alike():
    """Truth: points made so; 0 and 1 share y and z, 2 and 3 too, 4 stands beside a good one."""
    world = np.array([[0, 1, 9], [5, 1, 9], [0, 2, 9], [5, 2, 9], [0, 3, 9], [5, 3, 9], [1, 4, 9]])
    world = world.astype(float)
    points = bc.Correspondences.from_arrays(world, np.column_stack([world[:, 0], world[:, 1]]))
    data = axis_data(points, "c")
    off = np.array([8.0, 8.4, 8.0, -8.0, 8.0, 0.0, 0.0])
    bad = np.array([True, True, True, True, True, False, False])
    records = _records(data, off, bad)
    slope, sigma = np.full(7, 2.0), np.full(7, 0.5)
    found = {s.points: s for s in shared_errors(data, records, world, slope, sigma)}
    alike, apart, alone = (found[key] for key in (("1", "2"), ("3", "4"), ("5",)))
    assert alike.together
    assert alike.coordinates == {"y": 1.0, "z": 9.0}
    assert alike.error == pytest.approx(8.2)
    assert alike.explained_by == pytest.approx(4.1)  # 8.2 px at 2 px per unit
    assert not apart.together
    assert not alone.together
    assert alone.good == ("6",)


def test_the_document_says_what_the_study_found_and_holds_no_nan(study):
    found = json.loads(json.dumps(outliers_document(study, "bayescal outliers"), allow_nan=False))
    jsonschema.validate(found, schema("outliers"))
    axis = found["axes"]["c"]
    assert [p["label"] for p in axis["points"]] == [p.label for p in study.axes["c"].points]
    assert len(axis["treatments"]) == 4
    assert axis["verdict"] == study.axes["c"].verdict
    for t in axis["treatments"]:
        assert sum(t["probability"].values()) == pytest.approx(1)


def test_what_is_printed_fits_100_columns_and_names_the_bad_points(study):
    text = render(brief(study), terminal=False)
    assert max(map(len, text.splitlines())) <= 100
    assert "Points 16 and 19 share y = 0, z = 600" in text
    whole = render(brief(study, everything=True), terminal=False)
    assert len(whole.splitlines()) > len(text.splitlines()) + 40


def test_a_flat_prior_is_refused():
    with pytest.raises(bc.InputError, match="flat prior"):
        outliers(bc.thesis(), prior="flat")


def test_one_order_alone_has_no_rival():
    """Nothing is infinite: the document is JSON, and the table leaves the column empty."""
    alone = outliers(bc.thesis(), [1], axis="c")
    assert {p.log_bayes_factor_without for p in alone.axes["c"].points} == {None}
    document = json.loads(json.dumps(outliers_document(alone, "x"), allow_nan=False))
    jsonschema.validate(document, schema("outliers"))
    assert "+inf" not in render(brief(alone), terminal=False)
