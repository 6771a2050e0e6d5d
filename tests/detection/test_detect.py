"""From photographs to views: what is used, what is not and why.

Truth: rendered photographs, and files that are none.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

import bayescal as bc
from bayescal.detection.chessboard import Chessboard
from bayescal.detection.contact_sheet import contact_sheet
from bayescal.detection.detect import Detection, detect, image_paths
from bayescal.points.views.board import Board
from tests.helpers.command import environment, here
from tests.helpers.renders import chessboard_texture, homography, photograph, seen_at

PATTERN = Chessboard(Board(5, 4, 2.0))
TURNS = (0.1, -0.3, 3.0)


def board_picture(turn: float, size: tuple[int, int] = (320, 240)) -> tuple[np.ndarray, np.ndarray]:
    texture, units = chessboard_texture(5, 4, 40)
    at = (size[0] / 2, size[1] / 2)
    shown = homography(28.0, turn, (0.01, 0.0), at, middle=(2.0, 1.5))
    return photograph(texture, units, shown, np.random.default_rng(5), size), shown


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three boards, an empty picture, one of another size, one that is no image."""
    made = tmp_path_factory.mktemp("images")
    for i, turn in enumerate(TURNS, 1):
        cv2.imwrite(str(made / f"{i} bœrd.png"), board_picture(turn)[0])
    cv2.imwrite(str(made / "4.png"), np.full((240, 320), 90, np.uint8))
    cv2.imwrite(str(made / "5.png"), board_picture(0.2, (400, 300))[0])
    (made / "6.png").write_bytes(b"no image")
    (made / "7.png").write_bytes(b"")
    return made


@pytest.fixture(scope="module")
def found(folder: Path) -> Detection:
    return detect(folder / "*.png", PATTERN)


def test_views_of_the_photographs_that_show_the_board(found: Detection) -> None:
    views = found.views
    assert views.names == ("1 bœrd.png", "2 bœrd.png", "3 bœrd.png")
    assert (views.width, views.height) == (320, 240)
    np.testing.assert_array_equal(views.target, PATTERN.target())
    truth = [seen_at(PATTERN.target() / 2, board_picture(turn)[1]) for turn in TURNS]
    assert np.abs(views.pixels - np.concatenate(truth)).max() < 0.15
    assert found.detector.endswith(f"cornerSubPix of OpenCV {cv2.__version__}")


def test_the_others_are_named_with_a_reason(found: Detection) -> None:
    assert {one.name: one.why for one in found.failed} == {
        "4.png": "no 5x4 chessboard found",
        "5.png": "is 400 by 300 px, not 320 by 240",
        "6.png": "is no image that OpenCV reads",
        "7.png": "is no image that OpenCV reads",
    }


def test_contact_sheet_shows_them_all(found: Detection) -> None:
    sheet = cv2.imdecode(np.frombuffer(contact_sheet(found.photographs), np.uint8), 1)
    assert sheet.shape == (3 * 268 + 8, 3 * 328 + 8, 3)
    # Points are drawn in colour on a grey picture, and only where a board was found.
    coloured = np.ptp(sheet.astype(int), axis=2) > 60
    pictures = [coloured[28:268, 8 + 328 * k : 328 * (k + 1)].sum() for k in range(3)]
    assert min(pictures) > 500
    assert coloured[28 + 268 : 2 * 268, 8:328].sum() == 0  # 4.png
    dark = sheet[28 + 268 + 20 : 2 * 268 - 40, 8 + 20 : 300]
    assert np.abs(dark.astype(int) - 90).max() <= 1


def test_pictures_are_the_sensors_whatever_exif_says(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(board_picture(0.1)[0]).save(tmp_path / "a.jpg", exif=exif, quality=95)
    turned = detect(tmp_path / "a.jpg", PATTERN)
    assert (turned.views.width, turned.views.height) == (320, 240)
    assert "1 photograph (the first a.jpg) would be shown turned by EXIF" in turned.views.notes[0]


def test_names_of_photographs(folder: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(folder.parent)
    relative = f"{folder.name}/[12]*.png"
    assert [p.name for p in image_paths([relative])] == ["1 bœrd.png", "2 bœrd.png"]
    assert len(image_paths([folder / "4.png", folder / "*.png"])) == 7  # each once
    (tmp_path / "[a].png").write_bytes(b"")
    assert image_paths([tmp_path / "[a].png"]) == [tmp_path / "[a].png"]
    for name, message in (
        ("nothing*.png", "no such file"),
        (folder, "is a folder; name its files"),
        ("\0", "name photographs|no such file"),
    ):
        with pytest.raises(bc.InputError, match=message):
            image_paths([name])


def test_command_writes_views_and_says_what_it_found(folder: Path, tmp_path: Path) -> None:
    out, sheet = tmp_path / "v.csv", tmp_path / "s.png"
    words = ["detect", str(folder / "*.png"), "--board", "5x4", "--square", "2"]
    done = here(*words, "--out", str(out), "--contact-sheet", str(sheet))
    assert (done.code, done.err) == (0, "")
    for piece in (
        "5x4 chessboard found in 3 of 7 photographs, 60 points, image 320 by 240 px",
        "not used: 6.png: is no image that OpenCV reads",
        f"bayescal calibrate {out}",
    ):
        assert piece in done.out
    assert bc.load_views(out).names == ("1 bœrd.png", "2 bœrd.png", "3 bœrd.png")
    assert sheet.read_bytes().startswith(b"\x89PNG")
    again = here(*words, "--out", str(out))
    assert again.code == 2
    assert "exists" in again.err
    printed = here(*words)
    assert printed.out == out.read_text(encoding="utf-8")
    assert "found in 3 of 7" in printed.err
    assert here(*words, "--quiet").err == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["4.png", "--board", "5x4"], "no 5x4 chessboard was found in 1 photographs"),
        (["4.png", "--board", "54"], "'54' is no board"),
        (["none.png", "--board", "5x4"], "no such file"),
        (["4.png", "--board", "5x4", "--pattern", "charuco"], "needs --marker SIDE and --dict"),
        (["4.png", "--board", "5x4", "--marker", "1"], "--marker belongs to --pattern charuco"),
        (["4.png", "--board", "5x4", "--out", "a", "--contact-sheet", "a"], "name the same file"),
        (["4.png", "--board", "5x4", "--out", "4.png", "--force"], "would replace a photograph"),
    ],
)
def test_bad_requests_are_one_line(folder: Path, monkeypatch, words, message: str) -> None:
    monkeypatch.chdir(folder)
    done = here("detect", *words, "--square", "2")
    assert (done.code, done.out) == (2, "")
    assert message in done.err
    assert done.err.count("\n") == 1


def test_without_opencv_there_is_a_line(folder: Path) -> None:
    """An interpreter in which cv2 can't be imported."""
    words = ["detect", str(folder / "4.png"), "--board", "5x4", "--square", "2"]
    code = f"import sys; sys.modules['cv2'] = None; from bayescal.cli import main; main({words!r})"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment(), capture_output=True, text=True
    )
    assert "install it by: pip install 'bayescal[images]'" in done.stderr
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
