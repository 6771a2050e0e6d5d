"""Every outlet of one analysis says the same headline and the same caveats.

Truth: a pinhole of f 3000 px with k1 = -0.1 and 0.5 px of noise, c from the bottom: no polynomial
of one coordinate describes it, and no point is bad.
"""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.report.figures.comparison.verdict import alt_text
from bayescal.report.figures.subject import Subject
from tests.helpers.command import here

F, K1, SIGMA = 3000.0, -0.1, 0.5
CAMERA = ["--camera-position", "0", "0", "0", "--image-width", "1920", "--image-height", "1080"]
EFFORT = ["--c-from-bottom", "--ess", "400"]
ORDERS = ["--orders", "1-3"]


@pytest.fixture(scope="module")
def points_file(tmp_path_factory) -> Path:
    """Points of that pinhole, turned by 3 degrees about y."""
    rng = np.random.default_rng(4)
    z = rng.uniform(400, 900, 60)
    world = np.column_stack([rng.uniform(-0.3, 0.3, 60) * z, rng.uniform(-0.16, 0.16, 60) * z, z])
    a = np.radians(3)
    turn = np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]])
    seen = world @ turn.T
    slopes = seen[:, :2] / seen[:, 2:]
    bent = slopes * (1 + K1 * (slopes**2).sum(axis=1, keepdims=True))
    pixels = np.array([960, 540]) + F * bent + SIGMA * rng.standard_normal((60, 2))
    pixels[:, 1] = 1080 - pixels[:, 1]
    path = tmp_path_factory.mktemp("voice") / "points.csv"
    rows = [",".join(map(repr, row)) for row in np.column_stack([world, pixels]).tolist()]
    path.write_text("\n".join(["x,y,z,r,c", *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def document(points_file, tmp_path_factory) -> dict:
    """The result document of ``compare``, and the run beside it."""
    folder = tmp_path_factory.mktemp("run")
    command = ["compare", points_file, *CAMERA, *EFFORT, *ORDERS, "--out", folder / "run"]
    done = here(*command, "--json", folder / "result.json")
    assert done.code == 0
    found = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    found["run"], found["printed"] = str(folder / "run"), done.out
    return found


def plain(text: str) -> str:
    """Text without tags, entities and line breaks."""
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", text)).split())


def said(document: dict) -> list[str]:
    """Headlines and caveats of both axes."""
    verdicts = [axis["verdict"] for axis in document["axes"].values()]
    return [text for v in verdicts for text in (v["text"], *v["caveats"])]


def test_the_other_model_comes_first_and_nothing_is_decided(document):
    for axis in document["axes"].values():
        verdict = axis["verdict"]
        assert verdict["caveats"][0].startswith("pinhole of order")
        assert verdict["findings"][0]["severity"] == "wrong_model"
        assert (verdict["outcome"], verdict["decided"]) == ("best compared", False)
        assert "another model is very strongly better" in verdict["text"]
        assert "decided at 95%" not in verdict["text"]


def test_the_terminal_says_it_all(document):
    shown = plain(document["printed"])
    assert [text for text in said(document) if plain(text) not in shown] == []


def test_the_page_says_it_all(document, tmp_path):
    page = tmp_path / "report.html"
    assert main(["report", document["run"], "--out", str(page)]) == 0
    shown = plain(page.read_text(encoding="utf-8"))
    assert "decided at 95%" not in shown
    headlines = [re.split(r"; not decided|: ", text)[0] for text in said(document)]
    assert [text for text in headlines if plain(text) not in shown] == []


def test_the_picture_does_not_call_decided_what_is_not(document):
    found = bc.open_run(document["run"])
    words = alt_text(Subject(found, None))
    assert "decided at" not in words
    assert words.count("not decided") + words.count("not excluded") == 2


def test_python_and_notebooks_say_it_all(document):
    found = bc.open_run(document["run"])
    for name, axis in document["axes"].items():
        assert axis["verdict"]["text"] in repr(found)
        shown = plain(found.axes[name]._repr_html_())
        assert [t for t in axis["verdict"]["caveats"] if plain(t) not in shown] == []


def test_fit_says_that_another_model_is_better(points_file, capsys):
    assert (
        main(["fit", str(points_file), *CAMERA, *EFFORT, "--order-r", "3", "--order-c", "2"]) == 0
    )
    assert "describes these points decisively better" in plain(capsys.readouterr().out)


def test_talk_of_outliers_begins_with_the_model(points_file, capsys):
    command = ["outliers", str(points_file), *CAMERA, *EFFORT, "--axis", "both", "--orders", "2-3"]
    assert main(command) == 0
    shown = plain(capsys.readouterr().out)
    model = shown.index("describes these points decisively better")
    assert "look at the model first" in shown[:model].lower()
    assert not re.search(r"bad with probability", shown[:model])
    assert shown.index("P(bad)") > model
