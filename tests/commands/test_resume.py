"""An interrupted command goes on where it stopped.

Truth: the same command, not interrupted.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import bayescal as bc
from bayescal.report.run import unfinished
from tests.helpers.command import environment, here

# A command that takes long, and what it keeps of its first model.
ASKED = {
    "compare": (
        (
            *("compare", "--noise", "student-t", "--nu", "4", "--tau", "0.05"),
            *("--axis", "c", "--orders", "1-2", "--ess", "100"),
        ),
        "*.nc",
    ),
    "calibrate": (
        ("calibrate", "--lens", "radial 1", "--lens", "radial 2", "--ess", "100"),
        "*evidence.npz",
    ),
}


def document(run: Path) -> dict[str, Any]:
    """The result of a run, without what names it."""
    found: dict[str, Any] = json.loads((run / "result.json").read_text())
    del found["provenance"]
    return found


@pytest.fixture(scope="module", params=ASKED)
def whole(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = tmp_path_factory.mktemp("whole") / str(request.param)
    assert here(*ASKED[run.name][0], "--quiet", "--out", run).code == 0
    assert not run.with_name(f"{run.name}.unfinished").exists()
    return run


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_stopped_run_goes_on(how: signal.Signals, whole: Path, tmp_path: Path) -> None:
    asked, first = ASKED[whole.name]
    run, kept = tmp_path / "run", tmp_path / "run.unfinished"
    command = [sys.executable, "-m", "bayescal", *asked, "--quiet", "--out", str(run)]
    # A shell that starts tests in the background has interrupts ignored.
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(
        command, env=environment(), stderr=subprocess.PIPE, text=True, preexec_fn=heard
    ) as process:
        while not list(kept.glob(first)) and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(how)
        said = process.communicate()[1]
    assert process.returncode == (130 if how == signal.SIGINT else -signal.SIGKILL)
    if how == signal.SIGINT:
        assert ": run the same command again to go on" in said
    assert not run.exists()
    finished = set(kept.glob("*.nc")) | set(kept.glob("*.npz"))
    assert len(list(kept.glob(first))) in (1, 2)  # the last may be done before the signal comes
    taken, made = [], []
    read, write = Path.read_bytes, unfinished.write_whole

    def watched(self: Path) -> bytes:
        taken.append(self)
        return read(self)

    def noted(place: Path, raw: bytes, **how: Any) -> None:
        made.append(place)
        write(place, raw, **how)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "read_bytes", watched)
        patch.setattr(unfinished, "write_whole", noted)
        done = here(*asked, "--quiet", "--out", run)
    assert done.code == 0
    assert "holds models of an interrupted run" in done.err
    assert finished <= set(taken)
    assert made
    assert not finished & set(made)  # nothing is computed twice
    assert document(run) == document(whole)
    for place in (run / "draws").iterdir():
        assert place.read_bytes() == (whole / "draws" / place.name).read_bytes()
    assert (run / "derived.npz").read_bytes() == (whole / "derived.npz").read_bytes()
    assert not kept.exists()


def test_other_views_or_another_request_take_no_lenses(tmp_path: Path) -> None:
    views, kept = bc.chessboard(), tmp_path / "kept"
    asked: dict[str, Any] = {"lenses": ["radial 1"], "ess": 100, "resume": kept}
    first = bc.calibrate(views, **asked)
    begun = {place: place.stat().st_mtime_ns for place in kept.iterdir()}
    assert bc.calibrate(views, **asked).best.log_evidence == first.best.log_evidence
    assert {place: place.stat().st_mtime_ns for place in kept.iterdir()} == begun
    fewer = bc.calibrate(views.without(views.names[0]), **asked)
    assert fewer.best.log_evidence != first.best.log_evidence
    square = bc.calibrate(views, square=True, **asked)
    assert "f" in square.posterior.names


def test_another_request_takes_nothing(tmp_path: Path) -> None:
    asked: dict[str, Any] = {
        "orders": [1], "axis": "c", "noise": "student-t", "ess": 100, "hint": False,
    }  # fmt: skip
    first = bc.compare(bc.thesis(), resume=tmp_path / "kept", seed=1, **asked)
    (kept,) = (tmp_path / "kept").glob("*.nc")
    before = kept.stat().st_mtime_ns
    again = bc.compare(bc.thesis(), resume=tmp_path / "kept", seed=1, **asked)
    assert again["c"][1].log_evidence == first["c"][1].log_evidence
    assert kept.stat().st_mtime_ns == before
    other = bc.compare(bc.thesis(), resume=tmp_path / "kept", seed=2, **asked)
    assert other["c"][1].log_evidence != first["c"][1].log_evidence
    assert kept.stat().st_mtime_ns != before


def test_families_and_bad_points_are_kept_too(tmp_path: Path) -> None:
    asked = ("--ess", "100", "--quiet", "--out")
    for command in (
        ("compare", "--family", "pinhole", "--radial-orders", "0"),
        ("outliers", "--orders", "1", "--axis", "c"),
    ):
        run = tmp_path / command[0]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("bayescal.commands.shared.resume.Path.with_name", _elsewhere(tmp_path))
            patch.setattr("bayescal.report.run.unfinished.clear", lambda _: None)
            assert here(*command, *asked, run).code == 0
        assert list((tmp_path / "kept" / run.name).glob("*.nc")), command


def _elsewhere(folder: Path) -> Any:
    """A place for what is kept that is not removed."""
    return lambda self, _: folder / "kept" / self.name
