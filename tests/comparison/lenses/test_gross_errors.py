"""One corner that was taken for another: found, named, said by every outlet, and left out.

Truth: the same views without that corner, and the size of the error that was made.
"""

from __future__ import annotations

import html
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.calibration.judging.laplace import Level
from bayescal.comparison.lenses.caveats.gross import points_off
from bayescal.comparison.lenses.gross_errors import LEVEL, gross_errors, search
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import LensComparison
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.report.terminal import render
from bayescal.report.views.lenses.views import brief
from tests.helpers import boards
from tests.helpers.command import here

OFF = np.array([6.0, -8.0])
VIEW, PLACE, N = 3, 20, 54
WHY = "a point is further off than the errors allow"


def seen(moved: dict[tuple[int, int], np.ndarray]) -> bc.Views:
    world, pixels = boards.pictures(np.random.default_rng(4), 6, (-0.2, 0, 0, 0, 0))
    for at, shift in moved.items():
        pixels[at] += shift
    width, height = boards.SIZE
    return bc.Views.from_arrays([world] * 6, list(pixels), width=width, height=height)


def judged(views: bc.Views) -> LensComparison:
    return bc.calibrate(views, lenses=["radial 1", "pinhole"], independent=True, ess=100)


@pytest.fixture(scope="module")
def wrong() -> LensComparison:
    return judged(seen({(VIEW, PLACE): OFF}))


def test_the_corner_is_named_with_its_size_and_nothing_is_decided(wrong: LensComparison) -> None:
    (point,) = wrong.gross
    assert (point.view, point.label, point.name) == ("4", "21", "4:21")
    assert point.point == VIEW * N + PLACE
    assert point.size == pytest.approx(np.hypot(*OFF), abs=5 * 0.2)  # five deviations of the noise
    assert point.p_value < LEVEL
    assert WHY in wrong.verdict.withheld
    assert wrong.verdict.status == "best compared"


def test_every_outlet_says_so(wrong: LensComparison, tmp_path: Path) -> None:
    run, page = tmp_path / "run", tmp_path / "page.html"
    bc.save_run(wrong, run)
    assert here("report", run, "--out", page).code == 0
    again = bc.open_run(run)
    assert (again.verdict, again.gross) == (wrong.verdict, wrong.gross)
    (finding,) = [f for f in wrong.verdict.findings if f.kind == "gross-errors"]
    assert finding.text.endswith(
        "--without 4:21; or weigh that points may be bad: --noise outlier-mixture"
    )
    told = json.loads((run / "result.json").read_text(encoding="utf-8"))
    assert finding.text in [f["text"] for f in told["verdict"]["findings"]]
    (point,) = told["gross_errors"]
    assert (point["view"], point["point"], point["line"]) == ("4", "21", None)
    outlets = (
        html.unescape(page.read_text(encoding="utf-8")),
        render(brief(wrong), terminal=False),
        html.unescape(wrong._repr_html_()),
    )
    for shown in outlets:
        assert finding.text in " ".join(shown.split())
    for shown in outlets[:2]:  # a row of the table
        assert "4:21" in shown.replace(finding.text, "")


def test_left_out_it_is_as_if_it_had_never_been(wrong: LensComparison) -> None:
    """Truth: the same views with the corner where it is, left out too."""
    name = wrong.gross[0].name
    mended, good = (judged(v.without(name)) for v in (wrong.views, seen({})))
    assert mended.gross == ()
    assert mended.verdict.status == "decided"
    for ours, theirs in zip(mended.lenses, good.lenses, strict=True):
        assert ours.log_evidence == pytest.approx(theirs.log_evidence, abs=1e-6)


def test_each_is_found_beside_others_that_are_larger(wrong: LensComparison) -> None:
    """Truth: the six corners that were moved, by 2 px (ten deviations) and more."""
    moved = {(VIEW, PLACE): OFF, **{(1, k): OFF * (k + 3) / 30 for k in (3, 9, 17, 30, 52)}}
    pixels = wrong.problem.data.pixels.copy()
    for at, shift in list(moved.items())[1:]:
        pixels[at] += shift
    problem = replace(wrong.problem, data=replace(wrong.problem.data, pixels=pixels))
    sizes = {(p.view, p.place): np.hypot(*p.shift) for p in search(problem)}
    assert sizes.keys() == moved.keys()
    for at, shift in moved.items():
        assert sizes[at] == pytest.approx(np.hypot(*shift), abs=5 * 0.2)


def test_many_are_counted_and_views_most_of_whose_points_are_off_are_named(
    wrong: LensComparison,
) -> None:
    (one,) = wrong.gross
    whole = [replace(one, view="6", label=str(k)) for k in range(1, 31)]
    more = [replace(one, view="2", label=str(k)) for k in range(1, 5)]
    found = points_off(replace(wrong, gross=(*whole, *more)))
    assert found is not None
    assert found.text == (
        "34 of 324 points are further from where all the others put them than the errors allow "
        "(p < 0.01 over all points): view 6 (30 of its 54 points); view 2 point 1 by 10 px; "
        "view 2 point 2 by 10 px and 2 more; look at the photographs, correct them or leave them "
        "out: --without 6"
    )


def test_what_gross_errors_spoil_is_chosen_again_without_them() -> None:
    """Truth: two corners changed places; residuals that a lens lacks are no gross errors."""
    world, pixels = boards.pictures(np.random.default_rng(6), 8, (-0.3, 0.3, 0, 0, 0), sigma=0.1)
    pixels[2, [3, 30]] = pixels[2, [30, 3]]
    width, height = boards.SIZE
    views = bc.Views.from_arrays([world] * 8, list(pixels), width=width, height=height)
    request = LensRequest(lenses=("radial 1", "radial 2"), independent=True, draws=100)
    sweep = Sweep(views, request, Level(None))
    lenses = [candidate.judge(Store(), Settings()) for candidate in sweep]  # the poorer one first
    assert len(search(lenses[0].evidence.problem)) > 2
    found = gross_errors(lenses, sweep.setting, views)
    assert {g.name for g in found} == {"3:4", "3:31"}
