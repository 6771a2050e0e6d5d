"""Lenses on disk: reopened they say the same, nothing is fitted, and what is spoilt is refused."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import emcee
import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.calibration.fitting import least_squares
from bayescal.calibration.judging import judge
from bayescal.comparison.lenses import fitted, left_out
from bayescal.comparison.lenses.results import LensComparison
from bayescal.points.heading import Heading
from bayescal.report.document.lenses import lenses_document
from bayescal.report.document.shared import dumps, schema
from bayescal.report.figures.lenses import bow
from bayescal.report.figures.registry import figure_kinds
from tests.helpers import boards
from tests.helpers.command import here
from tests.helpers.spoilt import cut, forged, refused_in_a_line, result


@pytest.fixture(scope="module")
def made() -> LensComparison:
    target = boards.board(5, 4)
    world, pixels = boards.pictures(np.random.default_rng(1), 6, target=target)
    width, height = boards.SIZE
    names = [f"photo {i}" for i in range(6)]
    views = bc.Views.from_arrays([world] * 6, list(pixels), names=names, width=width, height=height)
    views = dataclasses.replace(views, heading=Heading("Gate 4", serial="A-1"))
    return bc.calibrate(views, lenses=["radial 1", "radial 2"], sigma="per-view", ess=100)


@pytest.fixture(scope="module")
def run(made: LensComparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lenses") / "run"
    bc.save_run(made, folder)
    return folder


@pytest.fixture
def copy(run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(run, tmp_path / "run"))


def test_the_document_of_a_reopened_run_is_the_run_s_to_the_byte(run: Path) -> None:
    kept = (run / "result.json").read_text(encoding="utf-8")
    assert dumps(lenses_document(bc.open_run(run), "another command")) == kept
    jsonschema.validate(json.loads(kept), schema("lenses"))
    assert json.loads(kept)["report"]["serial"] == "A-1"


def test_saved_again_every_file_is_the_same(run: Path, tmp_path: Path) -> None:
    bc.save_run(bc.open_run(run), tmp_path / "again")
    files = [p.relative_to(run) for p in run.rglob("*") if p.is_file()]
    assert {"views.csv", "derived.npz", "camera.npz"} < {str(name) for name in files}
    for name in files:
        assert (tmp_path / "again" / name).read_bytes() == (run / name).read_bytes(), name


def test_nothing_is_fitted_weighed_or_sampled(
    run: Path, made: LensComparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("something was computed")

    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", refuse)
    for module, name in (
        (fitted, "lens_evidence"),
        (judge, "weighed"),
        (left_out, "refitted"),
        (least_squares, "least_squares"),
    ):
        monkeypatch.setattr(module, name, refuse)
    again = bc.open_run(run)
    assert again.verdict == made.verdict
    assert (again.draws == made.draws).all()
    assert (again.best.loo.pointwise == made.best.loo.pointwise).all()
    with pytest.raises(AssertionError, match="something was computed"):  # negative control
        bc.calibrate(made.views, lenses=["radial 1"])


def test_draws_and_camera_are_the_result_s(run: Path, made: LensComparison) -> None:
    """Truth: ArviZ's variables have the means of the posterior; the camera predicts the same."""
    import h5py

    with h5py.File(run / "draws" / "radial-2.nc") as file:
        for parameter in made.posterior.parameters:
            mean = float(np.mean(file["posterior"][parameter.name][()]))
            assert mean == pytest.approx(parameter.mean, rel=1e-12)
    points = np.array([[10.0, -20.0, 400.0], [60.0, 30.0, 500.0]])
    kept, now = (bc.predict(bc.camera(source), points) for source in (run, made))
    assert (kept.mean == now.mean).all()


@pytest.mark.parametrize("kind", figure_kinds("lenses"))
def test_every_figure_is_drawn_of_a_run(kind: str, run: Path, tmp_path: Path) -> None:
    place = tmp_path / "figure.svg"
    done = here("plot", kind, run, "--out", place)
    assert (done.code, done.err) == (0, "")
    assert place.read_bytes().startswith(b"<?xml")
    words = figure_kinds("lenses")[kind].alt_text(bc.open_run(run))
    assert words in done.out


def test_names_of_earlier_versions_still_draw(run: Path, tmp_path: Path) -> None:
    for name in ("uncertainty", "sd-map"):
        done = here("plot", name, run, "--out", tmp_path / f"{name}.svg")
        assert (done.code, done.err) == (0, "")
    earlier, now = ((tmp_path / f"{name}.svg").read_bytes() for name in ("uncertainty", "sd-map"))
    assert earlier == now


def test_figures_show_the_numbers_of_the_tables(made: LensComparison) -> None:
    """Truth: evidences; offsets' normal."""
    (panel,) = bc.plot(made, "evidence").axes
    line = next(line for line in panel.lines if line.get_label() == "radial")
    heights = [made.best.log_evidence - made[f"radial {k}"].log_evidence for k in (1, 2)]
    np.testing.assert_allclose(line.get_ydata(), heights)
    target, offsets = bow.parts(made)
    for absorbed in (np.array([1.0, 0]), np.array([0, 1.0])):  # no shift is left
        assert (offsets[:, :2] @ absorbed).sum() == pytest.approx(0, abs=1e-9)
    assert (target[:, :2] * offsets[:, :2]).sum() == pytest.approx(0, abs=1e-6)  # nor scale


def test_the_page_of_a_run(run: Path, made: LensComparison, tmp_path: Path) -> None:
    place = tmp_path / "page.html"
    done = here("report", run, "--out", place)
    assert done.code == 0
    assert made.verdict.text in done.out
    page = place.read_text(encoding="utf-8")
    differ = bool(bc.image_maps(bc.camera(made)).differences)
    for kind in figure_kinds("lenses"):
        assert (f'id="figure-{kind}"' in page) == (kind != "difference-map" or differ)
    for judged in made:
        assert f"Parameters of {judged.name}: covariance" in page
    for name in made.views.names:
        assert name in page
    assert "http" not in page.replace("http://www.w3.org", "")  # nothing from outside


SPOILT: dict[str, tuple[Callable[[Path], None], str]] = {
    "arrays cut off": (forged("derived.npz", cut), r"derived\.npz: is damaged"),
    "arrays changed": (lambda f: cut(f / "derived.npz"), r"derived\.npz: is not what was written"),
    "another lens": (
        result(("lenses.0.name", "radial 3")), r"lenses of the run are not those computed now"
    ),
    "another RMS": (
        result(("lenses.0.rms_px", 0.1)), r"RMS of radial 2 is 0\.1 in the run but 0\.\d+ now"
    ),
    "another evidence": (
        result(("posterior.log_evidence_laplace", 1.0)), r"log evidence by linear algebra is 1\.0"
    ),
    "another verdict": (
        result(("verdict.status", "single")), r"verdict's status is single in the run"
    ),
    "a setting of today": (
        result(("settings.square", True)), r"radial-2\.nc: holds fx, fy, .*, not f, cx"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILT)
def test_a_spoilt_run_is_refused_in_a_line(name: str, copy: Path) -> None:
    spoil, why = SPOILT[name]
    spoil(copy)
    refused_in_a_line(copy, why)
