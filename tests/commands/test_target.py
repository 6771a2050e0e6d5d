"""``bayescal locate --target`` as a user meets it."""

from __future__ import annotations

import csv
import io
import json

import cv2
import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.report.document.shared import schema
from tests.helpers.boards import board
from tests.helpers.cases import not_a_number
from tests.helpers.command import here
from tests.helpers.multi_view import DISTORTION, MATRIX


@pytest.fixture(scope="module")
def place(lens_comparison, tmp_path_factory):
    """A folder with a camera and the corners of one picture, one of them spoilt."""
    folder = tmp_path_factory.mktemp("target")
    bc.keep_camera(bc.camera(lens_comparison), folder / "camera.npz")
    pixels = cv2.projectPoints(
        board(), np.array([0.3, -0.4, 0.2]), np.array([-20.0, 15, 420]), MATRIX, DISTORTION
    )[0][:, 0]
    rows = [",".join(f"{v:.9g}" for v in row) for row in np.column_stack([board(), pixels])]
    rows[3] = rows[3].rsplit(",", 1)[0] + ",dark"
    (folder / "target.csv").write_text("\n".join(["x,y,z,r,c", *rows]) + "\n")
    return folder


def test_the_pose_is_shown_with_its_budget(place):
    done = here("locate", place / "camera.npz", place / "target.csv", "--target")
    assert done.code == 0
    assert "a target of 53 points" in done.out
    assert "Pose of the target in the camera's frame" in done.out or "turn x [deg]" in done.out
    assert "sd by coefficients" in done.out
    assert "target.csv:5: c: 'dark'" in done.err
    assert not_a_number(done.out) == []
    assert max(map(len, done.out.splitlines())) <= 100


def test_the_document_holds_the_covariance(place, tmp_path):
    words = ("--target", "--json", tmp_path / "pose.json", "--out", "-")
    done = here("locate", place / "camera.npz", place / "target.csv", *words)
    found = json.loads((tmp_path / "pose.json").read_text())
    jsonschema.validate(found, schema("using"))
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert [row["quantity"] for row in rows] == found["quantities"]
    sd = np.sqrt(np.diag(found["covariance"]))
    np.testing.assert_allclose([float(row["sd"]) for row in rows], sd, rtol=1e-9)


def test_noise_above_the_calibrations_is_said(place, tmp_path):
    lines = (place / "target.csv").read_text().splitlines()
    first = lines[1].split(",")
    lines[1] = ",".join([*first[:3], str(float(first[3]) + 4.0), first[4]])
    (tmp_path / "off.csv").write_text("\n".join(lines) + "\n")
    done = here("locate", place / "camera.npz", tmp_path / "off.csv", "--target")
    assert "far more than the noise and" in " ".join(done.out.split())


def test_what_is_no_target(place):
    for words, said in (
        (("--target", "--depth", "3"), "leave out --depth"),
        (("--sigma", "1"), "belongs to --target"),
        (("--target", "--strict"), "target.csv:5"),
        (("--target", "--sigma", "-1"), "sigma must be above 0"),
    ):
        done = here("locate", place / "camera.npz", place / "target.csv", *words)
        assert done.code == 2
        assert said in done.err, done.err
        assert done.err.splitlines()[-1].startswith("bayescal: ")
