"""Files of views that other tools write.

Truth: views written by hand in each tool's documented form; NumPy's and scipy's own writers for
their archives. (The readers were also tried on files of the tools themselves: docs/views.md.)
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import bayescal as bc
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views
from tests.helpers.view_files import (
    BOARD,
    IMAGES,
    OBJECTS,
    VIEWS,
    N,
    pixels,
    same,
    write_boards,
)

ARCHIVES = {
    "stacked": {"object_points": OBJECTS, "image_points": IMAGES},
    "OpenCV's shape": {"objpoints": OBJECTS, "imgpoints": IMAGES[:, :, None]},
    "one target for all": {"objp": BOARD.points(), "corners": IMAGES},
    "flat target": {"worldPoints": BOARD.points()[:, :2], "imagePoints": IMAGES},
    "by view": {f"obj_pts_{v}": OBJECTS[v] for v in range(VIEWS)}
    | {f"img_pts_{v}": IMAGES[v] for v in range(VIEWS)},
    "one target, by view": {"objp": BOARD.points()}
    | {f"imgpoints_{v}": IMAGES[v][:, None] for v in range(VIEWS)},
    "camcal's": {"target_points": BOARD.points(), "num_frames": np.array(VIEWS)}
    | {f"frame_{v}_detections": IMAGES[v] for v in range(VIEWS)}
    | {f"frame_{v}_indices": np.arange(N, dtype=np.int32) for v in range(VIEWS)},
}


@pytest.mark.parametrize("arrays", ARCHIVES.values(), ids=ARCHIVES)
def test_numpy_archives(tmp_path: Path, arrays: dict[str, np.ndarray]) -> None:
    np.savez_compressed(
        tmp_path / "v.npz", **arrays, image_size=np.array([640, 480]), note="made up"
    )
    found = bc.load_views(tmp_path / "v.npz")
    same(found)
    assert (found.width, found.height) == (640, 480)
    assert view_notes(found) == []


def test_ten_views_stay_in_order(tmp_path: Path) -> None:
    arrays = {f"imgpoints_{v}": pixels(v) for v in range(12)}
    np.savez(tmp_path / "v.npz", objpoints=BOARD.points(), **arrays)
    found = bc.load_views(tmp_path / "v.npz")
    assert found.names == tuple(str(v) for v in range(12))
    np.testing.assert_allclose(found.pixels[found.slices[10]], pixels(10))


def test_missing_points_are_left_out_and_said(tmp_path: Path) -> None:
    images, keep = IMAGES.copy(), np.ones((VIEWS, N), dtype=bool)
    keep[1, [0, 7]] = False
    keep[2, 3:] = False
    images[~keep] = np.nan
    np.savez(tmp_path / "v.npz", objpoints=OBJECTS, imgpoints=images, image_shape=(480, 640, 3))
    found = bc.load_views(tmp_path / "v.npz")
    keep[2] = False  # three points make no view
    same(found, keep)
    assert (found.width, found.height) == (640, 480)
    assert found.notes[0] == "2 of 40 points are missing in their views"
    assert found.notes[1].startswith("1 view with fewer than 4 points left out (the first: 3)")


def test_pixels_alone_need_a_board(tmp_path: Path) -> None:
    np.savez(tmp_path / "v.npz", imgpoints=IMAGES)
    same(bc.load_views(tmp_path / "v.npz", board="5x4", square=2))
    with pytest.raises(bc.InputError, match="say what they are of, such as --board 9x6"):
        bc.load_views(tmp_path / "v.npz")
    with pytest.raises(bc.InputError, match="54 target points and 20 pixels"):
        bc.load_views(tmp_path / "v.npz", board="9x6")


def test_bouguets_toolbox(tmp_path: Path) -> None:
    """X_k (3, n), x_k (2, n), pixels from 0; an image put aside; one that was never clicked."""
    variables = {"nx": 640.0, "ny": 480.0, "n_ima": 5.0, "active_images": np.array([1, 1, 1, 0, 1])}
    for v in range(4):
        variables[f"X_{v + 1}"] = BOARD.points().T
        variables[f"x_{v + 1}"] = pixels(v).T
    variables["X_5"] = variables["x_5"] = np.array([[np.nan]])
    for compress in (False, True):
        savemat(tmp_path / "c.mat", variables, do_compression=compress)
        found = bc.load_views(tmp_path / "c.mat")
        same(found)
        assert (found.names, found.width, found.height) == (("1", "2", "3"), 640, 480)
        assert found.notes == ("1 view put aside in the toolbox left out",)


def test_matlabs_toolbox_counts_from_one(tmp_path: Path) -> None:
    images = np.moveaxis(IMAGES + 1.0, 0, 2)
    images[4, :, 1] = np.nan
    variables = {"imagePoints": images, "worldPoints": BOARD.points()[:, :2]}
    savemat(tmp_path / "m.mat", {**variables, "imageSize": np.array([480.0, 640.0])})
    keep = np.ones((VIEWS, N), dtype=bool)
    keep[1, 4] = False
    found = bc.load_views(tmp_path / "m.mat")
    same(found, keep)
    assert (found.width, found.height) == (640, 480)
    assert "counted from 1" in found.notes[0]


def test_boards_of_tags(tmp_path: Path) -> None:
    write_boards(tmp_path)
    found = bc.load_views(tmp_path / "corners")
    assert found.names == ("im0", "im1", "im2")
    assert (found.width, found.height) == (640, 480)
    flat = BOARD.points()
    upright = np.column_stack([50 - flat[:, 2], flat[:, 1], flat[:, 0] + 7])
    np.testing.assert_allclose(found.world[:40], np.concatenate([flat, upright]), atol=1e-12)
    np.testing.assert_allclose(found.pixels[20:40], IMAGES[0] + [27, 0])
    assert not found.planar
    assert len(bc.load_views(tmp_path / "corners" / "im1.orpc")) == 1
    named = bc.load_views(tmp_path / "corners", board=str(tmp_path / "b.dsc"))
    assert named.sha256 == found.sha256


def test_boards_that_nothing_places(tmp_path: Path) -> None:
    write_boards(tmp_path, tp=False)
    with pytest.raises(bc.InputError, match="nothing places its boards"):
        bc.load_views(tmp_path / "corners")
    (tmp_path / "b.tp").write_text("0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n")
    found = bc.load_views(tmp_path / "corners")
    same(found)
    assert found.notes[1] == "60 points on boards that nothing places left out"


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("corners/im0.orpc", "num_corners: 40", "num_corners: 41", "says 41 corners and has 40"),
        ("corners/im0.orpc", "width: 640", "width: 600", "is of an image of 600 by 480 px"),
        ("corners/im0.orpc", "\n0,0,1,", "\n0,99,1,", "im0.orpc:6: board 0 has no point 99"),
        ("corners/im0.orpc", "\n0,0,1,", "\n0,x,1,", "im0.orpc:6: .* where numbers should be"),
        ("corners/im0.orpc", "height", "depth", "does not begin with width, height"),
        ("b.tp", "1 0 0 0", "2 0 0 0", "board 0 is placed by no rotation"),
        ("b.tp", "3\n", "", "must have 13 numbers for each board"),
        ("b.dsc", "3,5,6", "0,5,6", "b.dsc:23: board 0 stands twice"),
        ("b.dsc", "0,5,6,20.0", "", "b.dsc:3: .* is neither a board nor a point of one"),
    ],
)
def test_bad_boards_of_tags(tmp_path: Path, name: str, old: str, new: str, message: str) -> None:
    write_boards(tmp_path)
    path = tmp_path / name
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(bc.InputError, match=re.compile(message)):
        bc.load_views(tmp_path / "corners")


def test_what_does_not_go_together(tmp_path: Path) -> None:
    np.savez(tmp_path / "v.npz", objpoints=OBJECTS, imgpoints=IMAGES)
    for options, message in (
        ({"board": "5x4"}, "states the target's points itself; leave --board out"),
        ({"square": 2.0}, "the square's side needs a board"),
        ({"columns": "r=u"}, "is a NumPy archive, whose columns are known"),
        ({"only": "x*"}, "no view is called 'x\\*'; there are '1, 2, 3'"),
        ({"board": 5}, "board must be such as '9x6', not int"),
        ({"board": "5x4", "square": "2"}, "the square's side must be a number, not '2'"),
        ({"board": "b.dsc"}, "describes boards of .orpc files"),
    ):
        with pytest.raises(bc.InputError, match=re.compile(message)):
            bc.load_views(tmp_path / "v.npz", **options)
    with pytest.raises(bc.InputError, match="is a folder without"):
        bc.load_views(tmp_path)
    with pytest.raises(bc.InputError, match="must be a file or a data frame, not ndarray"):
        bc.load_views(IMAGES)


def test_some_views_of_a_file(tmp_path: Path) -> None:
    np.savez(tmp_path / "v.npz", objpoints=OBJECTS, imgpoints=IMAGES)
    found = bc.load_views(tmp_path / "v.npz", only="[13]")
    assert found.names == ("1", "3")
    assert found.notes == ("2 of 3 views kept, called [13]",)


def test_data_frames_and_workbooks(tmp_path: Path) -> None:
    import pandas as pd

    rows = np.concatenate([OBJECTS, IMAGES], axis=2).reshape(-1, 5)
    frame = pd.DataFrame(rows, columns=["X", "Y", "Z", "u", "v"])
    frame.insert(0, "image", np.repeat(["a", "b", "c"], N))
    for found in (bc.load_views(frame), _through_excel(frame, tmp_path / "v.xlsx")):
        same(found)
        assert found.names == ("a", "b", "c")
        assert "image as view" in found.notes[0]


def _through_excel(frame, path: Path) -> Views:
    frame.to_excel(path, index=False)
    return bc.load_views(path)
