"""A run reopens as the comparison it was written from, or says exactly why not."""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import emcee
import numpy as np
import pytest

import bayescal as bc
from bayescal.commands.options import is_run
from bayescal.comparison.results import Comparison
from bayescal.inference.arviz_bridge import parse_netcdf
from bayescal.points.setup import StatedPrior
from bayescal.report.document import document
from bayescal.report.facts import dumps
from tests.report.command import here

rng = np.random.default_rng(5)
WORLD = np.column_stack([rng.uniform(-40, 40, (16, 2)), np.repeat([60.0, 80.0, 90.0, 95.0], 4)])
PIXELS = 500 + 400 * WORLD[:, :2] / WORLD[:, 2:] + rng.normal(0, 1, (16, 2))
LABELS = ('<script>alert("1")</script>', "# a", "é\u2028", "=1+1", *map(str, range(12)))
INTEGERS = bc.Setup((1, -2, 0), 1000, 900, c_from_bottom=True, assumed=("width",))
STATED = {a: StatedPrior((500, 0, 0), (500, 400, 7)) for a in ("r", "c")}


def points(**more: Any) -> bc.Correspondences:
    return bc.Correspondences.from_arrays(WORLD, PIXELS, **more)


def text(comparison: Comparison) -> str:
    return dumps(document(comparison, "a command"))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the thesis, as the command writes it."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    done = here("compare", "--orders", "1-2", "--out", folder, "--quiet")
    assert done == (0, "", "")
    return folder


@pytest.fixture
def copy(run: Path, tmp_path: Path) -> Path:
    """A run to spoil."""
    return Path(shutil.copytree(run, tmp_path / "run"))


def test_the_document_of_a_reopened_run_is_the_run_s_to_the_byte(run: Path) -> None:
    assert text(bc.open_run(run)) == (run / "result.json").read_text(encoding="utf-8")


def test_everything_in_memory_is_what_was_computed(run: Path) -> None:
    computed = bc.compare(bc.thesis(), [1, 2])
    found = bc.open_run(run)
    for name, axis in computed.axes.items():
        for one, other in zip(axis.orders, found.axes[name].orders, strict=True):
            first, second = one.posterior.chain, other.posterior.chain
            for field in ("draws", "theta", "log_prob"):
                assert getattr(first, field).tobytes() == getattr(second, field).tobytes()
            assert first.diagnostics == second.diagnostics
            assert one.posterior.parameters == other.posterior.parameters
        assert axis.verdict == found.axes[name].verdict
    assert found.settings == computed.settings
    points = bc.thesis()
    for field in dataclasses.fields(points):
        one, other = getattr(points, field.name), getattr(found.points, field.name)
        assert np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other


def test_a_defence_comes_back_may_be_left_out_and_may_be_added(tmp_path: Path) -> None:
    asked: dict[str, Any] = {"orders": [1], "axis": "c", "ess": 100}
    computed = bc.compare(points(), **asked, defend=True)
    bc.save_run(computed, tmp_path / "defended")
    bc.save_run(bc.compare(points(), **asked), tmp_path / "plain")
    kept = (tmp_path / "defended" / "result.json").read_text(encoding="utf-8")
    assert text(bc.open_run(tmp_path / "defended")) == kept
    without = bc.open_run(tmp_path / "defended", defend=False)
    assert without.axes["c"].defence is None
    assert without.origin is None  # no longer what the run holds
    added = bc.open_run(tmp_path / "plain", defend=True)
    assert added.axes["c"].defence is not None
    found = document(added, "")
    assert found["axes"] == json.loads(kept)["axes"]


VARIANTS: dict[str, Callable[[], Comparison]] = {
    "labels, groups and deviations": lambda: bc.compare(
        points(labels=LABELS, groups=tuple("abcd" * 4), sigma_r=[0.1 + 0.2] * 16, setup=INTEGERS),
        [1, 2],
        ess=100,
    ),
    "a scale, world errors": lambda: bc.compare(
        points(
            sigma_r=[1.0] * 16,
            sigma_c=[2.0] * 16,
            sigma_x=[0.0] * 15 + [0.1],
            setup=dataclasses.replace(INTEGERS, world_sigma=(0, 0.01, 0)),
        ),
        [1],
        sigma="scale",
        ess=100,
    ),
    "stated priors": lambda: bc.compare(points(setup=bc.Setup(priors=STATED)), [1, 2], ess=100),
    "flat": lambda: bc.compare(points(), [1, 3], axis="c", prior="flat", ess=100),
    "known, numpy's numbers": lambda: bc.compare(
        points(),
        [2],
        sigma=np.int64(1),
        tau=np.float32(0.25),
        seed=np.uint8(7),
        ess=np.int16(100),
    ),
    "one axis's order": lambda: bc.fit(bc.thesis(), order_c=1, ess=100, seed=2**70),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_kind_of_comparison_comes_back(name: str, tmp_path: Path) -> None:
    comparison = VARIANTS[name]()
    bc.save_run(comparison, tmp_path / "run")
    kept = (tmp_path / "run" / "result.json").read_text(encoding="utf-8")
    assert text(bc.open_run(tmp_path / "run")) == kept
    made, stored = (json.loads(t) for t in (text(comparison), kept))
    for found in (made, stored):
        del found["provenance"]
    assert made == stored


def test_nothing_is_sampled(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("emcee was called")

    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", refuse)
    bc.open_run(run)
    with pytest.raises(AssertionError, match="emcee was called"):  # negative control
        bc.compare(bc.thesis(), [1])


def test_draws_open_in_arviz_with_groups_dimensions_and_attributes(run: Path) -> None:
    import arviz

    raw = (run / "draws" / "r-order-2.nc").read_bytes()
    ours = parse_netcdf(raw)
    tree = arviz.from_netcdf(run / "draws" / "r-order-2.nc")
    names = ["alpha_0", "alpha_1", "alpha_2", "sigma", "tau"]
    for group, dims in {
        "posterior": dict.fromkeys(names, ("chain", "draw")),
        "unconstrained_posterior": {"theta": ("chain", "draw", "coordinate")},
        "sample_stats": {"lp": ("chain", "draw")},
        "observed_data": {"pixel": ("point",), "regressor": ("point",)},
    }.items():
        assert {str(k): v.dims for k, v in tree[group].data_vars.items()} == dims
        for name in dims:
            assert tree[group][name].to_numpy().tobytes() == ours.groups[group][name].tobytes()
    attributes = tree["posterior"].attrs
    assert (attributes["axis"], attributes["regressor"], attributes["order"]) == ("r", "x/z", 2)
    assert "px" in attributes["units"]
    assert ours.values == json.loads(tree.attrs["bayescal"])
    assert ours.values["names"] == names
    tree.close()


def edit(path: Path, *changes: tuple[str, Any]) -> None:
    """Change entries, given by dotted keys, of a JSON file."""
    found = json.loads(path.read_text(encoding="utf-8"))
    for key, value in changes:
        *way, last = key.split(".")
        node = found
        for step in way:
            node = node[int(step) if step.isdigit() else step]
        node[int(last) if last.isdigit() else last] = value
    path.write_text(json.dumps(found), encoding="utf-8")


def forge(folder: Path, name: str) -> None:
    """Give a changed file the hash it has now."""
    manifest = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    manifest["files"][name] = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    (folder / "run.json").write_text(json.dumps(manifest), encoding="utf-8")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-2000])


def forged(name: str, change: Callable[[Path], None]) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        change(folder / name)
        forge(folder, name)

    return spoil


def result(*changes: tuple[str, Any]) -> Callable[[Path], None]:
    return forged("result.json", lambda path: edit(path, *changes))


ORDER = "axes.c.orders.1"
SPOILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "gone": (shutil.rmtree, r"run: there is no such file; name a folder that compare --out wrote"),
    "emptied": (
        lambda f: [shutil.rmtree(f), f.mkdir()],
        r"is not a run: it holds no result\.json, nor anything else; name a folder",
    ),
    "a file": (
        lambda f: [shutil.rmtree(f), f.write_text("x")],
        r"run: not a directory; name a folder",
    ),
    "no document": (lambda f: (f / "result.json").unlink(), r"is not a run: it holds no result"),
    "another document": (
        lambda f: (f / "result.json").write_text('{"schema": "bayescal.reproduction/1"}'),
        r"result\.json: holds 'bayescal\.reproduction/1' where a run holds",
    ),
    "no JSON": (
        lambda f: (f / "result.json").write_text('{"schema": '),
        r"result\.json: is not JSON \(.*line 1",
    ),
    "no object": (lambda f: (f / "result.json").write_text("[]"), r"is not a JSON object"),
    "no manifest": (
        lambda f: (f / "run.json").unlink(),
        r"holds no run\.json.*make it again: bayescal compare --orders 1-2 --out",
    ),
    "damaged manifest": (lambda f: (f / "run.json").write_text("{}"), r"run\.json: is damaged"),
    "damaged lines": (lambda f: edit(f / "run.json", ("lines", 5)), r"run\.json: is damaged: li"),
    "damaged line": (
        lambda f: edit(f / "run.json", ("lines.3", "x")),
        r"run\.json: is damaged: li",
    ),
    "newer format": (
        lambda f: edit(f / "run.json", ("format", 2), ("bayescal", "9.0")),
        r"format 2, written by bayescal 9\.0; bayescal \S+ reads format 1; install bayescal 9\.0",
    ),
    "older format": (lambda f: edit(f / "run.json", ("format", 0)), r"is a run of format 0"),
    "edited document": (
        lambda f: edit(f / "result.json", ("axes.r.verdict.text", "Order 5.")),
        r"result\.json: is not what was written there \(its SHA-256",
    ),
    "edited points": (
        lambda f: (f / "points.csv").write_text("x,y,z,r,c\n1,2,3,4,5\n"),
        r"points\.csv: is not what was written there",
    ),
    "cut draws": (lambda f: cut(f / "draws/c-order-1.nc"), r"c-order-1\.nc: is not what .* cut"),
    "no draws": (
        lambda f: (f / "draws/r-order-2.nc").unlink(),
        r"r-order-2\.nc: there is no such file; make it again: bayescal",
    ),
    "cut draws, forged": (forged("draws/c-order-1.nc", cut), r"c-order-1\.nc: .*; make it again"),
    "other draws, forged": (
        lambda f: [
            shutil.copy(f / "draws/c-order-1.nc", f / "draws/c-order-2.nc"),
            forge(f, "draws/c-order-2.nc"),
        ],
        r"c-order-2\.nc: holds beta_0, beta_1, sigma, not beta_0, beta_1, beta_2, sigma, tau",
    ),
    "another family": (result(("family", "fisheye")), r"is of the family 'fisheye', which"),
    "a setting to come": (
        result(("settings.colour", "blue")),
        r"was made with the setting 'colour', which bayescal \S+ does not have .*; upgrade",
    ),
    "another evidence": (
        result((f"{ORDER}.log_evidence", -1.5), ("provenance.numpy", "1.0")),
        r"log evidence of c, order 2 is -1\.5 in the run but -1\d\d\.\d+ now: written by "
        r"numpy 1\.0, read by numpy 2",
    ),
    "another mean": (
        result((f"{ORDER}.coefficients.2.mean", 1e3)),
        r"mean of beta_2 of c, order 2 is 1000\.0 in the run but .*: the same versions wrote",
    ),
    "another verdict": (
        result(("axes.r.verdict.order", 1)),
        r"order recommended for r is 1 in the run but 2 now",
    ),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_run_that_can_not_be_had_is_refused_in_one_line(name: str, copy: Path) -> None:
    change, complaint = SPOILT[name]
    change(copy)
    with pytest.raises(bc.InputError, match=complaint) as caught:
        bc.open_run(copy)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(copy))


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("provenance", {}, r"provenance\.command is missing or not what belongs there; make it"),
        ("settings", [1], r"is damaged: settings is missing"),
        ("settings.tau", "x", r"is damaged: settings\.tau is missing"),
        ("settings.noise", "cauchy", r"result\.json: noise must be gaussian.*; make it again"),
        ("data", {"source": "file"}, r"is damaged: data\.sha256 is"),
        ("axes", {}, r"is damaged: axes is"),
        ("axes", {"z": {}}, r"is damaged: axes is"),
        ("axes.r.orders", [], r"is damaged: axes\.r\.orders is"),
        ("axes.r.orders.1.order", "2", r"is damaged: axes\.r\.orders\.1\.order is"),
        ("axes.c.orders.0", {"order": 1}, r"is damaged: axes\.c\.orders\.0\.log_evidence is"),
        ("axes.c.verdict", None, r"is damaged: axes\.c\.verdict is"),
    ],
)
def test_a_document_of_another_shape_is_refused(
    copy: Path, key: str, value: object, complaint: str
) -> None:
    edit(copy / "result.json", (key, value))
    forge(copy, "result.json")
    with pytest.raises(bc.InputError, match=complaint) as caught:
        bc.open_run(copy)
    assert str(caught.value).startswith(str(copy / "result.json"))


def test_the_same_damage_is_no_business_of_another_run(copy: Path) -> None:
    """Negative control of the above."""
    assert bc.open_run(copy).orders == {"r": 2, "c": 1}


def test_rounding_is_no_disagreement(copy: Path) -> None:
    value = json.loads((copy / "result.json").read_text())["axes"]["c"]["orders"][1]["log_evidence"]
    result((f"{ORDER}.log_evidence", value + 5e-7))(copy)
    bc.open_run(copy)
    result((f"{ORDER}.log_evidence", value + 5e-6))(copy)
    with pytest.raises(bc.InputError, match="log evidence of c, order 2"):
        bc.open_run(copy)


def test_a_comparison_of_arrays_is_no_run(tmp_path: Path) -> None:
    comparison = bc.compare_polynomials(range(9), np.arange(9.0) ** 2 % 7, [1], ess=100)
    with pytest.raises(bc.InputError, match="of plain arrays"):
        bc.save_run(comparison, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_points_and_runs_are_told_apart(run: Path, tmp_path: Path) -> None:
    def asked(place: Path | str | None) -> bool:
        return is_run(argparse.Namespace(points=None if place is None else str(place)), ())

    assert asked(run)
    assert not any(map(asked, (None, "-", run / "points.csv", tmp_path / "none.csv", "n" * 300)))
    with pytest.raises(bc.InputError, match=r"is a folder, but not a run: it holds no result\.js"):
        asked(tmp_path)
