"""Fleets on a real cluster: the same whatever judges them, nothing lost, nothing twice."""

from __future__ import annotations

import json
import signal
import sys
import time
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from distributed import Client
from pyarrow import parquet

import bayescal as bc
from bayescal.api.axes import compared
from bayescal.api.fleet import judge
from bayescal.comparison.settings import Settings
from bayescal.fleets.closed_forms import ClosedForms
from bayescal.fleets.journal import NAME, Journal, locked
from bayescal.fleets.judging import digest_of, seed_of
from bayescal.fleets.record import Record
from bayescal.fleets.table import parquet_bytes
from tests.fleets.conftest import OPTIONS
from tests.helpers.command import here

SETTINGS = {"judged by": "compare", "seed": 5, **OPTIONS}
WORDS = ("--orders", "1", "--axis", "c", "--ess", "100", "--no-families")


@pytest.fixture(scope="module")
def alone(cameras):
    """Truth: every camera judged in this process, one after the other."""
    return {
        name: judge(points, seed_of(digest_of(points), SETTINGS), SETTINGS)
        for name, points in cameras.items()
    }


def test_a_cluster_says_what_one_process_says(cluster, cameras, alone, tmp_path):
    again = {**cameras, "copy": cameras["camera 00"]}  # the same points are judged once
    found = bc.fleet(again, folder=tmp_path, scheduler=cluster.address, seed=5, **OPTIONS)
    assert found.records == {**alone, "copy": alone["camera 00"]}
    assert found.sound
    assert [member.name for member in found.members] == list(again)
    lines = (tmp_path / NAME).read_text().splitlines()
    assert len({json.loads(line)["key"] for line in lines}) == len(lines) == len(cameras)
    assert {odd.camera for odd in found.odd} == {"camera 02", "camera 04"}
    table = parquet.read_table(tmp_path / "cameras.parquet")
    assert table.column("camera").to_pylist() == list(again)
    assert json.loads(table.schema.metadata[b"bayescal.settings"]) == SETTINGS
    frame = found.to_dataframe()
    assert frame.loc["camera 02", "c_beta_1"] == alone["camera 02"].choices[0].parameters["1"][
        "beta_1"
    ].value  # fmt: skip


def test_a_camera_is_what_compare_says(cameras, alone):
    """The seed of a row gives its numbers."""
    record = alone["camera 03"]
    found = bc.compare(cameras["camera 03"], seed=record.seed, **OPTIONS)
    assert Record.of_orders(found) == record
    assert Record.from_json(json.loads(json.dumps(record.to_json()))) == record


def test_a_closed_form_is_drawn_only_where_draws_are_asked_for(cameras):
    """Truth: the draws that `compare` makes with the same seed."""
    points, asked = cameras["camera 03"], {"orders": [1, 2], "axis": "c", "hint": False}
    found = compared(points, Settings(seed=5, ess=100), lambda *_: ClosedForms(), **asked)
    assert not any("_drawn" in vars(result.posterior) for result in found["c"])
    drawn = bc.compare(points, seed=5, ess=100, **asked)
    for result, other in zip(found["c"], drawn["c"], strict=True):
        np.testing.assert_array_equal(result.posterior.chain.draws, other.posterior.chain.draws)
    assert repr(found["c"].verdict) == repr(drawn["c"].verdict)


def test_noise_without_a_closed_form_is_sampled(cameras):
    options = {**OPTIONS, "noise": "student-t", "orders": [1]}
    record = judge(cameras["camera 03"], 5, {"judged by": "compare", **options})
    found = bc.compare(cameras["camera 03"], seed=5, **options)["c"][1].posterior
    assert record.choices[0].parameters["1"]["beta_1"].value == found["beta_1"].mean


def test_a_journal_drops_what_a_crash_cut_short(alone, tmp_path):
    journal = Journal(tmp_path)
    for name, record in list(alone.items())[:2]:
        journal.add(name, record)
    whole = (tmp_path / NAME).read_bytes()
    (tmp_path / NAME).write_bytes(whole[:-20])
    journal = Journal(tmp_path)
    assert dict.fromkeys(journal) == {"camera 00": None}
    journal.add("camera 01", alone["camera 01"])
    assert (tmp_path / NAME).read_bytes() == whole
    (tmp_path / NAME).write_bytes(b"{}\n" + whole)
    with pytest.raises(bc.InputError, match=r"judged.jsonl:1: is no record"):
        Journal(tmp_path)


def test_the_command(cluster, files, monkeypatch):
    """One bad camera is named; again, it does only what is missing; new cameras are added."""
    monkeypatch.chdir(files)
    command = ["fleet", "cameras/*.csv", "--setup", "setup.toml", *WORDS, "--out", "out"]
    first = here(*command, "--scheduler", cluster.address)
    assert first.code == 3
    assert first.err == "bayescal: 1 camera failed (exit code 3)\n"
    assert "5 cameras: 4 judged, 0 odd, 1 failed" in first.out
    assert "bad: cameras/bad.csv:2: has 4 fields" in first.out
    assert "written: out/index.html, out/cameras.parquet" in first.out
    assert max(map(len, first.out.splitlines())) <= 100
    table = (files / "out" / "cameras.parquet").read_bytes()
    # Nothing is missing: an address that leads nowhere is not asked.
    again = here(*command, "--scheduler", "tcp://127.0.0.1:1")
    assert "5 cameras: 4 judged (4 of them before), 0 odd, 1 failed" in again.out
    assert (files / "out" / "cameras.parquet").read_bytes() == table
    (files / "cameras" / "bad.csv").unlink()
    page = (files / "out" / "index.html").read_text()
    assert "camera 00" in page
    assert "<h1>Line 3</h1>" in page
    third = here(*command, "--json", "-")
    assert third.code == 0
    assert json.loads(third.out)["data"]["n_cameras"] == 4


def test_the_command_over_views(cluster, monkeypatch, tmp_path):
    """Truth: the same lens by itself; interrupted, what is done is kept."""
    monkeypatch.chdir(tmp_path)
    bc.save_views(bc.chessboard(), "bundled.csv")
    Path("bad.csv").write_text("view,x,y,z,r,c\n1,0,0,0,x,1\n")
    options = ("--calibrate", "--lens", "radial 1", "--independent", "--ess", "100")
    options = (*options, "--noise", "outlier-mixture")
    command = ["fleet", "*.csv", *options, "--out", "out", "--scheduler", cluster.address]

    def pressed(_, name):
        if name == "bundled":
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("bayescal.commands.shared.progress.Progress.named", pressed)
        stopped = here(*command)
    assert (stopped.code, stopped.out) == (130, "")
    said = "bayescal: interrupted; what is done is kept in out; the same command goes on\n"
    assert stopped.err == said
    found = here(*command)
    assert found.code == 3
    assert "2 cameras: 1 judged (1 of them before), 0 odd, 1 failed" in found.out
    assert "bad: bad.csv:2" in found.out
    kept = json.loads(Path("out/fleet.json").read_text())
    (camera,) = (c for c in kept["cameras"] if c["camera"] == "bundled")
    seed = camera["seed"]
    asked = {"independent": True, "seed": seed, "ess": 100, "noise": "outlier-mixture"}
    alone = bc.calibrate("bundled.csv", lenses=["radial 1"], **asked)
    (choice,) = Record.of_lenses(alone).choices
    assert camera["lens_k1"] == choice.parameters["radial 1"]["k1"].value


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--lens", "eucm"], "fleet: --lens is of views; add --calibrate"),
        (["--calibrate", "--orders", "1"], "fleet: --orders is of points; drop it, or"),
        (["--calibrate", "--noise", "student-t"], "student-t noise is not offered for views"),
        (["--workers", "0"], "workers must be 1 or more, not 0"),
        (["--workers", "1", "--scheduler", "tcp://a:1"], "workers belong to a scheduler"),
        (["--seed", "-1"], "seed must not be negative"),
        (["--scheduler", "nonsense://"], "scheduler nonsense://: can't be reached"),
        (["--out", "cameras"], "cameras: exists and is not a fleet"),
    ],
)
def test_bad_usage(files, monkeypatch, words, message):
    monkeypatch.chdir(files)
    found = here("fleet", "cameras/*.csv", "--out", "out", *words)
    assert (found.code, found.out) == (2, "")
    assert message in found.err
    assert found.err.count("\n") == 1
    assert not (files / "out").exists()


def test_a_folder_is_one_runs_at_a_time(files, monkeypatch):
    monkeypatch.chdir(files)
    (files / "out").mkdir()
    (files / "out" / NAME).touch()
    with locked(files / "out" / NAME):
        found = here("fleet", "cameras/*.csv", "--out", "out")
    assert found.code == 2
    assert found.err.startswith("bayescal: out: another run is at work there; wait for it")
    assert (files / "out" / NAME).exists()


@pytest.mark.parametrize("module", ["distributed", "pyarrow"])
def test_without_what_it_needs(module, files, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    found = here("fleet", files / "cameras" / "*.csv", "--out", files / "out")
    assert found.code == 2
    assert found.err == f"bayescal: a fleet needs {module}; pip install 'bayescal[fleet]'\n"
    assert not (files / "out").exists()


def test_options_that_compare_does_not_have(cameras):
    with pytest.raises(TypeError, match="compare has no option 'lenses' for a fleet"):
        bc.fleet(cameras, lenses=["eucm"])


def test_a_killed_workers_tasks_are_done_again(cluster, cameras, alone, tmp_path):
    """Last, for it costs the cluster a worker. Nothing is lost, nothing is judged twice."""
    told = []

    def progress(name):
        told.append(name)
        if len(told) == 2:
            cluster.workers[0].send_signal(signal.SIGKILL)
            cluster.workers[0].wait()

    found = bc.fleet(
        cameras, folder=tmp_path, scheduler=cluster.address, seed=5, progress=progress, **OPTIONS
    )
    assert found.records == alone
    assert sorted(told) == sorted(cameras)
    assert len((tmp_path / NAME).read_text().splitlines()) == len(cameras)
    with Client(cluster.address, set_as_default=False) as client:
        until = time.monotonic() + 30  # the scheduler notices it in its own time
        while len(client.nthreads()) > 1 and time.monotonic() < until:
            time.sleep(0.05)
        assert len(client.nthreads()) == 1


def test_the_tables_types_do_not_depend_on_what_is_empty():
    empty = {"error": [None], "r_outcome": [None], "r_sigma_score": [None]}
    full = {"error": ["no"], "r_outcome": ["decided"], "r_sigma_score": [1.0]}
    kept = [parquet.read_schema(BytesIO(parquet_bytes(each, {}))) for each in (empty, full)]
    assert kept[0].equals(kept[1])
