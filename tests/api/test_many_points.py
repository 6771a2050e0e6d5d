"""Many points compared from their reduction.

Truth: the comparison of the same points held at once.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.commands.shared.progress import Progress
from bayescal.comparison.analysis import analyse_points
from bayescal.comparison.results import Comparison
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.points.chunks.chunk import HELD
from tests.helpers.command import here
from tests.helpers.points_files import rows, text

N = HELD + 1000
TABLE = np.array(rows(N))
SETUP = bc.Setup(width=1920, height=1080)
CAMERA = ("--image-width", "1920", "--image-height", "1080")
QUICK = {"orders": [1, 2], "ess": 100}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("many") / "points.csv"
    path.write_text(text(TABLE.tolist()))
    return path


@pytest.fixture(scope="module")
def reduced(file: Path) -> Comparison:
    return bc.compare(file, setup=SETUP, hint=False, **QUICK)


@pytest.fixture(scope="module")
def at_once() -> Comparison:
    points = bc.Correspondences.from_arrays(TABLE[:, :3], TABLE[:, 3:], setup=SETUP)
    return analyse_points(points, {"r": (1, 2), "c": (1, 2)}, Settings(ess=100), None)


@pytest.mark.parametrize("axis", ["r", "c"])
def test_the_comparison_is_that_of_all_points(
    axis: str, reduced: Comparison, at_once: Comparison
) -> None:
    for ours, theirs in zip(reduced[axis], at_once[axis], strict=True):
        assert ours.log_evidence == pytest.approx(theirs.log_evidence, abs=1e-7)
        assert ours.rss_px2 == pytest.approx(theirs.rss_px2, rel=1e-11)
        assert ours.criteria.bic == pytest.approx(theirs.criteria.bic, abs=1e-7)
        np.testing.assert_allclose(ours.fit.coefficients, theirs.fit.coefficients, rtol=1e-10)
        exact = [o.exact.summary for o in (ours, theirs) if o.exact is not None]
        np.testing.assert_allclose(*exact, rtol=1e-7)
    assert reduced[axis].data.n == N
    assert len(reduced[axis].data) == HELD
    assert reduced[axis].data.domain == at_once[axis].data.domain


def test_what_was_assumed_is_said(reduced: Comparison) -> None:
    assert f"take {HELD}, drawn at random" in reduced.notes[0]
    assert reduced.points is not None
    assert (reduced.points.n, len(reduced.points)) == (N, HELD)


def test_deviations_of_points_are_reduced_too() -> None:
    sd = np.random.default_rng(0).uniform(0.5, 2, N)
    points = bc.Correspondences.from_arrays(
        TABLE[:, :3], TABLE[:, 3:], sigma_r=sd, sigma_c=sd, setup=SETUP
    )
    ours = bc.compare(points, axis="r", hint=False, **QUICK)["r"]
    theirs = analyse_points(points, {"r": (1, 2)}, Settings(ess=100), None)["r"]
    for order in (1, 2):
        assert ours[order].log_evidence == pytest.approx(theirs[order].log_evidence, abs=1e-7)
        assert ours[order].goodness.chi2 == pytest.approx(theirs[order].goodness.chi2, rel=1e-10)
        assert ours[order].rss_px2 == pytest.approx(theirs[order].rss_px2, rel=1e-10)


def test_the_span_of_all_stands_for_an_unknown_size() -> None:
    ours = bc.compare(TABLE, axis="r", hint=False, **QUICK)["r"]
    points = bc.Correspondences.from_arrays(TABLE[:, :3], TABLE[:, 3:])
    theirs = analyse_points(points, {"r": (1, 2)}, Settings(ess=100), None)["r"]
    assert ours.prior.size == theirs.prior.size
    assert ours[2].log_evidence == pytest.approx(theirs[2].log_evidence, abs=1e-7)


def test_what_needs_every_point_has_them(file: Path) -> None:
    found = bc.fit(file, order_r=1, setup=SETUP, noise="student-t", ess=100)
    assert found.points is not None
    assert (found.points.drawn_from, len(found.points)) == (None, N)
    with pytest.raises(InputError, match="replicates"):
        bc.compare(file, setup=SETUP, sigma="replicates")


def test_a_defence_reads_all_points_again(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", np.concatenate([TABLE, TABLE[::-1]]))
    asked = ("--orders", "1-2", "--ess", "100", "--axis", "r", "--no-families", "--defend")
    run = tmp_path / "run"
    found = here("compare", tmp_path / "points.npy", *CAMERA, *asked, "--out", run)
    assert found.code == 0
    assert f"Tested on {HELD} of 12,000 points" in found.out
    assert "without groups, draws (PSIS)" in " ".join(found.out.split())
    written = json.loads((run / "result.json").read_text())["axes"]["r"]
    again = bc.open_run(run)["r"]
    assert again.defence is not None
    for order in written["orders"]:
        prediction = again.defence.prediction[order["order"]]
        assert prediction.loo.elpd == order["elpd_loo"]
        # Of n points and p parameters; ln Z of all holds the prior too.
        assert order["p_loo"] == pytest.approx(order["n_parameters"], abs=1)
    assert bc.open_run(run, defend=False)["r"].defence is None


def test_a_sample_given_again_is_no_whole(reduced: Comparison) -> None:
    again = bc.compare(reduced.points, axis="r", hint=False, **QUICK)
    assert again["r"].data.n == HELD
    assert any("drawn from 6000" in note for note in again.notes)


def test_a_run_is_taken_up_from_the_reduction(file: Path, tmp_path: Path) -> None:
    run, orders = tmp_path / "run", ("--orders", "1-2", "--ess", "100")
    asked = ("compare", file, *CAMERA, *orders, "--out", run, "--no-families")
    assert here(*asked, "--quiet").code == 0
    found = bc.open_run(run)
    written = json.loads((run / "result.json").read_text())
    assert written["data"]["n_points"] == written["axes"]["r"]["n"] == N
    assert written["data"]["n_held"] == HELD
    for order in written["axes"]["r"]["orders"]:
        assert found["r"][order["order"]].log_evidence == order["log_evidence"]
    assert not bc.open_run(run, defend=True)["r"].defence
    raw = (run / "reduction.npz").read_bytes()
    (run / "reduction.npz").write_bytes(raw[:-40] + b"0" * 40)
    with pytest.raises(InputError, match=r"reduction.npz: is not what was written"):
        bc.open_run(run)


def test_an_interrupt_stops_at_once(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Progress, "more", pressed)
    found = here("compare", file, *CAMERA, "--out", tmp_path / "run")
    assert (found.code, found.out) == (130, "")
    assert found.err == "bayescal: interrupted; nothing was written\n"
    assert not (tmp_path / "run").exists()


def test_every_reading_is_counted_from_nothing(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Truth: a defence of both axes reads the points three times, and a line counts each once."""
    counted: dict[Progress, int] = {}
    original = Progress.more

    def more(self: Progress, count: int) -> None:
        counted[self] = counted.get(self, 0) + count
        original(self, count)

    monkeypatch.setattr(Progress, "more", more)
    monkeypatch.setattr("bayescal.comparison.many.DEFENDED", 0)  # as if they were too many to hold
    asked = ("--orders", "1-2", "--ess", "100", "--no-families", "--quiet")
    assert here("compare", file, *CAMERA, *asked, "--defend").code == 0
    assert list(counted.values()) == [N, N, N]


def test_where_every_draw_looks_at_every_point_it_is_said(file: Path) -> None:
    asked = ("compare", file, *CAMERA, "--orders", "1", "--axis", "r", "--ess", "100")
    found = here(*asked, "--noise", "student-t", "--nu", "4", "--no-families")
    told = "bayescal: 6000 points, at all of which every draw looks: about 0.7 s a model, 0.7 s in"
    assert found.err.startswith(told)
    assert found.err.count("\n") == 1
    assert here(*asked, "--no-families").err == ""
