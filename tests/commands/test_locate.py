"""``bayescal locate`` as a user meets it."""

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
def run(thesis_comparison, tmp_path_factory):
    """A run of the thesis's points."""
    place = tmp_path_factory.mktemp("locate") / "run"
    bc.save_run(thesis_comparison, place)
    return place


@pytest.fixture
def pixels(tmp_path):
    """A good pixel, one that nothing in the domain appears at, a bad row."""
    place = tmp_path / "pixels.csv"
    place.write_text("r,c\n900,500\n3,4\nx,2\n")
    return place


def test_points_at_a_depth(run, pixels):
    done = here("locate", run, pixels, "--depth", "300", "--depth-sd", "1")
    assert done.code == 0
    assert "2 pixels at z = 300 (sd 1, the same error for all)" in done.out
    assert "no solution" in done.out
    assert "pixels.csv:4: r: 'x'" in done.err
    assert "noise" in done.out
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_the_document_follows_its_schema(run, pixels):
    done = here("locate", run, pixels, "--depth", "300", "--json", "-")
    jsonschema.validate(json.loads(done.out), schema("using"))


def test_rows_hold_the_point_and_its_budget(run, pixels):
    done = here("locate", run, pixels, "--depth", "300", "--out", "-")
    first, second = csv.DictReader(io.StringIO(done.out))
    assert float(first["z"]) == 300
    assert float(first["noise_sd_x"]) > 0
    assert second["x"] == ""
    assert second["note"] == "nothing in the calibrated domain appears there"


def test_directions_without_a_depth(run, pixels):
    done = here("locate", run, pixels, "--out", "-")
    first = next(csv.DictReader(io.StringIO(done.out)))
    assert sum(float(first[name]) ** 2 for name in ("dx", "dy", "dz")) == pytest.approx(1, abs=1e-4)
    shown = here("locate", run, pixels)
    assert "as directions" in shown.out
    assert max(map(len, shown.out.splitlines())) <= 100


def test_pairs_end_in_a_statement(run, tmp_path):
    (tmp_path / "pairs.csv").write_text("r1,c1,r2,c2\n900,500,950,500\n3,4,900,500\n")
    done = here("locate", run, tmp_path / "pairs.csv", "--pairs", "--depth", "300")
    assert done.code == 0
    assert "For a certificate:" in done.out
    assert "coverage probability 95%" in " ".join(done.out.split())
    assert "an end has no solution" in done.out
    assert "may be 0" not in done.out
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_what_cannot_be_located(run, pixels):
    for words, said in (
        (("--pairs",), "--pairs needs --depth or --plane"),
        (("--depth", "1", "--plane", "0", "0", "1", "2"), "keep one"),
        (("--depth-sd", "1"), "belongs to --depth"),
        (("--plane", "0", "0", "0", "1"), "not all 0"),
        (("--depth", "nan"), "the depth is nan: give a finite z"),
        (("--depth", "1e300"), "the depth is 1e+300"),
        (("--plane", "0", "0", "1e150", "1"), "must be below 1e+100"),
        (("--seed", "-1"), "seed must be 0 or more"),
    ):
        done = here("locate", run, pixels, *words)
        assert done.code == 2
        assert said in done.err, done.err
        assert done.err.count("\n") == 1


def test_pixels_of_another_camera(run, tmp_path):
    (tmp_path / "far.csv").write_text("r,c\n3000,500\n-40,300\n")
    done = here("locate", run, tmp_path / "far.csv", "--depth", "300")
    assert done.code == 0
    assert "outside, no solution" in done.out
    assert "All pixels lie outside the image: are they of another camera?" in done.out


def test_a_stated_depth_is_exact(run, pixels):
    done = here("locate", run, pixels, "--depth", "300")
    row = next(line for line in done.out.splitlines() if line.split()[:1] == ["1"])
    assert row.split()[3] == "300.000"
    assert row.split()[-1] == "0"


def test_two_ends_at_one_pixel_are_not_told_from_one_point(run, tmp_path):
    """Truth: a distance of 0, whose mean over noise is not; the certificate takes the next one."""
    (tmp_path / "pairs.csv").write_text("r1,c1,r2,c2\n900,500,900,500\n900,500,950,500\n")
    words = (run, tmp_path / "pairs.csv", "--pairs", "--depth", "300")
    rows = list(csv.DictReader(io.StringIO(here("locate", *words, "--out", "-").out)))
    assert [row["note"] for row in rows] == ["may be 0", ""]
    shown = here("locate", *words).out
    assert "may be 0: noise alone" in shown
    told = shown.split("For a certificate: ")[1].split()[0]
    assert float(told) == pytest.approx(float(rows[1]["distance"]), rel=0.01)
    assert max(map(len, shown.splitlines())) <= 100
