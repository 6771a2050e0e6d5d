"""Families on disk: reopened they say the same, and what is spoilt is refused in one line."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import emcee
import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.families import models
from bayescal.comparison.families.candidates import free, joint
from bayescal.comparison.families.results import FamilyComparison
from bayescal.inference.arviz_bridge import parse_netcdf
from bayescal.points.camera import StatedCamera
from bayescal.report.document.families import families_document
from bayescal.report.document.shared import dumps, schema
from tests.helpers.command import here
from tests.helpers.spoilt import forge


def test_the_document_of_a_reopened_run_is_the_run_s_to_the_byte(families_run: Path) -> None:
    kept = (families_run / "result.json").read_text(encoding="utf-8")
    assert dumps(families_document(bc.open_run(families_run), "another command")) == kept
    jsonschema.validate(json.loads(kept), schema("families"))


def test_saved_again_every_file_is_the_same(families_run: Path, tmp_path: Path) -> None:
    bc.save_run(bc.open_run(families_run), tmp_path / "again")
    files = [p.relative_to(families_run) for p in families_run.rglob("*") if p.is_file()]
    assert len(files) == 7 + 6  # draws of pinholes, and of pairs at a free position
    for name in files:
        assert (tmp_path / "again" / name).read_bytes() == (families_run / name).read_bytes()


def test_nothing_is_sampled_or_weighed(families_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("something was drawn")

    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", refuse)
    monkeypatch.setattr(free, "weigh", refuse)
    bc.open_run(families_run)
    for orders in ((1,), (1, 2)):  # negative controls: what is sampled, and what is weighted
        with pytest.raises(AssertionError, match="something was drawn"):
            bc.compare_families(bc.thesis(), ["separable"], orders, position=["free"], tau=0.05)


def test_what_took_long_is_read_and_else_computed_again(
    families_run: Path, families_copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run without it, as of an older version, says the same; one with it searches for nothing."""
    (families_copy / "derived.npz").unlink()
    manifest = json.loads((families_copy / "run.json").read_text())
    del manifest["files"]["derived.npz"]
    (families_copy / "run.json").write_text(json.dumps(manifest))
    kept, computed = bc.open_run(families_run), bc.open_run(families_copy)
    for one, other in zip(kept.models, computed.models, strict=True):
        assert np.array_equal(one.loo.pointwise, other.loo.pointwise)
        assert (one.loo.refitted, one.loo.mcse) == (other.loo.refitted, other.loo.mcse)
        assert np.array_equal(one.residuals, other.residuals)
        assert np.array_equal(one.position, other.position)
        if one.camera is not None:
            assert np.array_equal(one.camera.frame.root, other.camera.frame.root)

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("something was searched for")

    for module, name in (
        (joint, "sampled_leave_one_out"),
        (models, "fit_pinhole"),
        (models, "best_position"),
        (free, "position_mode"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, refuse)
            bc.open_run(families_run)
            with pytest.raises(AssertionError, match="searched for"):  # negative control
                bc.open_run(families_copy)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [("points.csv", ".0,", ".00,"), ("setup.toml", "[camera]", "# mine\n[camera]")],
)
def test_what_was_derived_from_other_points_is_not_believed(
    name: str, old: str, new: str, families_copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where every hash was forged: it names the points, camera and settings it is of."""
    path = families_copy / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    forge(families_copy, name)

    def noted(*_: object, **__: object) -> None:
        raise AssertionError("fitted again")

    monkeypatch.setattr(models, "fit_pinhole", noted)
    with pytest.raises(AssertionError, match="fitted again"):
        bc.open_run(families_copy)


def turned() -> bc.Correspondences:
    """The thesis's points with everything stated that a run must carry."""
    points = bc.thesis()
    camera = replace(StatedCamera(), position_sd=(2.0, 3.0, 20.0), orientation=(1.0, 0.0, 2.0))
    return replace(points, setup=replace(points.setup, camera=camera))


VARIANTS: dict[str, Callable[[], FamilyComparison]] = {
    "a pair of orders, all in closed form": lambda: bc.fit_family(
        bc.thesis(), "separable", (3, 1), sigma=2.5, tau=0.1
    ),
    "stated pose, all powers": lambda: bc.fit_family(
        turned(), "pinhole", (1,), radial="all", ess=100, seed=3
    ),
    "another noise": lambda: bc.fit_family(
        bc.thesis(), "pinhole", (0,), position="stated", noise="student-t", nu=4, ess=100
    ),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_kind_comes_back(name: str, tmp_path: Path) -> None:
    found = VARIANTS[name]()
    bc.save_run(found, tmp_path / "run")
    kept = (tmp_path / "run" / "result.json").read_text(encoding="utf-8")
    again = bc.open_run(tmp_path / "run")
    assert dumps(families_document(again, "")) == kept
    assert (again.request, again.settings) == (found.request, found.settings)
    made, stored = families_document(found, ""), json.loads(kept)
    del made["provenance"], stored["provenance"]
    assert json.loads(dumps(made)) == stored


def test_draws_are_named_for_people(families_run: Path) -> None:
    """Reported draws have the document's means; weighted ones their evidence in the weights."""
    models = {m["name"]: m for m in json.loads((families_run / "result.json").read_text())[
        "families"
    ]["models"]}  # fmt: skip
    sampled = weighted = 0
    for path in (families_run / "draws").iterdir():
        draws = parse_netcdf(path.read_bytes())
        model = models[str(draws.described["model"])]
        assert {"position_x", "focal_r"} & set(draws.groups["posterior"])
        assert draws.groups["observed_data"]["r"].tolist() == bc.thesis().pixel("r").tolist()
        if model["sampling"] is not None:
            sampled += 1
            for p in model["sampling"]["parameters"]:
                mean = draws.groups["posterior"][p["name"]].mean()
                assert mean == pytest.approx(p["mean"], abs=1e-9 * p["sd"])
        else:
            weighted += 1
            log_weights = draws.groups["sample_stats"]["log_weights"]
            evidence = np.logaddexp.reduce(log_weights.ravel()) - np.log(log_weights.size)
            assert evidence == pytest.approx(model["log_evidence"], abs=1e-9)
    assert (sampled, weighted) == (3, 3)


def test_a_run_can_be_defended_later(families_run: Path) -> None:
    found = bc.open_run(families_run, defend=True)
    assert found.defence.groups == 9
    assert (found.origin, bc.open_run(families_run).defence) == (None, None)
    jsonschema.validate(families_document(found, "a test"), schema("families"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("report", "RUN", "--family", "pinhole"), "is a run of families, which the page is about"),
        (("report", "RUN", "--position", "free"), "leave out --family"),
        (("report", "RUN", "--outliers"), "which holds nothing else; leave out --outliers"),
        (("report", "RUN", "--sigma", "1"), "is a run, which has its own --sigma"),
        (
            ("report", "ORDERS", "--radial", "all"),
            "--radial belongs to a pinhole: add --family pinhole",
        ),
        (
            ("report", "--family", "separable", "--axis", "r"),
            "joint models of r and c; drop --axis r",
        ),
        (("report", "--family", "separable", "--prior", "flat"), "flat prior has no evidence"),
        (("report", "--family", "homography"), "'homography' is none of separable"),
        (
            ("compare", "--family", "separable", "--radial-orders", "1"),
            "--radial-orders belongs to a",
        ),
        (("compare", "--radial", "all"), "--radial belongs to a pinhole"),
        (("fit", "--order-r", "1", "--radial", "all"), "--radial belongs to a pinhole"),
        (("plot", "models"), "name a run that compare --family --out wrote"),
        (("plot", "models", "ORDERS"), "where a run holds 'bayescal.families/1'"),
        (("plot", "curve", "RUN", "--axis", "r"), "where a run holds 'bayescal.comparison/1'"),
        (("plot", "models", "RUN", "--axis", "r"), "joint, of r and c; leave out the axis"),
    ],
)
def test_bad_requests(
    arguments: tuple[str, ...], words: str, families_run: Path, run: Path, tmp_path: Path
) -> None:
    places = {"RUN": families_run, "ORDERS": run}
    out = () if arguments[0] in ("compare", "fit") else ("--out", tmp_path / "made.svg")
    done = here(*(places.get(a, a) for a in arguments), *out)
    assert (done.code, done.out) == (2, "")
    assert words in done.err
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
