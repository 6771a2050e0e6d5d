"""Robust noise through the whole program: comparison, document, run, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import bayescal as bc
from bayescal.cli import main
from bayescal.errors import InputError
from bayescal.report.document.comparison import comparison_document
from bayescal.report.document.shared import schema
from bayescal.report.terminal import render
from bayescal.report.views.comparison import brief


@pytest.fixture(scope="module")
def defended():
    return bc.compare(bc.thesis(), [1, 2], axis="c", noise="student-t", ess=400, defend=True)


def test_what_has_no_meaning_is_none_and_what_has_is_there(defended):
    axis = defended.axes["c"]
    chosen = axis.chosen
    assert axis.noise_model.name == "student-t"
    assert chosen.exact is None
    assert (chosen.goodness.chi2, chosen.criteria.aic, axis.verdict.bic_order) == (None, None, None)
    assert chosen.criteria.n_parameters == 4  # two coefficients, sigma, nu
    assert chosen.posterior.names == ("beta_0", "beta_1", "sigma", "nu")
    assert sum(r.probability for r in axis.orders) == pytest.approx(1)
    assert defended.sound


def test_its_defence_is_what_exists_without_a_closed_form(defended):
    defence = defended.axes["c"].defence
    assert set(defence.prediction) == {1, 2}
    assert defence.prediction[1].psis.elpd == defence.prediction[1].loo.elpd
    assert (defence.tau, defence.resampled, defence.groups_that_matter) == (None, (), ())
    assert defence.beyond.orders == (3, 4, 5)
    assert [n.key.noise for n in defence.noises] == ["gaussian", "outlier-mixture"]
    # Truth: the closed form of the same order, which the defence of Student-t noise quotes.
    gaussian = bc.compare(bc.thesis(), [1], axis="c", ess=400).axes["c"].orders[0]
    assert defence.noises[0].key.orders == (defended.axes["c"].verdict.order,)
    quoted = defence.noises[0].log_evidence
    assert quoted == pytest.approx(gaussian.log_evidence, abs=1e-9)


def test_its_document_keeps_the_schema_and_says_what_the_noise_is(defended):
    found = json.loads(json.dumps(comparison_document(defended, "x"), allow_nan=False))
    Draft202012Validator(schema("comparison")).validate(found)
    axis = found["axes"]["c"]
    assert axis["noise"]["kind"] == "student-t"
    assert axis["noise"]["nu"] == {"kind": "gamma", "shape": 2.0, "rate": 0.1}
    assert len(axis["points"]) == 57
    order = axis["orders"][0]
    assert order["coefficients"][0]["mle"] is None
    assert order["noise_parameters"]["nu"]["mean"] > 0
    assert order["evidence"]["trusted"] is True
    assert order["sampling"]["agrees_with_exact"] is None


def test_its_tables_fit_100_columns(defended):
    text = render(brief(defended), terminal=False)
    assert max(map(len, text.splitlines())) <= 100
    assert "Student-t, nu ~ Gamma(shape 2, rate 0.1)" in text
    assert "PSIS takes its place" in text


def test_a_run_of_it_reopens_without_sampling(defended, tmp_path, monkeypatch):
    bc.save_run(defended, tmp_path / "run")
    # Nothing may be sampled while it is read.
    monkeypatch.setattr("bayescal.inference.sampled_posterior.adapt", None)
    again = bc.open_run(tmp_path / "run", defend=False)
    one, other = (c.axes["c"].chosen.posterior for c in (defended, again))
    assert np.array_equal(one.chain.draws, other.chain.draws)
    assert np.array_equal(one.full, other.full)
    assert one.estimate == other.estimate


def test_the_same_seed_gives_the_same_draws():
    one, other = (
        bc.compare(bc.thesis(), [1], axis="c", noise="student-t", nu=4, ess=400) for _ in range(2)
    )
    first, second = (c.axes["c"].orders[0].posterior for c in (one, other))
    assert np.array_equal(first.chain.draws, second.chain.draws)
    assert first.estimate == second.estimate


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--nu", "4"], "nu belongs to student-t noise"),
        (["--noise", "student-t", "--nu", "-1"], "nu must be from 0.1"),
        (["--noise", "student-t", "--bad-offset"], "a bad offset belongs to outlier-mixture"),
        (["--noise", "outlier-mixture", "--prior", "flat"], "needs a proper prior"),
    ],
)
def test_options_that_make_no_model_are_refused_in_one_line(options, words, capsys):
    assert main(["compare", *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert words in captured.err
    assert captured.err.count("\n") == 1


def test_noise_needs_a_point_to_spare():
    """As many coefficients as points leave an inferred sigma to its prior alone."""
    x, y = [0.0, 1.0, 2.0], [0.0, 1.0, 5.0]
    with pytest.raises(InputError, match="more points than the 3 coefficients of order 2"):
        bc.compare_polynomials(x, y, [1, 2], noise="student-t")
    known = bc.compare_polynomials(x, y, [2], noise="student-t", sigma=1.0, ess=100).axes["y"][2]
    # Three points for three coefficients leave tails that the weights' warnings speak of.
    assert known.log_evidence < np.log(2 * np.pi) * -1.5  # below the density at no residual at all


def test_a_winner_at_the_edge_is_not_decided_where_nobody_looked_beyond():
    """Truth: order 4 leads 3 by 99.9 % of the two, and 5 to 7 were not compared."""
    verdict = bc.compare(bc.thesis(), [3, 4], axis="r", noise="student-t", ess=400)["r"].verdict
    assert (verdict.order, verdict.plausible, verdict.decided) == (4, (4,), False)
    assert "not decided: higher orders were not compared" in verdict.text
    assert "under this noise only --defend looks beyond it" in verdict.caveats[0]
    inner = bc.compare(bc.thesis(), [1, 2], axis="c", noise="student-t", ess=400)["c"].verdict
    assert "higher orders" not in inner.text
