"""``bayescal changed`` as a user meets it."""

from __future__ import annotations

import csv
import io
import json

import jsonschema
import pytest

import bayescal as bc
from bayescal.report.document.shared import schema
from tests.helpers.cases import camera_points, not_a_number
from tests.helpers.command import here


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three calibrations: of a camera twice, and of one that was moved."""
    place = tmp_path_factory.mktemp("changed")
    for name, seed, aside in (("one", 1, 0.0), ("two", 2, 0.0), ("moved", 3, 30.0)):
        points = camera_points(40, (960.0 + aside, 700.0), noise=1.0, seed=seed)
        bc.keep_camera(bc.camera(bc.fit(points, 1, 1, ess=100)), place / f"{name}.npz")
    return place


def test_a_change_is_said_and_drawn(folder, tmp_path):
    figure = tmp_path / "change.png"
    done = here("changed", folder / "one.npz", folder / "moved.npz", "--figure", figure)
    assert done.code == 0
    assert "The camera has changed" in done.out
    names = [
        f"{which}: {folder / name}.npz" for which, name in (("first", "one"), ("second", "moved"))
    ]
    told = "".join(done.out.split())
    assert all("".join(name.split()) in told for name in names)
    assert "by what the points alone say of separable (1, 1)" in " ".join(done.out.split())
    assert figure.read_bytes()[:4] == b"\x89PNG"
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_no_change_has_a_bound(folder, tmp_path):
    words = (folder / "one.npz", folder / "two.npz", "--json", tmp_path / "c.json", "--out", "-")
    done = here("changed", *words)
    found = json.loads((tmp_path / "c.json").read_text())
    jsonschema.validate(found, schema("using"))
    assert found["changed"] == (found["p_value"] < 0.05)
    assert found["bound_px"] > 0
    assert len(list(csv.DictReader(io.StringIO(done.out)))) == len(found["rows"])


def test_what_cannot_be_compared(folder):
    for words, said in (
        (("one.npz", "none.npz"), "no such file"),
        (("one.npz", "two.npz", "--figure", "x.gif"), ".png"),
        (("one.npz", "two.npz", "--seed", "-1"), "seed must be 0 or more"),
        (("one.npz", "one.npz"), "is given twice"),
        (("one.npz", "two.npz", "--json", folder / "two.npz"), "exists"),
    ):
        first, second, *rest = words
        done = here("changed", folder / first, folder / second, *rest)
        assert done.code == 2
        assert said in done.err, done.err
        assert done.err.count("\n") == 1
