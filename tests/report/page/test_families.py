"""The section of families: the document's numbers, in words, tables and pictures."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

import bayescal as bc
from bayescal.report.page.page import html, page_of
from bayescal.report.typography import typeset
from bayescal.report.views.families.tables import models_table, shortlist
from tests.helpers.command import here
from tests.helpers.page import read


@pytest.fixture(scope="module")
def page(families_run: Path, chromium: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run, as the command writes it, with a PDF beside it."""
    made = tmp_path_factory.mktemp("families") / "page.html"
    done = here("report", families_run, "--out", made, "--pdf", made.with_suffix(".pdf"))
    assert (done.code, done.err) == (0, ""), chromium
    verdict = json.loads((families_run / "result.json").read_text())["verdict"]
    assert verdict["text"] in done.out
    return made


def rows_of(text: str, table: str) -> list[list[float]]:
    """Numbers that the rows of a table are sorted by."""
    part = text[text.index(f'<div class="tabled" id="{table}"') :]
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", part[: part.index("</table>")], re.DOTALL)[1:]
    return [[float(v) for v in re.findall(r'data-value="([^"]*)"', row)] for row in rows]


def test_it_holds_the_numbers_of_the_document(page: Path, families_run: Path) -> None:
    text = page.read_text(encoding="utf-8")
    kept = json.loads((families_run / "result.json").read_text())
    found = read(text)
    assert json.loads(found.scripts["families"]) == kept
    words = "".join(found.words)
    assert typeset(kept["verdict"]["text"]) in words
    for caveat in kept["verdict"]["caveats"]:
        assert typeset(caveat) in words
    for line in (*kept["families"]["priors"], *kept["families"]["noise"].values()):
        assert typeset(line) in words
    models = kept["families"]["models"]
    table = rows_of(text, "families-models")
    assert len(table) == len(models)
    for row, model in zip(table, models, strict=True):
        for key in ("aic", "bic", "log_evidence", "log_evidence_error", "elpd_loo", "probability"):
            assert model[key] in row
    parameters = models[0]["sampling"]["parameters"]
    shown = rows_of(text, "families-pinhole-0-free")
    assert len(shown) == len(parameters)
    for row, p in zip(shown, parameters, strict=True):
        assert row[:2] == [p["mean"], p["sd"]]
    for name in models[0]["sampling"]["weakly_identified"][0]:
        assert f"{name} (" in words


def test_every_figure_is_there_and_described(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for kind in ("models", "vectors", "position", "correlation"):
        figure = text[text.index(f'<figure id="figure-{kind}"') :]
        alt = re.search(r'alt="([^"]*)"', figure)
        assert alt is not None
        assert len(alt[1]) > 60


def test_it_is_a_section_beside_orders(tmp_path: Path) -> None:
    """Under the settings of the run; a separable pair is the sum over the axes of the page."""
    run, made = tmp_path / "run", tmp_path / "page.html"
    bc.save_run(bc.compare(bc.thesis(), [1], tau=0.1, ess=100, hint=False), run)
    done = here("report", run, "--family", "separable", "--out", made)
    assert (done.code, done.err) == (0, "")
    found = read(made.read_text(encoding="utf-8"))
    result, families = (json.loads(found.scripts[name]) for name in ("result", "families"))
    (model,) = families["families"]["models"]
    evidences = [result["axes"][a]["orders"][0]["log_evidence"] for a in "rc"]
    assert model["log_evidence"] == pytest.approx(sum(evidences), abs=1e-9)
    assert families["settings"]["tau"] == result["settings"]["tau"] == 0.1
    headings = [a["id"] for t, a in found.tags if t == "h2"]
    assert headings.index("adequacy") < headings.index("other-models") < headings.index("residuals")
    words = "".join(found.words)
    assert "Beside them, one joint model of r and c was compared on the same pixels" in words
    table = rows_of(made.read_text(encoding="utf-8"), "families-separable-1-1-stated")
    assert [row[:2] for row in table] == [[p["mean"], p["sd"]] for p in model["closed_form"]]


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1024, "dark")])
def test_it_is_accessible_and_fits(browser: Browser, page: Path, width: int, scheme: str) -> None:
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, reduced_motion="reduce"
    )
    seen = context.new_page()
    seen.goto(page.as_uri())
    seen.evaluate("() => document.querySelectorAll('details').forEach(d => d.open = true)")
    assert seen.evaluate("() => document.documentElement.scrollWidth") <= width
    violations = Axe().run(seen).response["violations"]
    context.close()
    assert [v["id"] for v in violations if v["impact"] in ("serious", "critical")] == []


def test_it_prints(page: Path) -> None:
    assert page.with_suffix(".pdf").read_bytes().startswith(b"%PDF")


def test_a_model_fitted_alone_has_no_rivals_on_its_page() -> None:
    """One model has no probability among others, and no picture of them."""
    found = bc.fit_family(bc.thesis(), "bivariate", (1,))
    text = html(page_of(found, "bayescal fit"))
    assert "<h1>A camera model in full</h1>" in text
    assert 'id="figure-models"' not in text
    assert models_table(found, [0]).rows[0][-1].text == ""


def test_tables_of_models_go_on_where_the_first_one_ends() -> None:
    """Truth: 16 models by closed forms; every one once, the most probable alone marked."""
    found = bc.compare_families(bc.thesis(), ["separable"], [1, 2, 3, 4], position=["stated"])
    first = shortlist(found)
    rest = [i for i in range(len(found.models)) if i not in first]
    tables = models_table(found, first), models_table(found, rest)
    shown = [row[1].text for table in tables for row in table.rows]
    assert len(set(shown)) == len(shown) == len(found.models) == 16
    assert [table.marked for table in tables] == [0, None]
    assert 'id="families-rest"' in html(page_of(found, "bayescal compare"))
