"""Files in the forms of other programs, made here as they write them, read without an option.

Truth: the points they were made of. A world point of COLMAP is known in the camera's frame.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import bayescal as bc
from bayescal.cli import main
from tests.helpers.points_files import rows, text, write

ROWS = rows()
TABLE = np.array(ROWS)
NAMES = [f"P{i}" for i in range(1, len(ROWS) + 1)]
FRAME = pd.DataFrame(TABLE, columns=["E", "N", "h", "col", "row"])
FRAME.insert(0, "Name", NAMES)


def numbers(points: bc.Correspondences) -> np.ndarray:
    return np.hstack([points.world, points.pixels])


def excel(folder: Path) -> Path:
    FRAME.to_excel(folder / "points.xlsx", index=False)
    return folder / "points.xlsx"


def parquet(folder: Path) -> Path:
    FRAME.to_parquet(folder / "points.parquet")
    return folder / "points.parquet"


def marker_list(folder: Path) -> Path:
    """A calibration list of particle tracking: image first, in photogrammetry's letters."""
    lines = ["# x y X Y Z", *(" ".join(map(repr, (r, c, x, y, z))) for x, y, z, r, c in ROWS)]
    return write(folder, "\n".join(lines), "markers_c0.txt")


@pytest.mark.parametrize("make", [excel, parquet, marker_list])
def test_one_file(make: Callable[[Path], Path], tmp_path: Path) -> None:
    path = make(tmp_path)
    points = bc.load(path)
    exact = 0 if make is not excel else 1e-15  # openpyxl writes 16 digits
    np.testing.assert_allclose(numbers(points), TABLE, rtol=exact, atol=0)
    if make is not marker_list:
        assert points.labels == tuple(NAMES)
        assert "col as r, row as c" in points.notes[0]
    assert points.place(0).startswith(f"{path}:")


def test_control_points_of_qgis(tmp_path: Path) -> None:
    """Rows are negative there; a point that is switched off is none."""
    lines = ["#CRS: EPSG:32632", "mapX,mapY,sourceX,sourceY,enable,dX,dY,residual"]
    lines += [
        f"{x!r},{y!r},{r!r},{-c!r},{int(i != 3)},0,0,0" for i, (x, y, _, r, c) in enumerate(ROWS)
    ]
    points = bc.load(write(tmp_path, "\n".join(lines), "map.points"), bc.Setup((0, 0, -900.0)))
    kept = np.delete(TABLE, 3, axis=0)
    np.testing.assert_array_equal(points.world[:, :2], kept[:, :2])
    np.testing.assert_array_equal(points.world[:, 2], 0)
    np.testing.assert_array_equal(points.pixels, kept[:, 3:])
    assert "1 point switched off" in points.notes[0]
    assert points.lines == (3, 4, 5, *range(7, len(ROWS) + 3))


def dlt(folder: Path) -> tuple[Path, Path]:
    """World points and image points of the direct linear transform, in order, without a header."""
    world = write(folder, text(TABLE[:, :3].tolist()).split("\n", 1)[1], "world.csv")
    return world, write(folder, text(TABLE[:, 3:].tolist()).split("\n", 1)[1], "pixels.csv")


def framespec(folder: Path) -> tuple[Path, Path]:
    """The same with headers."""
    world = write(folder, text(TABLE[:, :3].tolist(), "X,Y,Z"), "framespec.csv")
    return world, write(folder, text(TABLE[:, 3:].tolist(), "x,y"), "uv.csv")


def openptv(folder: Path) -> tuple[Path, Path]:
    """Known and detected points of a calibration, numbered, as numpy.savetxt writes them."""
    n = np.arange(len(TABLE), dtype=float)[:, None]
    np.savetxt(folder / "cam1.tif.fix", np.hstack([n, TABLE[:, :3]]), fmt="%24.17g")
    np.savetxt(folder / "cam1.tif.crd", np.hstack([n, TABLE[:, 3:]])[::-1], fmt="%24.17g")
    return folder / "cam1.tif.fix", folder / "cam1.tif.crd"


def pix4d(folder: Path) -> tuple[Path, Path]:
    """Control points with accuracies, and their marks in an image with an accuracy."""
    gcps = [
        f"{n},{x!r},{y!r},{z!r},0.02,0.03" for n, (x, y, z, _, _) in zip(NAMES, ROWS, strict=True)
    ]
    marks = [f"IMG_1.JPG,{n},{r!r},{c!r},1.2" for n, (*_, r, c) in zip(NAMES, ROWS, strict=True)]
    return write(folder, "\n".join(gcps), "gcps.txt"), write(folder, "\n".join(marks), "marks.csv")


@pytest.mark.parametrize("make", [dlt, framespec, openptv, pix4d])
def test_two_files(make: Callable[[Path], tuple[Path, Path]], tmp_path: Path) -> None:
    world, pixels = make(tmp_path)
    points = bc.load(world, pixels=pixels)
    order = slice(None, None, -1) if make is openptv else slice(None)
    np.testing.assert_array_equal(numbers(points), TABLE[order])
    assert points.source == str(pixels)


def test_two_files_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    world, pixels = map(str, openptv(tmp_path))
    command = ["fit", "--world", world, "--pixels", pixels, "--order-r", "1", "--ess", "400"]
    assert main(command) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"{len(ROWS)} points from {pixels}" in told
    assert "column 1 as label" in told


@pytest.mark.parametrize(
    ("world", "pixels", "complaint"),
    [
        ("1,2,3\n4,5,6\n", "1,2\n", "p.csv: has 1 point where .*w.csv has 2; add labels to both"),
        ("a,1,2,3\n", "b,1,2\n", "p.csv: has no label in common with .*w.csv"),
        ("a,1,2,3\na,4,5,6\n", "a,1,2\n", "w.csv:2: label 'a' stands twice"),
        ("1,2\n", "1,2\n", r"w.csv:1: has 2 columns without names; .*--columns x=1,y=2,z=3"),
        ("1,2,3\n", "1,2,3,4,5,6\n", r"p.csv:1: has 6 columns without names; .*--columns r=1,c=2"),
        ("x,y,z\n1,2,q\n", "1,2\n", "w.csv:2: z: 'q' where a number should be"),
        ("1,2,3\n", "r,c\n1,1e10\n", "p.csv:2: c: is 1e[+]10; no pixel is that far out"),
        ("a,1,2,3\n", "i,a,1,2\nj,a,1,2\n", "p.csv: holds 2 views, 'i, j'; choose with --view"),
    ],
)
def test_two_files_that_do_not_fit(world: str, pixels: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(bc.InputError, match=complaint):
        bc.load(write(tmp_path, world, "w.csv"), pixels=write(tmp_path, pixels, "p.csv"))


def test_points_that_were_not_seen_are_left_out(tmp_path: Path) -> None:
    """A second camera's columns, and NaN where a point was not digitised."""
    world = write(tmp_path, "1,2,3\n4,5,6\n7,8,9\n", "w.csv")
    pixels = write(tmp_path, "0,0,10,20\n0,0,NaN,NaN\n0,0,30,40\n", "p.csv")
    points = bc.load(world, pixels=pixels, columns="r=3,c=4")
    np.testing.assert_array_equal(numbers(points), [[1, 2, 3, 10, 20], [7, 8, 9, 30, 40]])
    assert points.notes[-1] == "1 point without a partner or without numbers left out"


def colmap(folder: Path) -> tuple[Path, Rotation, np.ndarray]:
    """A model of two images in the text form; pixels with centres at 0.5."""
    turn, shift = (
        Rotation.from_euler("xyz", [10, -20, 30], degrees=True),
        np.array([1.0, -2.0, 3.0]),
    )
    world = turn.inv().apply(TABLE[:, :3] - shift)
    x, y, z, w = turn.as_quat()
    pose = " ".join(map(repr, map(float, (w, x, y, z, *shift))))
    seen = [f"{r + 0.5!r} {c + 0.5!r} {i}" for i, (*_, r, c) in enumerate(ROWS, 1)]
    seen.insert(2, "5.5 6.5 -1")
    images = ["# Image list with two lines of data per image:", "#   IMAGE_ID, QW, ..."]
    images += [f"1 {pose} 7 one.jpg", " ".join(seen), f"2 {pose} 7 two words.jpg", "1 2 -1"]
    write(folder, "\n".join(images) + "\n", "images.txt")
    points = [
        f"{i} {' '.join(map(repr, map(float, p)))} 0 0 0 0.5 1 0" for i, p in enumerate(world, 1)
    ]
    write(folder, "# 3D point list\n" + "\n".join(points), "points3D.txt")
    write(folder, "# Camera list\n7 PINHOLE 1920 1080 1000 1000 960 540\n", "cameras.txt")
    return folder / "images.txt", turn, shift


def test_an_image_of_a_colmap_model(tmp_path: Path) -> None:
    path, *_ = colmap(tmp_path)
    points = bc.load(path, view="one.jpg")
    np.testing.assert_allclose(numbers(points), TABLE, rtol=0, atol=1e-9)  # eps times the size
    assert (points.setup.width, points.setup.height) == (1920, 1080)
    assert "in the frame of the camera of one.jpg" in points.notes[0]
    with pytest.raises(bc.InputError, match=r"2 views, 'one.jpg, two words.jpg'; choose one with"):
        bc.load(path)
    with pytest.raises(bc.InputError, match=r"there are no points"):
        bc.load(path, view="two words.jpg")


def test_damaged_files_of_other_programs(tmp_path: Path) -> None:
    whole = excel(tmp_path).read_bytes()
    for content, kind in (
        (whole[:-800], "damaged Excel workbook"),
        (b"PAR1" + b"\0" * 40, r"damaged Parquet file: \w.*\w; save it anew"),
        (b"PK\x03\x04\0xl/workbook.xml", "damaged Excel workbook"),
    ):
        with pytest.raises(bc.InputError, match=kind):
            bc.load(write(tmp_path, content, "broken"))
    path, *_ = colmap(tmp_path)
    for name, found, wrong in (
        ("images.txt", "\n1 ", "\n1 q"),
        ("points3D.txt", "\n1 ", "\n1 q "),
        ("cameras.txt", "1920", "wide"),
    ):
        colmap(tmp_path)
        broken = (tmp_path / name).read_text()
        assert found in broken
        write(tmp_path, broken.replace(found, wrong), name)
        with pytest.raises(bc.InputError, match="of a COLMAP text model"):
            bc.load(path, view="one.jpg")


def test_what_is_not_installed_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = excel(tmp_path)
    monkeypatch.setattr("sys.path", [])
    monkeypatch.delitem(__import__("sys").modules, "openpyxl")
    with pytest.raises(bc.InputError, match="install openpyxl, or save it as CSV"):
        bc.load(path)


def test_frames_and_arrays() -> None:
    points = bc.load(FRAME)
    np.testing.assert_array_equal(numbers(points), TABLE)
    assert points.labels == tuple(NAMES)
    np.testing.assert_array_equal(numbers(bc.load(TABLE)), TABLE)
    np.testing.assert_array_equal(numbers(bc.load(ROWS)), TABLE)
    indexed = bc.load(FRAME.set_index("Name"))
    assert indexed.labels == tuple(NAMES)
    broken = FRAME.assign(h=[None, *FRAME.h[1:]])
    with pytest.raises(bc.InputError, match="DataFrame, row 1: z: '' where a number should be"):
        bc.load(broken)
    twice = pd.concat([FRAME, FRAME], axis=1)
    with pytest.raises(bc.InputError, match="DataFrame: column 'Name' stands twice"):
        bc.load(twice)


@pytest.mark.parametrize(
    "wrong", [None, 5, {"x": 1}, [1, 2], np.zeros((3, 4)), "x" * 0 or ["a"] * 5, object()]
)
def test_what_are_no_points_gets_one_line(wrong: object) -> None:
    with pytest.raises(bc.InputError, match="points must be Correspondences, a file, a data frame"):
        bc.load(wrong)
    with pytest.raises(bc.InputError, match="setup must be a Setup or a TOML file"):
        bc.load(TABLE, setup=wrong if wrong is not None else 3)


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        (["--world", "w.csv"], "give --world and --pixels together"),
        (["p.csv", "--world", "w.csv", "--pixels", "p.csv"], "and no other file of points"),
        (["--columns", "x=1"], "--columns and --view say how a file is read; name the file"),
        (["w.csv", "--columns", "x=q"], "w.csv:1: no column 'q', stated for x"),
        (["w.csv", "--view", "a"], "w.csv: has no column of views; leave out --view"),
    ],
)
def test_options_that_do_not_fit_the_files(
    given: list[str],
    complaint: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, text(ROWS), "w.csv")
    write(tmp_path, text(ROWS), "p.csv")
    assert main(["compare", *given]) == 2
    assert complaint in capsys.readouterr().err
