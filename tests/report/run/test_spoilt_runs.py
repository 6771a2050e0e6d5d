"""A run that was damaged, edited or made otherwise is refused in one line that says why."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import bayescal as bc
from tests.helpers.spoilt import cut, edit, forge, forged, refused_in_a_line, result


@pytest.fixture
def copy(run: Path, tmp_path: Path) -> Path:
    """A run to spoil."""
    return Path(shutil.copytree(run, tmp_path / "run"))


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
        r"log evidence of order 2 of c is -1\.5 in the run but -1\d\d\.\d+ now: written by "
        r"numpy 1\.0, read by numpy 2",
    ),
    "another mean": (
        result((f"{ORDER}.coefficients.2.mean", 1e3)),
        r"mean of beta_2 of order 2 of c is 1000\.0 in the run but .*: the same versions wrote",
    ),
    "another verdict": (
        result(("axes.r.verdict.order", 1)),
        r"recommended order of r is 1 in the run but 2 now",
    ),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_run_that_can_not_be_had_is_refused_in_one_line(name: str, copy: Path) -> None:
    change, complaint = SPOILT[name]
    change(copy)
    refused_in_a_line(copy, complaint)


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
    with pytest.raises(bc.InputError, match="log evidence of order 2 of c"):
        bc.open_run(copy)
