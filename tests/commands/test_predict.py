"""``bayescal predict`` as a user meets it: rows answered, rows named, nothing invented."""

from __future__ import annotations

import csv
import io
import json

import jsonschema
import numpy as np
import pandas as pd
import pytest

import bayescal as bc
from bayescal.errors import InputError
from bayescal.report.document.shared import schema
from tests.helpers.cases import not_a_number
from tests.helpers.command import here

ROWS = "label,x,y,z\na,300,60,250\nb,nan,80,300\nc,310,80,300\nd,1,2\ne,330,57,-200\nf,900,57,300\n"


@pytest.fixture(scope="module")
def run(thesis_comparison, tmp_path_factory):
    """A run of the thesis's points."""
    place = tmp_path_factory.mktemp("predict") / "run"
    bc.save_run(thesis_comparison, place)
    return place


@pytest.fixture
def points(tmp_path):
    """Six rows: two bad, one behind the camera, one off the image."""
    place = tmp_path / "points.csv"
    place.write_text(ROWS)
    return place


def test_rows_are_answered_and_bad_ones_named(run, points):
    done = here("predict", run, points)
    assert done.code == 0
    assert "4 points, averaged over" in done.out
    assert "not seen" in done.out
    assert "outside, extrapolated" in done.out
    assert "points.csv:3: x: is nan" in done.err
    assert "points.csv:5: has 3 fields" in done.err
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_the_file_holds_what_python_gives(run, points):
    done = here("predict", run, points, "--out", "-", "--no-average")
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert [row["label"] for row in rows] == ["a", "c", "e", "f"]
    found = bc.predict(run, [[300, 60, 250]], average=False)
    for name, array in (("r", found.mean[0, 0]), ("c", found.mean[0, 1]), ("sd_c", found.sd[0, 1])):
        assert float(rows[0][name]) == pytest.approx(array, rel=1e-9)
    assert rows[2]["r"] == rows[2]["lower_c"] == ""
    assert rows[2]["note"] == "behind the camera, or beyond the lens's reach"
    assert not_a_number(done.out) == []


def test_the_document_holds_the_same(run, points, tmp_path):
    place = tmp_path / "found.json"
    done = here("predict", run, points, "--json", place, "--quiet")
    assert (done.code, done.out) == (0, "")
    assert done.err.count("left out") == 2
    document = json.loads(place.read_text())
    jsonschema.validate(document, schema("using"))
    assert document["schema"] == "bayescal.prediction/1"
    assert document["averaged"] is True
    assert np.isclose(sum(m["probability"] for m in document["models"]), 1)
    assert document["rows"][2]["r"] is None
    assert document["rows"][0]["sd_r"] > 0


def test_strict_refuses_a_bad_row(run, points, tmp_path):
    done = here("predict", run, points, "--strict", "--out", tmp_path / "o.csv")
    assert done.code == 2
    assert "points.csv:3: x: is nan" in done.err
    assert not (tmp_path / "o.csv").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("x,y,z\n", "holds no row that can be used"),
        ("x,y,z\nq,1,1\n", "holds no row that can be used; the first:"),
        ("x,y\n1,2\n", "no column 'z'"),
    ],
)
def test_tables_without_an_answer(run, tmp_path, text, words):
    (tmp_path / "p.csv").write_text(text)
    done = here("predict", run, tmp_path / "p.csv")
    assert done.code == 2
    assert words in done.err
    assert done.err.count("\n") == 1


def test_options_that_cannot_be(run, points, tmp_path):
    for words, said in (
        ((run, points, "--model", "pinhole 1"), "none of the plausible models"),
        ((run, points, "--model", "separable (4, 1)", "--average"), "leave out --average"),
        ((run, points, "--out", "-", "--json", "-"), "name a file for one"),
        ((run, points, "--out", points, "--force"), "would replace what is read"),
        ((run, points, "--out", run / "x.csv"), "lies in the run"),
        ((tmp_path, points), "not a run"),
        ((tmp_path / "none", points), "no such file"),
        ((points, points), "is no camera file; give a run's folder or a camera file, before"),
    ):
        done = here("predict", *words)
        assert done.code == 2
        assert said in done.err, done.err


def test_one_model_can_be_taken(run, points):
    done = here("predict", run, points, "--model", "separable (5, 1)")
    assert "by separable (5, 1)" in done.out


def test_points_of_another_camera_and_no_points(run, tmp_path):
    (tmp_path / "far.csv").write_text("x,y,z\n9000,60,250\n300,60,-250\n")
    done = here("predict", run, tmp_path / "far.csv")
    assert done.code == 0
    assert "No point appears in the image: are they of another camera?" in done.out
    for text, said in (("", "is empty"), ("x,y,z\n", "holds no row"), ("x,y,z\n1,2\n", "no row")):
        (tmp_path / "none.csv").write_text(text)
        done = here("predict", run, tmp_path / "none.csv")
        assert (done.code, done.err.count("\n")) == (2, 1)
        assert said in done.err


@pytest.mark.parametrize("kind", ["excel", "parquet"])
def test_workbooks_and_parquet_are_read(run, tmp_path, kind):
    """Truth: the same table as text; a row that holds no number is named and left out."""
    frame = pd.DataFrame(
        {"x": [300.0, np.nan, 310.0], "y": [60.0, 1.0, 80.0], "z": [250.0, 1, 300]}
    )
    frame.to_csv(tmp_path / "p.csv", index=False)
    name = tmp_path / {"excel": "p.xlsx", "parquet": "p.parquet"}[kind]
    if kind == "excel":
        frame.to_excel(name, index=False)
    else:
        frame.to_parquet(name)
    found, text = (
        here("predict", run, given, "--out", "-") for given in (name, tmp_path / "p.csv")
    )
    assert found.out == text.out
    assert found.out.count("\n") == 3
    assert f"left out: {name}" in found.err


def test_a_run_without_a_camera_is_named(run, points, tmp_path):
    """A run of one axis, whichever of two it is; and from Python what holds no camera at all."""
    bc.save_run(bc.compare(bc.thesis(), orders=[1], axis="r", ess=100), tmp_path / "alone")
    for words in (("predict", tmp_path / "alone", points), ("changed", run, tmp_path / "alone")):
        done = here(*words)
        assert done.code == 2
        assert f"{tmp_path / 'alone'}: the comparison is of one axis alone" in done.err
        assert done.err.count("\n") == 1
    with pytest.raises(InputError, match="of the kind dict holds no calibrated camera; take one"):
        bc.camera({})
