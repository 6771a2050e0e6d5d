"""``bayescal calibrate`` as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.points.views.writer import views_to_csv


def test_table_verdict_and_document(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Truth: OpenCV's own boards support k1 k2; a pinhole is hopeless."""
    place, page = tmp_path / "lenses.json", tmp_path / "lenses.html"
    options = ["--lens", "pinhole", "--lens", "radial 2", "--independent", "--json", str(place)]
    options += ["--report", str(page)]
    assert main(["calibrate", *options]) == 0
    shown = capsys.readouterr().out
    assert "Verdict: radial 2 is the most probable, >99.9%; decided at 95%." in shown
    assert max(map(len, shown.splitlines())) <= 100
    document = json.loads(place.read_text())
    assert document["schema"] == "bayescal.lenses/1"
    assert [lens["name"] for lens in document["lenses"]] == ["radial 2", "pinhole"]
    assert document["lenses"][0]["rms_px"] == pytest.approx(0.18, abs=0.03)
    assert document["verdict"]["status"] == "decided"
    text = page.read_text(encoding="utf-8")
    assert "radial 2 is the most probable" in text
    for figure in ("evidence", "vectors", "sd-map"):
        assert f'id="figure-{figure}"' in text
    assert "http" not in text.replace("http://www.w3.org", "")  # nothing from outside


def test_cameras_for_other_tools(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Truth: OpenCV reads its camera and sees the bundled corners with it as well as the fit."""
    monkeypatch.chdir(tmp_path)
    views = bc.chessboard()
    bc.save_views(views, "v.csv")
    options = ["--lens", "radial 2", "--independent", "--square-pixels", "--quiet"]
    cameras = ["--camera", "opencv", "c.yml", "--camera", "colmap", "cameras.txt"]
    assert main(["calibrate", *options, *cameras, "v.csv"]) == 0
    assert capsys.readouterr().err == ""
    storage = cv2.FileStorage("c.yml", cv2.FILE_STORAGE_READ)
    matrix, k = (storage.getNode(n).mat() for n in ("camera_matrix", "distortion_coefficients"))
    assert storage.getNode("covariance").mat().shape == (6, 6)
    squares = 0.0
    for part in views.slices:
        world, pixels = views.world[part], views.pixels[part]
        _, turn, shift = cv2.solvePnP(world, pixels, matrix, k)
        squares += ((cv2.projectPoints(world, turn, shift, matrix, k)[0][:, 0] - pixels) ** 2).sum()
    assert (squares / views.n_points) ** 0.5 == pytest.approx(0.18, abs=0.02)
    line = Path("cameras.txt").read_text().splitlines()[-1].split()
    assert line[:4] == ["1", "OPENCV", "640", "480"]
    assert float(line[6]) == matrix[0, 2] + 0.5
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *("c.yml", "cameras.txt", "cameras.txt.covariance.csv", "v.csv"),
    ]
    assert main(["calibrate", *options, "--camera", "opencv", "v.csv", "--force", "v.csv"]) == 2
    assert "would replace what is read" in capsys.readouterr().err


def test_a_lens_that_a_format_lacks_and_odd_views_are_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place, table = tmp_path / "c.yaml", tmp_path / "v.csv"
    text = views_to_csv(bc.chessboard())
    again = [line for line in text.splitlines() if line.startswith("left01.jpg,")]
    table.write_text(text + "\n".join(line.replace("left01", "copy", 1) for line in again))
    options = ["--lens", "division", "--independent", "--camera", "kalibr", str(place)]
    assert main(["calibrate", str(table), *options]) == 2
    said = capsys.readouterr()
    assert "Verdict: " in said.out
    assert "note: view copy.jpg repeats view left01.jpg exactly" in said.out
    assert "Kalibr camchain has no division lens with lambda; write it for colmap" in said.err
    assert not place.exists()


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--lens", "radial 99"], "order 99"),
        (["--lens", "none"], "lens 'none'"),
        (["--sigma", "-1"], "a positive number of px, not -1"),
        (["--sigma", "replicates"], "a positive number of px, not replicates"),
        (["nowhere.csv"], "nowhere.csv"),
        (["--board", "9x6"], "--board says how a file of views is read"),
        (["--camera", "ply", "c"], "no format is called 'ply'"),
        (["--camera", "ros", "c", "--camera", "opencv", "c"], "two outputs name the same file"),
        (["--camera", "ros", "no/folder/c"], "there is no folder"),
    ],
)
def test_bad_input_is_one_line(
    options: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", *options]) == 2
    said = capsys.readouterr().err
    assert why in said
    assert said.count("\n") == 1


def test_more_points_than_memory_holds_are_refused_in_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    x, y = (part.ravel().astype(float) for part in np.meshgrid(np.arange(50), np.arange(26)))
    world, pixels = np.column_stack([x, y, 0 * x]), np.column_stack([x + 100, y + 100])
    views = bc.Views.from_arrays([world] * 2, [pixels, pixels + 1], width=700, height=500)
    monkeypatch.setattr("bayescal.api.calibrate.MOST", 2000)
    with pytest.raises(bc.InputError, match=r"2600 points are more than the 2000 that fit"):
        bc.calibrate(views)
    monkeypatch.setattr("bayescal.api.calibrate.MOST", 2600)
    monkeypatch.setattr("bayescal.api.calibrate.MOST_SHARED", 1300**2)
    apart = bc.Views.from_arrays(
        [world[1:], world[:-1]], [pixels[1:], pixels[:-1] + 1], width=700, height=500
    )
    with pytest.raises(bc.InputError, match=r"2 views of up to 1299 points: the noise that"):
        bc.calibrate(apart)
