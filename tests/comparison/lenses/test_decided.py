"""A lens is called decided only where nothing stands against the comparison.

Truth: boards seen by a camera with two strong radial coefficients; none of the lenses compared
has them.
"""

from __future__ import annotations

import html
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.finding import limits
from bayescal.comparison.lenses.judging import judge_lenses
from bayescal.comparison.lenses.results import LensComparison
from bayescal.fleets.record import Record
from bayescal.report.document.lenses import lenses_document
from bayescal.rounding import significant
from tests.helpers import boards
from tests.helpers.command import here

SIGMA = 0.1
WHY = "residuals depend on the place in the image"


def found(n_views: int, **options: object) -> LensComparison:
    world, pixels = boards.pictures(
        np.random.default_rng(1), n_views, k=(-0.3, 0.3, 0, 0, 0), sigma=SIGMA
    )
    width, height = boards.SIZE
    views = bc.Views.from_arrays([world] * n_views, list(pixels), width=width, height=height)
    return bc.calibrate(views, independent=True, ess=100, sigma=SIGMA, **options)


@pytest.fixture(scope="module")
def wrong() -> LensComparison:
    return found(20, lenses=["pinhole", "radial 1"])


def test_lenses_that_lack_the_shape_are_the_best_of_those_compared(wrong: LensComparison) -> None:
    verdict = wrong.verdict
    assert (verdict.plausible, verdict.status, verdict.decided) == (
        ("radial 1",), "best compared", False,
    )  # fmt: skip
    assert WHY in verdict.withheld
    assert "it does not describe the points to within the known sigma" in verdict.withheld
    assert "best of those compared" in verdict.headline
    assert "decided at" not in verdict.text


def test_what_else_is_plausible_is_named_where_it_is_short(wrong: LensComparison) -> None:
    def said(*names: str) -> str:
        chances = tuple(1 / len(names) for _ in names)
        return replace(wrong.verdict, plausible=names, chances=chances).not_excluded

    assert said("a") == ""
    assert said("a", "b") == "lens b not excluded"
    assert said("a", "b", "c") == "lenses b and c not excluded"
    assert said("a", "b", "c", "d") == "lenses b and 2 others not excluded"


def test_every_outlet_says_the_same(wrong: LensComparison, tmp_path: Path) -> None:
    run, page = tmp_path / "run", tmp_path / "page.html"
    bc.save_run(wrong, run)
    done = here("report", run, "--out", page)
    assert done.code == 0
    again = bc.open_run(run)
    assert again.verdict == wrong.verdict
    told = json.loads((run / "result.json").read_text(encoding="utf-8"))["verdict"]
    assert (told["status"], told["decided"]) == ("best compared", False)
    assert told["findings"][0]["severity"] == "overturns"
    outlets = (
        html.unescape(page.read_text(encoding="utf-8")),
        " ".join(done.out.split()),
        html.unescape(wrong._repr_html_()),
        html.unescape(wrong.verdict._repr_html_()),
    )
    for shown in outlets:
        assert wrong.verdict.headline in shown
        assert "decided at 95%" not in shown
    assert f"not decided: {wrong.verdict.withheld[0]}" in outlets[0]  # in large type
    (choice,) = Record.of_lenses(again).choices
    assert choice.outcome == "best compared"


def test_the_right_lens_is_decided_and_limits_withhold_nothing() -> None:
    verdict = found(8, lenses=["radial 1", "radial 2"]).verdict
    assert (verdict.status, verdict.withheld) == ("decided", ())
    assert "decided at 95%" in verdict.headline
    assert verdict.with_findings([limits("x", "few views")]).decided


def test_a_lens_alone_is_not_decided_but_has_its_findings(wrong: LensComparison) -> None:
    alone = replace(wrong.verdict, compared=1)
    assert (alone.status, alone.decided) == ("single", False)
    assert alone.headline.startswith("radial 1 is the only lens compared; ")
    assert lenses_document(replace(wrong, verdict=alone), "x")["verdict"]["decided"] is False


@pytest.mark.parametrize(("most", "status"), [(0.08, "suffices"), (0.2, "undecided")])
def test_lenses_suffice_by_the_uncertainty_of_their_difference(
    wrong: LensComparison, most: float, status: str
) -> None:
    """Truth: the tolerance is 0.1 px, and it is the 95 % quantile that is held against it."""
    best, other = wrong.lenses
    best = replace(best, probability=0.6)
    other = replace(
        other, probability=0.4, inside=0.05, inside_at_most=most, difference_at_most=1.0
    )
    verdict = judge_lenses([best, other], [])
    assert verdict.status == status
    assert f"{significant(most)} px where there are points (95%)" in verdict.headline
    assert "tolerance of 0.1 px" in verdict.headline
    simplest = "pinhole suffices there" in verdict.headline
    assert simplest == ("may differ by 1.0 px (95%)" in verdict.text) == (status == "suffices")
