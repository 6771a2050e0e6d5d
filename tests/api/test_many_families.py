"""Families of many points compared from their reduction.

Truth: the comparison of the same points held at once.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.families.analysis import compare_joint
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.settings import Settings
from bayescal.points.chunks.chunk import HELD
from tests.helpers.command import here
from tests.helpers.points_files import rows, text

N = HELD + 1000
TABLE = np.array(rows(N))
SETUP = bc.Setup(width=1920, height=1080)
CAMERA = ("--image-width", "1920", "--image-height", "1080")
REQUEST = FamilyRequest(("separable", "bivariate"), (1, 2))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("many") / "points.csv"
    path.write_text(text(TABLE.tolist()))
    return path


def compared(points: object, **how: object) -> FamilyComparison:
    families = REQUEST.families
    return bc.compare_families(points, families, REQUEST.orders, setup=SETUP, **how)


def check_alike(ours: FamilyComparison, theirs: FamilyComparison) -> None:
    assert [m.key for m in ours.models] == [m.key for m in theirs.models]
    for one, other in zip(ours.models, theirs.models, strict=True):
        assert one.log_evidence == pytest.approx(other.log_evidence, abs=1e-6)
        assert one.criteria.log_likelihood == pytest.approx(other.criteria.log_likelihood, abs=1e-6)
        assert one.criteria.bic == pytest.approx(other.criteria.bic, abs=1e-6)
        assert (one.goodness is None) == (other.goodness is None)
        if one.goodness is not None:
            assert one.goodness.chi2 == pytest.approx(other.goodness.chi2, rel=1e-10)
            assert one.goodness.dof == other.goodness.dof
        for mine, held in zip(one.summaries, other.summaries, strict=True):
            assert mine.mean == pytest.approx(held.mean, rel=1e-7, abs=1e-9)
            assert mine.sd == pytest.approx(held.sd, rel=1e-7)
        assert one.loo is None


@pytest.mark.parametrize("form", ["csv", "npy", "parquet"])
def test_the_comparison_is_that_of_all_points(form: str, file: Path, tmp_path: Path) -> None:
    path = file
    if form == "npy":
        path = tmp_path / "points.npy"
        np.save(path, TABLE)
    if form == "parquet":
        pd = pytest.importorskip("pandas")
        path = tmp_path / "points.parquet"
        pd.DataFrame(TABLE, columns=list("xyzrc")).to_parquet(path)
    held = bc.Correspondences.from_arrays(TABLE[:, :3], TABLE[:, 3:], setup=SETUP)
    ours, theirs = compared(path), compare_joint(held, REQUEST, Settings())
    check_alike(ours, theirs)
    assert (ours.points.n, len(ours.points)) == (N, HELD)
    assert f"take {HELD}, drawn at random" in ours.notes[0]
    residuals = ours.best.residuals
    assert residuals.shape == (2, HELD)
    places = [int(label) - 1 for label in ours.points.labels]
    np.testing.assert_allclose(residuals, theirs.best.residuals[:, places], atol=1e-9)


@pytest.mark.parametrize("sigma", [0.7, None])
def test_deviations_and_a_known_sigma_are_those_of_all_points(sigma: float | None) -> None:
    sd = np.random.default_rng(0).uniform(0.5, 2, N) if sigma is None else None
    held = bc.Correspondences.from_arrays(
        TABLE[:, :3], TABLE[:, 3:], sigma_r=sd, sigma_c=sd, setup=SETUP
    )
    theirs = compare_joint(held, REQUEST, Settings(sigma=sigma))
    check_alike(compared(held, sigma=sigma), theirs)


def test_a_run_is_taken_up_from_the_reduction(file: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    asked = ("--family", "separable,bivariate", "--orders", "1-2", "--out", run)
    found = here("compare", file, *CAMERA, *asked)
    assert (found.code, found.err) == (0, "")
    written = json.loads((run / "result.json").read_text())
    assert (written["data"]["n_points"], written["data"]["n_held"]) == (N, HELD)
    again = bc.open_run(run)
    for model, kept in zip(again.models, written["families"]["models"], strict=True):
        assert model.log_evidence == kept["log_evidence"]
    assert here("report", run, "--out", tmp_path / "page.html").code == 0


def test_what_has_no_closed_form_has_every_point(file: Path) -> None:
    asked = ("--family", "separable", "--order-r", "1", "--order-c", "1", "--position", "free")
    found = here("fit", file, *CAMERA, *asked, "--ess", "100")
    assert found.code == 0
    assert found.err.startswith("bayescal: 6000 points, at all of which every draw looks: about")
    assert "drawn at random" not in found.out


def test_more_points_than_take_hours_are_refused(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bayescal.api.families.MOVED", N - 1)
    found = here("fit", file, *CAMERA, "--family", "pinhole", "--order", "0", "--quiet")
    assert (found.code, found.out) == (2, "")
    assert "holds more than 5999 points" in found.err
    assert found.err.count("\n") == 1
