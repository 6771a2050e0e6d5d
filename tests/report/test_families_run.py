"""Families on disk: reopened they say the same, and what is spoilt is refused in one line."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import emcee
import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.comparison.families import free, joint, models
from bayescal.comparison.families.results import FamilyComparison
from bayescal.inference.arviz_bridge import parse_netcdf, write_netcdf
from bayescal.points.camera import StatedCamera
from bayescal.report.document.families import families_document
from bayescal.report.document.shared import dumps, schema
from tests.helpers.command import here
from tests.report.test_spoilt_runs import cut, edit, forge, forged, result


def test_the_document_of_a_reopened_run_is_the_run_s_to_the_byte(families_run: Path) -> None:
    kept = (families_run / "result.json").read_text(encoding="utf-8")
    assert dumps(families_document(bc.open_run(families_run), "another command")) == kept
    jsonschema.validate(json.loads(kept), schema("families"))


def test_saved_again_every_file_is_the_same(families_run: Path, tmp_path: Path) -> None:
    bc.save_run(bc.open_run(families_run), tmp_path / "again")
    files = [p.relative_to(families_run) for p in families_run.rglob("*") if p.is_file()]
    assert len(files) == 6 + 6  # draws of pinholes, and of pairs at a free position
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
    families_run: Path, copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run without it, as of an older version, says the same; one with it searches for nothing."""
    (copy / "derived.npz").unlink()
    manifest = json.loads((copy / "run.json").read_text())
    del manifest["files"]["derived.npz"]
    (copy / "run.json").write_text(json.dumps(manifest))
    kept, computed = bc.open_run(families_run), bc.open_run(copy)
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
                bc.open_run(copy)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [("points.csv", ".0,", ".00,"), ("setup.toml", "[camera]", "# mine\n[camera]")],
)
def test_what_was_derived_from_other_points_is_not_believed(
    name: str, old: str, new: str, copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where every hash was forged: it names the points, camera and settings it is of."""
    path = copy / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    forge(copy, name)

    def noted(*_: object, **__: object) -> None:
        raise AssertionError("fitted again")

    monkeypatch.setattr(models, "fit_pinhole", noted)
    with pytest.raises(AssertionError, match="fitted again"):
        bc.open_run(copy)


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


@pytest.fixture
def copy(families_run: Path, tmp_path: Path) -> Path:
    """A run to spoil."""
    return Path(shutil.copytree(families_run, tmp_path / "run"))


FIRST = "families.models.0"
SPOILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "cut draws": (
        lambda f: cut(f / "draws/pinhole-0-free.nc"),
        r"pinhole-0-free\.nc: is not what was written .* cut",
    ),
    "cut draws, forged": (
        forged("draws/pinhole-0-free.nc", cut),
        r"pinhole-0-free\.nc: .*; make it again: bayescal compare --family",
    ),
    "no draws": (
        lambda f: (f / "draws/separable-1-1-free.nc").unlink(),
        r"separable-1-1-free\.nc: there is no such file; make it again",
    ),
    "other draws, forged": (
        lambda f: [
            shutil.copy(f / "draws/pinhole-0-free.nc", f / "draws/separable-1-1-free.nc"),
            forge(f, "draws/separable-1-1-free.nc"),
        ],
        r"separable-1-1-free\.nc: holds focal_r, .*, not alpha_0",
    ),
    "edited": (
        lambda f: edit(f / "result.json", ("verdict.text", "Mine wins.")),
        r"result\.json: is not what was written there",
    ),
    "another evidence": (
        result((f"{FIRST}.log_evidence", -1.5)),
        r"the log evidence of .* is -1\.5 in the run but -3\d\d\.\d+ now: the same versions",
    ),
    "another elpd": (
        result((f"{FIRST}.elpd_loo", -1.5)),
        r"the leave-one-out elpd of .* is -1\.5 in the run",
    ),
    "another mean": (
        result((f"{FIRST}.sampling.parameters.0.mean", -1.5)),
        r"the mean of focal_r of pinhole 0, position free is -1\.5 in the run",
    ),
    "another parameter": (
        result((f"{FIRST}.sampling.parameters.0.name", "zoom")),
        r"parameters of pinhole 0, position free of the run are not .* now: focal_r",
    ),
    "not sampled": (
        result((f"{FIRST}.sampling", None)),
        r"sampling of pinhole 0, position free is nothing in the run",
    ),
    "another verdict": (
        result(("verdict.best", "separable (1, 1), position stated")),
        r"the best model is separable \(1, 1\), position stated in the run but pinhole 0",
    ),
    "a model renamed": (
        result((f"{FIRST}.name", "fisheye 1")),
        r"models of the run are not those computed now: fisheye 1",
    ),
    "other points": (
        forged("points.csv", lambda p: p.write_text(p.read_text().replace("390", "391", 1))),
        r"the (maximum of the log likelihood|log evidence|leave-one-out elpd) of .* in the run",
    ),
    "an unknown family": (
        result(("settings.families", ["fisheye"])),
        r"result\.json: family must be separable, bivariate, pinhole, not 'fisheye' .*; make it",
    ),
    "unknown powers": (
        result(("settings.radial", "odd")),
        r"result\.json: radial must be even or all, not 'odd'",
    ),
    "no pairs": (result(("settings.pairs", [[1, 2, 3]])), r"result\.json: .*; make it again"),
    "another position": (
        result(("settings.positions", ["free"])),
        r"models of the run are not those computed now: pinhole 0, position stated",
    ),
    "more orders": (
        result(("settings.radial_orders", [0, 1])),
        r"pinhole-1-stated\.nc: there is no such file",
    ),
    "a setting to come": (
        result(("settings.colour", "blue")),
        r"was made with the setting 'colour', which bayescal \S+ does not have .*; upgrade",
    ),
    "an unusable setting": (result(("settings.ess", 1)), r"ess must be from 100 to 1000000"),
    "a text for a number": (
        result(("settings.tau", "x")),
        r"is damaged: settings\.tau is missing or not what belongs there",
    ),
    "no models": (result(("families.models", [])), r"is damaged: families\.models is"),
    "no parameters": (
        result((f"{FIRST}.sampling.parameters", [])),
        r"is damaged: families\.models\.0\.sampling\.parameters is",
    ),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_spoilt_run_is_refused_in_one_line(name: str, copy: Path) -> None:
    change, complaint = SPOILT[name]
    change(copy)
    with pytest.raises(bc.InputError, match=complaint) as caught:
        bc.open_run(copy)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(copy))


def test_rounding_is_no_disagreement(copy: Path) -> None:
    value = json.loads((copy / "result.json").read_text())["families"]["models"][0]["log_evidence"]
    result((f"{FIRST}.log_evidence", value + 5e-7))(copy)
    bc.open_run(copy)
    result((f"{FIRST}.log_evidence", value + 5e-6))(copy)
    with pytest.raises(bc.InputError, match="log evidence of"):
        bc.open_run(copy)


def test_a_folder_without_hashes_says_so(copy: Path) -> None:
    """As `compare --family --out` wrote it before runs of families could be reopened."""
    (copy / "run.json").unlink()
    with pytest.raises(bc.InputError, match=r"holds no run\.json.*make it again"):
        bc.open_run(copy)


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
        (("report", "ORDERS", "--radial", "all"), "--radial is of a pinhole: add --family pinhole"),
        (
            ("report", "--family", "separable", "--axis", "r"),
            "joint models of r and c; drop --axis r",
        ),
        (("report", "--family", "separable", "--prior", "flat"), "flat prior has no evidence"),
        (("report", "--family", "homography"), "'homography' is none of separable"),
        (("compare", "--family", "separable", "--radial-orders", "1"), "--radial-orders is of a"),
        (("compare", "--radial", "all"), "--radial is of a pinhole"),
        (("fit", "--order-r", "1", "--radial", "all"), "--radial is of a pinhole"),
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


def test_what_a_fit_prints_stands_in_its_document(tmp_path: Path) -> None:
    """Coefficients at the stated position, closed form: each row's digits are the JSON's."""
    made = tmp_path / "made.json"
    orders = ("--order-r", "2", "--order-c", "1")
    done = here("fit", "--family", "separable", *orders, "--json", made)
    assert (done.code, done.err) == (0, "")
    document: dict[str, Any] = json.loads(made.read_text(encoding="utf-8"))
    jsonschema.validate(document, schema("families"))
    (model,) = document["families"]["models"]
    assert model["elpd_reliable"] is True
    lines = [line for line in done.out.splitlines() if " to " in line and line[1] != " "]
    rows = [line.split() for line in lines]
    printed = {row[0]: row for row in rows}
    assert list(printed) == [p["name"] for p in model["closed_form"]]
    for p in model["closed_form"]:
        assert p["axis"] == ("c" if p["name"].startswith("beta") else p["name"][-1]) or (
            p["axis"] == "r" and p["name"].startswith("alpha")
        )
        mean, sd, *_, low, _, high = (
            word for word in printed[p["name"]][1:] if word[-1].isdigit() or word == "to"
        )
        said = (p["mean"], p["sd"], *p["interval"])
        for shown, value in zip((mean, sd, low, high), said, strict=True):
            digits = len(shown.partition(".")[2])
            assert float(shown) == pytest.approx(value, abs=0.5000001 * 10**-digits)


def test_draws_of_another_density_are_refused(copy: Path) -> None:
    """Hashes forged: the density at a few draws is not the one that was kept of them."""
    path = copy / "draws" / "pinhole-0-free.nc"
    draws = parse_netcdf(path.read_bytes())
    draws.groups["sample_stats"]["lp"] = draws.groups["sample_stats"]["lp"] + 0.01
    write_netcdf(path, draws)
    forge(copy, f"draws/{path.name}")
    with pytest.raises(bc.InputError, match=r"pinhole-0-free\.nc: the density of its draws is not"):
        bc.open_run(copy)
