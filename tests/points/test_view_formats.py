"""Files of views that other tools write.

Truth: views written by hand in each tool's documented form; NumPy's and scipy's own writers for
their archives. (The readers were also tried on files of the tools themselves: docs/views.md.)
"""

from __future__ import annotations

import base64
import io
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import bayescal as bc
from bayescal.points.views.board import Board
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views

BOARD = Board(5, 4, 2.0)
N, VIEWS = BOARD.n_points, 3


def pixels(view: int) -> np.ndarray:
    x, y, _ = BOARD.points().T
    depth = 1 + 0.02 * view * x + 0.01 * y
    return np.column_stack([100 + 20 * x / depth + view, 80 + 20 * y / depth + 0.25 * view])


IMAGES = np.array([pixels(v) for v in range(VIEWS)])
OBJECTS = np.array([BOARD.points()] * VIEWS)


def same(found: Views, keep: np.ndarray | None = None) -> None:
    """Whether views are those above, of the points kept (all), in that order."""
    kept = np.ones((VIEWS, N), dtype=bool) if keep is None else keep
    np.testing.assert_allclose(found.pixels, IMAGES[kept], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.world, OBJECTS[kept], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(found.view, np.nonzero(kept)[0])


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


def corners_vnl(level: str = "0") -> list[str]:
    lines = ["## generated", "# filename x y level"]
    for v in range(VIEWS):
        lines += [f"im{v}.jpg {r!r} {c!r} {level}" for r, c in IMAGES[v].tolist()]
    return lines


def test_mrcals_corners(tmp_path: Path) -> None:
    lines = [*corners_vnl(), "im9.jpg - - -"]
    lines[4] = "im0.jpg - - -"
    lines[5] = lines[5][:-1] + "2"
    lines[6] = lines[6][:-1] + "-"
    lines[7] = lines[7][:-1] + "-1"
    (tmp_path / "corners.vnl").write_text("\n".join(lines))
    found = bc.load_views(tmp_path / "corners.vnl", board="5x4", square=2, width=640, height=480)
    keep = np.ones((VIEWS, N), dtype=bool)
    keep[0, [2, 4, 5]] = False
    same(found, keep)
    assert found.relative_sigma
    assert found.sigma is not None
    expected = np.ones(found.n_points)
    expected[2] = 4.0  # level 2: weight 2^-2
    np.testing.assert_array_equal(found.sigma, np.column_stack([expected] * 2))
    assert found.notes == (
        "levels say how the points' deviations compare",
        "3 of 60 points are missing in their views",
        "1 view with fewer than 4 points left out (the first: im9.jpg)",
    )


def test_mrcals_corners_of_one_level_or_with_weights(tmp_path: Path) -> None:
    path = tmp_path / "c"
    path.write_text("\n".join(corners_vnl("1")))
    assert bc.load_views(path, board="5x4").sigma is None  # all alike
    lines = corners_vnl("1")
    lines[1], lines[2] = "# filename x y weight", lines[2][:-1] + "0.25"
    path.write_text("\n".join(lines))
    found = bc.load_views(path, board="5x4")
    assert found.sigma is not None
    assert found.sigma[0, 0] == 4.0
    lines[1:] = ["# filename x y", *(line.rsplit(" ", 1)[0] for line in lines[2:])]
    path.write_text("\n".join(lines))
    same(bc.load_views(path, board=BOARD))


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("im0.jpg 1 2 3 4", ":3: has 5 fields"),
        ("im0.jpg a 2 0", ":3: 'a 2 0' where numbers should be"),
        ("im0.jpg 1 2 99", ":3: level 99 is too deep"),
        ("im0.jpg nan 2 0", ":3: is no pixel of any image"),
        ("im8.jpg 1 2 0", "'im0.jpg' has 19 corners and a board of 5x4 20"),
    ],
)
def test_bad_corners_name_their_line(tmp_path: Path, line: str, message: str) -> None:
    lines = corners_vnl()
    lines[2] = line
    (tmp_path / "c.vnl").write_text("\n".join(lines))
    with pytest.raises(bc.InputError, match=re.compile(message)):
        bc.load_views(tmp_path / "c.vnl", board="5x4")


def packed(**arrays: np.ndarray) -> bytes:
    """Arrays as mrcal keeps its optimization inputs: an .npz in base 85."""
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return base64.b85encode(stream.getvalue())


def cameramodel(inputs: bytes | None, camera: int = 0) -> str:
    text = (
        "# generated by hand\n{\n    'lensmodel':  'LENSMODEL_OPENCV4',\n    # fx,fy,cx,cy,...\n"
        "    'intrinsics': [ 500, 500, 320, 240, 0, 0, 0, 0,],\n"
        "    'rt_cam_ref': [ 0, 0, 0, 0, 0, 0,],\n    'imagersize': [ 640, 480,],\n"
    )
    if inputs is not None:
        text += f"    'icam_intrinsics': {camera},\n    'optimization_inputs': {inputs!r},\n"
    return text + "}\n"


def observations() -> dict[str, np.ndarray]:
    board = np.concatenate([IMAGES, np.ones((VIEWS, N, 1))], axis=2).reshape(VIEWS, 4, 5, 3)
    seen = np.concatenate([board, board + np.array([7, 0, 0])])  # a second camera's
    camera = np.repeat([0, 1], VIEWS)
    return {
        "observations_board": seen,
        "indices_frame_camintrinsics_camextrinsics": np.column_stack(
            [np.tile(np.arange(VIEWS), 2), camera, camera - 1]
        ).astype(np.int32),
        "calibration_object_spacing": np.array(2.0),
        "imagersizes": np.array([[640, 480], [800, 600]], dtype=np.int32),
        "lensmodel": np.array("LENSMODEL_OPENCV4"),
        "points": np.array(""),
    }


def test_mrcals_cameramodel(tmp_path: Path) -> None:
    inputs = observations()
    inputs["observations_board"][1, 0, 3, 2] = -1.0  # rejected
    inputs["observations_board"][1, 2, 0] = -1.0  # not seen
    inputs["observations_board"][2, 0, 0, 2] = 0.5
    (tmp_path / "c.cameramodel").write_text(cameramodel(packed(**inputs)))
    found = bc.load_views(tmp_path / "c.cameramodel")
    keep = np.ones((VIEWS, N), dtype=bool)
    keep[1, [3, 10]] = False
    same(found, keep)
    assert (found.width, found.height) == (640, 480)
    assert found.names == ("frame 0", "frame 1", "frame 2")
    assert found.sigma is not None
    np.testing.assert_array_equal(np.unique(found.sigma), [1.0, 2.0])
    assert found.notes[:2] == (
        "1 point that mrcal rejected left out",
        "camera 0 of several; the views of the others left out",
    )
    (tmp_path / "d.txt").write_text(cameramodel(packed(**inputs), camera=1))
    other = bc.load_views(tmp_path / "d.txt")
    np.testing.assert_allclose(other.pixels, IMAGES.reshape(-1, 2) + np.array([7, 0]))
    assert (other.width, other.sigma) == (800, None)


def test_a_cameramodel_without_observations(tmp_path: Path) -> None:
    path = tmp_path / "c.cameramodel"
    path.write_text(cameramodel(None))
    with pytest.raises(bc.InputError, match="a camera without the observations it was made of"):
        bc.load_views(path)
    path.write_text(cameramodel(packed(observations_board=np.zeros((1, 2, 2, 3)))))
    with pytest.raises(bc.InputError, match="its optimization_inputs lack indices_frame"):
        bc.load_views(path)


def write_boards(folder: Path, tp: bool = True) -> None:
    """Two boards at right angles and three images of both, as the Deltille detector has them."""
    (folder / "corners").mkdir()
    lines = []
    for board in (0, 3):
        lines += [f"{board},5,6,20.0", "t25h7,2.0"]
        lines += [f"-1,0,0,{x / 10!r},{y / 10!r},0.0" for x, y, _ in BOARD.points().tolist()]
    (folder / "b.dsc").write_text("\n".join(lines))
    if tp:
        (folder / "b.tp").write_text(
            "#calibration date: today\n0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
            "3\n0 0 -1 50\n0 1 0 0\n1 0 0 7\n"
        )
    for v in range(VIEWS):
        rows = [
            f"{b},{i},1,{r + 9 * b!r},{c!r}"
            for b in (0, 3)
            for i, (r, c) in enumerate(IMAGES[v].tolist())
        ]
        head = [
            f"filename: im{v}.pgm",
            "width: 640",
            "height: 480",
            f"num_corners: {len(rows)}",
            "encoding: ascii",
        ]
        (folder / "corners" / f"im{v}.orpc").write_text("\n".join([*head, *rows]))


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
