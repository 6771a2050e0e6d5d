"""``bayescal plot``: from points and from runs; what it refuses, nothing written."""

from __future__ import annotations

import subprocess
import sys

import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.report.figures.registry import FIGURES, KINDS
from bayescal.report.figures.style import figure_bytes
from tests.helpers.cases import camera_points
from tests.helpers.command import apart, environment, here

ORDERS = ("--orders", "1-2", "--ess", "100")
STARTS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    """A points file and its setup."""
    folder = tmp_path_factory.mktemp("points")
    path = folder / "points.csv"
    bc.save(camera_points(15, noise=2.0), path)
    return path


@pytest.fixture(scope="module")
def run(points):
    """A run of both axes, not defended."""
    folder = points.parent / "run"
    options = (*CAMERA, *ORDERS, "--out", str(folder), "--quiet")
    assert main(["compare", str(points), *options]) == 0
    return folder


CAMERA = ("--image-width", "1920", "--image-height", "1080")


@pytest.mark.parametrize("suffix", list(STARTS))
def test_figure_is_the_librarys(points, run, tmp_path, suffix):
    path = tmp_path / f"figure.{suffix}"
    done = here("plot", "residuals", run, "--axis", "r", "--order", "2", "--out", path)
    assert (done.code, done.err) == (0, "")
    assert path.read_bytes().startswith(STARTS[suffix])
    comparison = bc.open_run(run)
    assert path.read_bytes() == figure_bytes(KINDS["residuals"].draw(comparison, "r", 2), suffix)
    assert KINDS["residuals"].alt_text(comparison, "r", 2) in done.out
    again = tmp_path / f"again.{suffix}"
    options = ("--axis", "r", "--order", "2", "--out", again, "--quiet")
    done = here("plot", "residuals", points, *CAMERA, *ORDERS, *options)
    assert (done.code, done.out, done.err) == (0, "", "")
    assert again.read_bytes() == path.read_bytes()


def test_defence_is_made_where_it_is_needed(run, tmp_path):
    path = tmp_path / "loo.svg"
    done = here("plot", "loo", run, "--axis", "c", "--out", path)
    assert (done.code, done.err) == (0, "")
    assert "best" in done.out
    assert path.read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["residuals", "--axis", "r", "--out", "f.gif"], "f.gif: a figure is written as .png"),
        (["residuals", "--axis", "r", "--out", "f"], "written as .png, .svg, .pdf"),
        (["residuals", "--out", "f.png"], "add --axis r or --axis c"),
        (["image", "--order", "2", "--out", "f.png"], "add --axis r or --axis c"),
        (["evidence", "--axis", "r", "--order", "2", "--out", "f.png"], "leave out --order"),
        (["qq", "--axis", "r", "--order", "7", "--out", "f.png"], "order 7 is not among --orders"),
        (["joint", "--axis", "r", "--out", "f.png"], "joint needs both axes"),
        (["nonsense", "--out", "f.png"], "invalid choice: 'nonsense'"),
        (["verdict"], "--out"),
        (["verdict", "--out", "no/f.png"], "there is no folder"),
    ],
)
def test_refusals_are_one_line_and_write_nothing(points, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    kind, *options = arguments
    done = here("plot", kind, points, *CAMERA, *ORDERS, *options)
    assert (done.code, done.out) == (2, "")
    assert words in done.err
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_existing_files_stay_without_force(run, tmp_path):
    path = tmp_path / "figure.svg"
    path.write_text("mine")
    done = here("plot", "verdict", run, "--out", path)
    assert done.code == 2
    assert "--force" in done.err
    assert path.read_text() == "mine"
    assert here("plot", "verdict", run, "--out", path, "--force").code == 0
    assert path.read_bytes().startswith(b"<?xml")


def test_a_folder_that_is_no_run(tmp_path):
    done = here("plot", "verdict", tmp_path, "--out", tmp_path / "f.png")
    assert done.code == 2
    assert "not a run" in done.err


def test_list_says_every_kind():
    done = here("plot", "--list")
    assert done.code == 0
    lines = done.out.splitlines()
    assert [line.split(":")[0].strip() for line in lines] == [kind.name for kind in FIGURES]
    assert all(kind.summary in done.out for kind in FIGURES)
    assert max(map(len, lines)) <= 100


def test_help_costs_neither_numpy_nor_matplotlib():
    code = (
        "import sys; from bayescal.cli import main\n"
        "try: main(['plot', '--help'])\n"
        "except SystemExit: pass\n"
        "assert not {'numpy', 'scipy', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], env=environment(), check=True)


def test_no_warning_in_a_process_of_its_own(run, tmp_path):
    done = apart("plot", "curve", run, "--axis", "r", "--out", "f.pdf", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (tmp_path / "f.pdf").read_bytes().startswith(b"%PDF")


def test_points_may_stand_behind_options(run, tmp_path):
    path = tmp_path / "figure.svg"
    done = here("plot", "residuals", "--axis", "r", run, "--out", path)
    assert (done.code, done.err) == (0, "")
    assert path.read_bytes() == _drawn(run, tmp_path / "again.svg")
    both = here("plot", "residuals", run, "--axis", "r", run, "--out", tmp_path / "no.svg")
    assert both.code == 2
    assert "unrecognized arguments" in both.err


def _drawn(run, path):
    assert here("plot", "residuals", run, "--axis", "r", "--out", path).code == 0
    return path.read_bytes()
