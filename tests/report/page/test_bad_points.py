"""The section of bad points: the study's numbers, in words, tables and a picture."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

import bayescal as bc
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.report.document.outliers import outliers_document
from bayescal.report.figures.registry import KINDS
from bayescal.report.page.page import html, page_of
from tests.helpers.command import here


@pytest.fixture(scope="module")
def study() -> OutlierStudy:
    """The thesis's c, whose worst points are known."""
    return bc.outliers(bc.thesis(), [1, 2], axis="c", ess=300)


@pytest.fixture(scope="module")
def made(study: OutlierStudy) -> str:
    """A page with a section of bad points."""
    comparison = bc.compare(bc.thesis(), [1, 2], axis="c", ess=200, hint=False)
    return html(page_of(comparison, "bayescal report", study))


def test_it_is_there_only_where_it_was_asked_for(made: str):
    comparison = bc.compare(bc.thesis(), [1], axis="c", ess=200, hint=False)
    assert 'id="bad-points"' in made
    assert 'id="bad-points"' not in html(page_of(comparison, ""))


def test_every_point_stands_with_its_probability(made: str, study: OutlierStudy):
    axis = study.axes["c"]
    table = made[made.index('<div class="tabled" id="all-points-c"') :]
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", table[: table.index("</table>")], re.DOTALL)[1:]
    assert len(rows) == 57
    for row, point in zip(rows, axis.points, strict=True):
        values = [float(v) for v in re.findall(r'data-value="([^"]*)"', row)]
        assert values[0] == point.index
        assert values[2] == point.residual
        assert values[7] == point.off
    assert values[8] == point.bad_probability


def test_points_that_err_together_and_the_verdict_are_told(made: str):
    assert "Points 16 and 19 share" in made
    assert "wins however bad points are treated" in made
    # Those of c that the thesis names, the gravest first, under the large type.
    assert re.search(r"<strong>\d+ suspicious points</strong> <span>16, 19, ", made)
    assert "log-uniform from" in made  # the prior of the width, px


def test_each_treatment_has_its_row(made: str, study: OutlierStudy):
    table = made[made.index('<div class="tabled" id="treatments-c"') :]
    table = table[: table.index("</table>")]
    for treatment in study.axes["c"].treatments:
        for value in treatment.log_evidence.values():
            assert f'data-value="{value}"' in table
        found = treatment
        assert f'data-value="{found.probability[found.order]}"' in table


def test_the_document_is_kept_whole(made: str, study: OutlierStudy):
    kept = re.search(r'<script type="application/json" id="outliers">(.*?)</script>', made, re.S)
    assert kept is not None
    found, expected = json.loads(kept[1]), outliers_document(study, "")
    assert found["axes"] == json.loads(json.dumps(expected["axes"]))


def test_the_figure_names_the_bad_points(study: OutlierStudy):
    words = KINDS["bad-points"].alt_text(study, "c")
    assert "16 (+14.5 px, >99.9%)" in words
    figure = KINDS["bad-points"].draw(study, "c")
    named = {text.get_text() for text in figure.axes[0].texts}
    assert named == {p.label for p in study.axes["c"].bad}
    above, below = figure.axes
    heights = {
        int(x): y
        for line in below.lines[:-1]
        for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)
    }
    assert heights == {p.index + 1: p.bad_probability for p in study.axes["c"].points}
    assert "px" in above.get_ylabel()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1024])
def test_it_is_accessible_and_fits(
    browser: Browser, made: str, tmp_path: Path, width: int, scheme: str
):
    path = tmp_path / "page.html"
    path.write_text(made, encoding="utf-8")
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, reduced_motion="reduce"
    )
    page = context.new_page()
    page.goto(path.as_uri())
    page.evaluate("() => document.querySelectorAll('details').forEach(d => d.open = true)")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
    violations = Axe().run(page).response["violations"]
    context.close()
    assert [v["id"] for v in violations if v["impact"] in ("serious", "critical")] == []


def test_a_flat_prior_is_refused_before_any_work(tmp_path: Path):
    done = here("report", "--outliers", "--prior", "flat", "--out", tmp_path / "a.html")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "flat prior" in done.err
    assert list(tmp_path.iterdir()) == []
