"""What a setup says for the title block goes with the result: document, run, page."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import pytest

import bayescal as bc
from bayescal.points.heading import Heading
from bayescal.report.document.shared import schema
from tests.helpers.command import here

SAID = Heading("Gate 4", "left", "A-1", 'Ida "<b>" Öz')


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("heading")
    setup = bc.Setup(width=1920.0, height=1080.0, heading=SAID)
    found = bc.compare(bc.thesis(), [1], axis="c", setup=setup, ess=100, hint=False)
    bc.save_run(found, folder / "run")
    return folder / "run"


def page_of(*words: object) -> tuple[str, dict[str, object]]:
    done = here("report", *words, "--out", "-")
    assert done.code == 0, done.err
    kept = re.search(r'<script type="application/json" id="result">(.*?)</script>', done.out, re.S)
    assert kept is not None
    return done.out, json.loads(kept[1])


def test_the_document_says_it(run: Path):
    document = json.loads((run / "result.json").read_text(encoding="utf-8"))
    assert document["report"] == SAID.facts
    jsonschema.validate(document, schema("comparison"))


def test_the_page_of_a_run_repeats_it(run: Path):
    page, document = page_of(run)
    assert "<h1>Gate 4</h1>" in page
    assert "<dd>Ida &#34;&lt;b&gt;&#34; Öz</dd>" in page
    assert document["report"] == SAID.facts


def test_options_go_before_it_one_by_one(run: Path):
    page, document = page_of(run, "--title", "Gate 5", "--serial", "B-2")
    wanted = Heading("Gate 5", "left", "B-2", SAID.operator)
    assert "<h1>Gate 5</h1>" in page
    assert document["report"] == wanted.facts


@pytest.mark.parametrize("text", ["two\nlines", "x" * 201, "bell\a", "\udcff"])
def test_what_is_no_line_of_text_is_refused_before_any_work(run: Path, text: str):
    done = here("report", run, "--operator", text, "--out", "-")
    assert done == (2, "", done.err)
    assert "operator must be one line" in done.err
