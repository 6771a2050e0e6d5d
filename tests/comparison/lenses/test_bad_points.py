"""Lenses weighed where points may be bad: as if the bad ones had never been, and said everywhere.

Truth: the same views without the points that were moved, which far gross errors equal up to the
price of being bad; a lens that is too simple; runs that are reopened.
"""

from __future__ import annotations

import html
import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.calibration.judging.bad_points import log_prior
from bayescal.calibration.judging.laplace import Level
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import LensComparison
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.report.document.shared import schema
from bayescal.report.figures.lenses import vectors
from bayescal.report.figures.lenses import views as panels
from bayescal.report.terminal import render
from bayescal.report.views.lenses.views import brief, residuals_section, verdict_section
from tests.helpers import boards
from tests.helpers.command import here

MOVED = {(3, 20): (6.0, -8.0), (3, 21): (25.0, 3.0), (1, 7): (-3.0, 2.0)}
NAMES = ("4:21", "4:22", "2:8")
LENSES = ["radial 2", "radial 1", "pinhole"]
N = 6 * 54
PRICE = -math.log(boards.SIZE[0] * boards.SIZE[1])


def seen(k: tuple[float, ...] = (-0.3, 0.3, 0, 0, 0), sigma: float = 0.1) -> bc.Views:
    world, pixels = boards.pictures(np.random.default_rng(4), 6, k, sigma=sigma)
    width, height = boards.SIZE
    return bc.Views.from_arrays([world] * 6, list(pixels), width=width, height=height)


def moved(views: bc.Views, shifts: dict[tuple[int, int], tuple[float, float]]) -> bc.Views:
    pixels = [views.pixels[part].copy() for part in views.slices]
    for (view, place), shift in shifts.items():
        pixels[view][place] += shift
    width, height = boards.SIZE
    world = [views.world[part] for part in views.slices]
    return bc.Views.from_arrays(world, pixels, width=width, height=height)


def judged(views: bc.Views, **options: object) -> LensComparison:
    known = {
        "lenses": LENSES,
        "independent": True,
        "ess": 100,
        "noise": "outlier-mixture",
        **options,
    }
    return bc.calibrate(views, **known)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def mixed() -> LensComparison:
    return judged(moved(seen(), MOVED))


@pytest.mark.parametrize("options", [{}, {"sigma": 0.1}, {"sigma": "per-view"}])
def test_far_gross_errors_leave_the_evidence_of_the_other_points(
    options: dict[str, object],
) -> None:
    """Truth: views without them; each costs the image's area, all of them log B(1 + k, 1 + n - k).

    Views have one level in truth: their own differ by what levels of fewer points do.
    """
    views = moved(seen(), MOVED)
    found, clean = (
        judged(views, **options),
        judged(views.without(*NAMES), noise="gaussian", **options),
    )
    assert found.bad is not None
    assert {p.name for p in found.bad.left_out} == set(NAMES)
    price = float(log_prior(N, 3)) + 3 * PRICE
    for ours in found.lenses:
        theirs = clean[ours.name]
        assert ours.mixed is not None
        assert ours.rms == pytest.approx(theirs.rms, rel=1e-6)
        if ours.mixed.common and abs(ours.mixed.sets.log_share - price) < 0.01:
            assert ours.log_evidence == pytest.approx(theirs.log_evidence + price, abs=0.05)
        else:  # a lens too simple, which has further points bad
            assert ours.log_evidence > theirs.log_evidence + price
            assert ours.log_evidence < found.best.log_evidence - 10
    best = clean["radial 2"]
    assert found.best.log_evidence == pytest.approx(best.log_evidence + price, abs=0.05)
    assert found.verdict.best == clean.verdict.best == "radial 2"
    assert found.verdict.status == clean.verdict.status


def test_no_gross_errors_change_no_probability_and_name_no_point() -> None:
    """Truth: Gaussian noise on the same clean views; the chance of no bad point is 1 / (n + 1)."""
    views = seen((-0.02, 0, 0, 0, 0))  # radial 2 is not excluded
    found, plain = judged(views), judged(views, noise="gaussian")
    assert found.bad is not None
    assert found.bad.points == ()
    assert found.bad.fraction == pytest.approx(1 / (N + 2), rel=0.02)
    assert found.gross == plain.gross == ()
    assert plain.bad is None
    assert plain["radial 2"].probability > 0.01
    for ours in found.lenses[:2]:
        theirs = plain[ours.name]
        assert ours.log_evidence == pytest.approx(theirs.log_evidence - math.log(N + 1), abs=0.01)
        assert ours.probability == pytest.approx(theirs.probability, abs=1e-3)
    assert "No point of 324 is taken for bad." in found.verdict.text


def test_a_lens_too_simple_does_not_win_by_calling_points_bad() -> None:
    """Truth: strong distortion, which the pinhole could explain only by bad points, at their price.

    Its own set is better for it than none: what is compared is the best that it can do.
    """
    views = seen((-0.3, 0.9, 0, 0, 0))
    found, plain = judged(views), judged(views, noise="gaussian")
    simple = found["radial 1"]
    assert simple.mixed is not None
    assert simple.mixed.sets.log_share < -10
    assert not simple.mixed.common
    assert simple.log_evidence > plain["radial 1"].log_evidence + float(log_prior(N, 0))
    assert found.verdict.best == "radial 2"
    assert simple.log_evidence < found["radial 2"].log_evidence - 10
    assert found.bad is not None
    assert found.bad.points == ()


@pytest.mark.parametrize(("independent", "within"), [(True, 0.02), (False, 0.1)])
def test_a_point_in_doubt_is_summed_over_from_either_set(independent: bool, within: float) -> None:
    """Truth: two evidences by draws, with the point and without, each with the other's set added.

    Error models are averaged for the one set, and not anew for the sets about it.
    """
    place = 3 * 54 + 20
    views = moved(seen(), {(3, 20): (0.87, 0.0)})  # as likely bad as good, about
    request = LensRequest(lenses=("radial 2",), independent=independent, noise="outlier-mixture")
    without, among = (
        next(iter(Sweep(views, request, Level(None), bad=bad))).judge(Store(), Settings())
        for bad in ((place,), ())
    )
    assert without.mixed is not None
    assert among.mixed is not None
    assert among.evidence.log_evidence < without.evidence.log_evidence - 10
    assert among.log_evidence == pytest.approx(without.log_evidence, abs=within)
    chances = [one.mixed.sets.chance[3, 20] for one in (without, among)]
    assert 0.02 < chances[0] < 0.98
    assert chances[1] == pytest.approx(chances[0], abs=within)


def test_two_corners_taken_for_each_other_are_found(mixed: LensComparison) -> None:
    pixels = mixed.views.pixels
    start = mixed.views.slices[2].start
    gap = tuple(pixels[start + 30] - pixels[start + 3])
    swapped = moved(seen(), {(2, 3): gap, (2, 30): (-gap[0], -gap[1])})
    found = judged(swapped)
    assert found.bad is not None
    assert {p.name for p in found.bad.left_out} == {"3:4", "3:31"}
    assert found.verdict.best == "radial 2"


def test_every_outlet_names_the_points(mixed: LensComparison, tmp_path: Path) -> None:
    run = tmp_path / "run"
    bc.save_run(mixed, run)
    again = bc.open_run(run)
    assert (again.verdict, again.bad) == (mixed.verdict, mixed.bad)
    assert [j.log_evidence for j in again.lenses] == [j.log_evidence for j in mixed.lenses]
    told = json.loads((run / "result.json").read_text(encoding="utf-8"))
    jsonschema.validate(told, schema("lenses"))
    assert told["settings"]["noise"] == told["noise"]["kind"] == "outlier-mixture"
    assert 0 < told["noise"]["bad_fraction"] < 0.05
    assert {f"{p['view']}:{p['point']}" for p in told["bad_points"] if p["left_out"]} == set(NAMES)
    assert all(p["probability"] > 0.99 for p in told["bad_points"])
    far = next(p for p in told["bad_points"] if p["point"] == "22")
    assert far["shift_px"] == pytest.approx(MOVED[3, 21], abs=5 * 0.1 * 1.5)
    sentence = "3 of 324 points are taken for bad and left out, the farthest 4:22, off by 25 px."
    outlets = (
        render(brief(mixed), terminal=False),
        render(verdict_section(mixed).blocks, terminal=False),  # of the page
        html.unescape(mixed._repr_html_()),
    )
    for shown in outlets:
        assert sentence in " ".join(shown.split())
    for shown in outlets[:2]:
        assert "uniform on 0 to 1" in " ".join(shown.split())
    page = render(residuals_section(mixed).blocks, terminal=False)
    for shown in (outlets[0], page, outlets[2]):
        for name in NAMES:
            assert name in shown.replace(sentence, "")


def test_points_taken_for_bad_are_crossed_where_they_were_measured(mixed: LensComparison) -> None:
    rows = [mixed.views.slices[view].start + place for view, place in MOVED]
    (crosses,) = vectors.draw(mixed).axes[0].lines
    drawn = np.array(crosses.get_xydata())
    assert sorted(map(tuple, drawn)) == sorted(map(tuple, mixed.views.pixels[rows]))
    assert vectors.alt_text(mixed).startswith("Residuals of 321 points")
    assert vectors.alt_text(mixed).endswith("Crosses: 3 points taken for bad.")
    first = panels.draw(mixed).axes[3].lines
    assert [len(line.get_xydata()) for line in first] == [2]


def test_an_interruption_changes_nothing(mixed: LensComparison, tmp_path: Path) -> None:
    """Truth: the same without a break; what was kept is not computed again."""
    first = judged(mixed.views, resume=tmp_path / "kept")
    again = judged(mixed.views, resume=tmp_path / "kept")
    for found in (first, again):
        assert found.verdict == mixed.verdict
        assert [j.log_evidence for j in found.lenses] == [j.log_evidence for j in mixed.lenses]


def test_a_view_that_can_spare_no_point_keeps_it_and_nothing_is_decided() -> None:
    """Truth: of a view of four points, one was moved by 10 px."""
    views = seen()
    corners = [f"3:{k}" for k in range(1, 55) if k not in (1, 9, 46, 54)]
    found = judged(moved(views, {(2, 0): (6.0, 8.0)}).without(*corners))
    assert found.bad is not None
    assert found.bad.left_out == ()
    (point,) = found.gross
    assert point.view == "3"
    (finding,) = [f for f in found.verdict.findings if f.kind == "gross-errors"]
    assert finding.withholds
    assert finding.text.endswith("--without 3")
    assert "not taken for bad" in finding.text


def test_many_bad_points_are_a_caveat() -> None:
    rng = np.random.default_rng(1)
    places = [divmod(int(k), 54) for k in rng.choice(N, 33, replace=False)]
    found = judged(moved(seen(), {at: tuple(rng.uniform(5, 30, 2)) for at in places}))
    assert found.bad is not None
    assert len(found.bad.left_out) == 33
    (finding,) = [f for f in found.verdict.findings if f.kind == "bad-points"]
    assert finding.text.startswith("10% of the points are taken for bad")
    assert not finding.withholds
    assert found.verdict.best == "radial 2"


def test_other_noise_is_refused_with_what_to_take() -> None:
    for given in ("student-t", "mixture"):
        with pytest.raises(bc.InputError, match="mixture"):
            bc.calibrate(seen(), noise=given)
        refused = here("calibrate", "--noise", given)
        assert refused.code == 2
        assert "mixture" in refused.err
        assert len(refused.err.strip().splitlines()) == 1
