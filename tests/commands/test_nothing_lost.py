"""A run that contradicts options, and output that would replace what is read: refused."""

from __future__ import annotations

import pytest

import bayescal as bc
from tests.helpers.cases import camera_points
from tests.helpers.command import here

CAMERA = ("--image-width", "1920", "--image-height", "1080")


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    path = tmp_path_factory.mktemp("points") / "points.csv"
    bc.save(camera_points(15, noise=2.0), path)
    return path


@pytest.fixture(scope="module")
def run(points):
    folder = points.parent / "run"
    options = ("--orders", "1-2", "--ess", "100", "--out", folder, "--quiet")
    assert here("compare", points, *CAMERA, *options).code == 0
    return folder


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--sigma", ["1"]),
        ("--orders", ["1-5"]),  # even where it is the default
        ("--seed", ["0"]),
        ("--ess", ["4000"]),
        ("--noise", ["gaussian"]),
        ("--bad-offset", []),
        ("--prior", ["field"]),
        ("--tau", ["0.1"]),
        ("--nu", ["3"]),
        ("--setup", ["setup.toml"]),
        ("--camera-position", ["0", "0", "0"]),
        ("--image-width", ["1920"]),
        ("--no-c-from-bottom", []),
    ],
)
@pytest.mark.parametrize("command", [["report"], ["plot", "verdict"]])
def test_a_run_is_not_asked_for_anything_else(run, tmp_path, command, option, value):
    done = here(*command, run, option, *value, "--out", tmp_path / "made.pdf")
    assert (done.code, done.out) == (2, "")
    assert f"is a run, which has its own {option}; leave" in done.err
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_report_shows_the_axes_that_a_run_has(run, tmp_path):
    done = here("report", run, "--axis", "r", "--out", tmp_path / "made.html")
    assert done.code == 2
    assert "its own --axis" in done.err


@pytest.mark.parametrize(
    "command",
    [
        ["compare", "{points}", "--json", "{points}"],
        ["fit", "{points}", "--order-r", "1", "--json", "{points}"],
        ["outliers", "{points}", "--json", "{points}"],
        ["reproduce", "{points}", "--json", "{points}"],
        ["report", "{points}", "--out", "{points}"],
        ["report", "{points}", "--out", "{folder}/report.html", "--pdf", "{points}"],
        ["compare", "{link}", "--json", "{points}"],
        ["compare", "{points}", "--json", "{link}"],
        ["simulate", "--like", "{points}", "--order", "1", "--out", "{points}"],
        ["compare", "{points}", "--setup", "{run}/setup.toml", "--json", "{run}/setup.toml"],
        ["report", "{run}", "--out", "{run}/result.json"],
        ["report", "{run}", "--out", "{run}/draws/r-order-1.nc"],
        ["plot", "verdict", "{run}", "--out", "{run}/corner-r.png"],
    ],
    ids=" ".join,
)
def test_force_does_not_replace_what_is_read(points, run, tmp_path, command):
    link = tmp_path / "link.csv"
    link.symlink_to(points)
    names = {"points": points, "run": run, "link": link, "folder": tmp_path}
    before = {p: p.read_bytes() for p in points.parent.rglob("*") if p.is_file()}
    done = here(*(word.format(**names) for word in command), "--force")
    assert (done.code, done.out) == (2, "")
    assert "would replace what is read; choose another name" in done.err
    assert {p: p.read_bytes() for p in points.parent.rglob("*") if p.is_file()} == before
    assert list(tmp_path.iterdir()) == [link]


def test_one_place_under_two_names_is_one(points, tmp_path):
    (tmp_path / "deep").mkdir()
    out, again = tmp_path / "made.html", tmp_path / "deep" / ".." / "made.html"
    done = here("report", points, "--out", out, "--pdf", again)
    assert done.code == 2
    assert "is named by --out too" in done.err
