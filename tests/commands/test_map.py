"""``bayescal map`` and its figures as a user meets them."""

from __future__ import annotations

import csv
import io
import json

import jsonschema
import pytest

import bayescal as bc
from bayescal.report.document.shared import schema
from tests.helpers.cases import not_a_number
from tests.helpers.command import here


@pytest.fixture(scope="module")
def file(thesis_comparison, tmp_path_factory):
    """The camera of the thesis's points."""
    place = tmp_path_factory.mktemp("map") / "camera.npz"
    bc.keep_camera(bc.camera(thesis_comparison), place)
    return place


def test_the_map_in_numbers(file):
    done = here("map", file, "--grid", "9", "7")
    assert done.code == 0
    text = " ".join(done.out.split())
    assert "Going from separable (4, 1) to separable (4, 2) moves the worst corner" in text
    assert "no inverse" in text
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_rows_and_document(file, tmp_path):
    done = here("map", file, "--grid", "5", "4", "--out", "-", "--json", tmp_path / "m.json")
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert len(rows) == 20
    assert rows[0]["sd"] == ""
    assert rows[0]["note"] == "no inverse"
    document = json.loads((tmp_path / "m.json").read_text())
    jsonschema.validate(document, schema("using"))
    assert len(document["sentences"]) == len(bc.camera(file).members) - 1


def test_figures_of_a_camera(file, tmp_path):
    done = here("plot", "sd-map", file, "--out", tmp_path / "m.svg")
    assert done.code == 0
    assert "among the calibration points" in done.out
    assert (tmp_path / "m.svg").stat().st_size > 10_000


def test_what_is_no_grid(file):
    done = here("map", file, "--grid", "1", "4")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "use 2 to 500" in done.err
