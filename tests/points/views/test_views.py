"""Views of a target: what identifies a point, and what no set of views can be.

Truth: a board whose points are known, written by hand.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import bayescal as bc
from bayescal.points.views.board import Board, board_named
from bayescal.points.views.notes import view_notes
from bayescal.points.views.views import Views
from bayescal.points.views.writer import views_to_csv

BOARD = Board(4, 3, 10.0)


def picture(world: np.ndarray, turn: float = 0.0, shift: float = 0.0) -> np.ndarray:
    """Pixels of a flat target under some perspective, on an image of 640 by 480."""
    x, y = world[:, 0], world[:, 1]
    depth = 1 + 0.003 * x + 0.002 * y
    r, c = (x * np.cos(turn) - y * np.sin(turn)), (x * np.sin(turn) + y * np.cos(turn))
    return np.column_stack([200 + shift + 5 * r / depth, 150 + 5 * c / depth])


def views(n: int = 3, board: Board = BOARD, **options: object) -> Views:
    world = [board.points()] * n
    pixels = [picture(w, 0.1 * i, i) for i, w in enumerate(world)]
    return Views.from_arrays(world, pixels, **{"width": 640, "height": 480, **options})


def test_a_board_is_known_again_in_every_view() -> None:
    found = views(3)
    assert len(found) == 3
    assert found.n_points == 36
    assert found.target.shape == (12, 3)
    np.testing.assert_array_equal(found.target[found.corner], found.world)
    np.testing.assert_array_equal(found.target, BOARD.points())  # sorted by z, y, x
    np.testing.assert_array_equal(found.counts, [12, 12, 12])
    np.testing.assert_array_equal(found.extent, [30, 20, 0])
    assert found.diagonal == pytest.approx(np.hypot(30, 20), rel=1e-15)
    assert found.planar
    assert view_notes(found) == []


def test_rounding_and_minus_zero_make_no_new_point() -> None:
    one = np.array([[0.0, 0, 0], [0.1 + 0.2, 0, 0], [0, 0.3, 0], [0.3, 0.3, 0]])
    other = np.array([[-0.0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0.3, 0.3, 0]])
    found = Views.from_arrays([one, other], [picture(100 * one), picture(100 * other)])
    assert len(found.target) == 4


def test_points_that_differ_are_told_apart() -> None:
    near = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 1, 1e-6]])
    assert len(Views.from_arrays([near], [picture(near) + near[:, 2:]]).target) == 5


def test_a_body_is_not_planar_and_a_tilted_board_is() -> None:
    box = np.array(list(itertools.product([0.0, 1], [0, 1], [0, 1])))
    pixels = np.column_stack([box[:, 0] * 9 + box[:, 2], box[:, 1] * 9 - box[:, 2]])
    assert not Views.from_arrays([box], [pixels]).planar
    flat = BOARD.points()
    tilted = flat + np.column_stack([np.zeros((12, 2)), 0.3 * flat[:, 0] + 2])
    assert Views.from_arrays([tilted], [picture(flat)]).planar


def test_interleaved_rows_are_put_in_order_of_their_views() -> None:
    world = np.repeat(BOARD.points(), 2, axis=0)
    pixels = picture(world) + np.tile([[0.0, 0.0], [1.0, 0.0]], (12, 1))
    found = Views.from_rows(["b", "a"] * 12, world, pixels, labels=[f"p{i}" for i in range(24)])
    assert found.names == ("b", "a")
    np.testing.assert_array_equal(found.view, np.repeat([0, 1], 12))
    np.testing.assert_array_equal(found.pixels[found.slices[1]], pixels[1::2])
    assert found.labels is not None
    assert found.labels[12] == "p1"


def test_selected_views_keep_the_target() -> None:
    found = views(3)
    some = found.select([2, 0])
    assert some.names == ("3", "1")
    np.testing.assert_array_equal(some.pixels[:12], found.pixels[24:])
    np.testing.assert_array_equal(some.target[some.corner], some.world)
    assert some.target is found.target
    assert some.sha256 != found.sha256 != found.select([0, 1, 2]).sha256


def test_round_trip(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    given = views(2, names=["#1, left", "right"], sigma=rng.uniform(0.1, 1, (2, 12, 2)))
    bc.save_views(given, tmp_path / "v.csv", comments=["made\nup"])
    back = bc.load_views(tmp_path / "v.csv")
    for name in ("view", "world", "pixels", "target", "corner", "sigma"):
        np.testing.assert_array_equal(getattr(back, name), getattr(given, name))
    assert (back.names, back.width, back.height) == (given.names, 640, 480)
    assert back.lines == tuple(range(4, 28))
    assert not back.relative_sigma


def test_relative_deviations_stay_relative(tmp_path: Path) -> None:
    w = BOARD.points()
    given = Views.from_rows(["1"] * 12, w, picture(w), sigma=np.ones((12, 2)), relative_sigma=True)
    bc.save_views(given, tmp_path / "v.csv")
    assert bc.load_views(tmp_path / "v.csv").relative_sigma


def written(folder: Path, text: str) -> Path:
    path = folder / "v.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_image_size_is_the_options_the_setups_the_files(tmp_path: Path) -> None:
    path = tmp_path / "v.csv"
    bc.save_views(views(2, width=None, height=None), path)
    assert bc.load_views(path).width is None
    assert view_notes(bc.load_views(path)) == []
    sized = bc.load_views(path, setup=bc.Setup(width=1000, height=700))
    assert (sized.width, sized.height, sized.notes) == (1000, 700, ())
    bc.save_views(views(2), path, force=True)
    larger = bc.load_views(path, width=1280, height=960)
    assert (larger.width, larger.height) == (1280, 960)
    assert "not 640 by 480 as in the file" in larger.notes[0]


def test_image_size_in_columns(tmp_path: Path) -> None:
    lines = views_to_csv(views(1, width=None, height=None)).splitlines()
    text = "\n".join([lines[0] + ",width,height", *(row + ",640,480" for row in lines[1:])])
    found = bc.load_views(written(tmp_path, text))
    assert (found.width, found.height) == (640, 480)
    with pytest.raises(bc.InputError, match=r"v\.csv:13: view '1' is of an image of 1280 by 480"):
        bc.load_views(written(tmp_path, text[: -len("640,480")] + "1280,480"))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda t: t.replace("view,", "shot,"),
            r":2: no column 'view' among 'shot,x,y,z,r,c'; name",
        ),
        (lambda t: "\n".join(t.splitlines()[:5]), r":3: view '1' has 3 points; a pose takes"),
        (lambda t: t + t.splitlines()[2] + "\n", r":39: view '1' has the point \(0, 0, 0\) twice"),
        (lambda t: t.replace("\n1,0,0,0,200", "\n1,0,0,0,nan"), r":3: r: is nan; every point"),
        (lambda t: t.replace("\n1,0,0,0,200", "\n1,0,0,0,2000"), r":3: r = 2000, c = 150 is far"),
        (lambda t: t.replace("\n1,0,0,0,200", "\n,0,0,0,200"), r":3: view is empty"),
        (lambda t: t.replace("# image: 640 x 480", "# image: 250 x 180"), r"off an image of 250"),
        (lambda t: "\n".join(t.splitlines()[:2]), r"no points below the header"),
        (lambda _: "", r"is empty; the first line must name the columns view,x,y,z,r,c"),
    ],
)
def test_bad_tables_are_one_line(tmp_path: Path, edit, message: str) -> None:
    path = written(tmp_path, edit(views_to_csv(views(3))))
    with pytest.raises(bc.InputError, match=message) as caught:
        bc.load_views(path)
    assert "\n" not in str(caught.value)


def test_lone_columns_are_refused(tmp_path: Path) -> None:
    lines = views_to_csv(views(1)).splitlines()
    for column in ("sigma_r", "width"):
        text = "\n".join([f"{lines[1]},{column}", *(row + ",640" for row in lines[2:])])
        with pytest.raises(bc.InputError, match=f"{column} alone; give both"):
            bc.load_views(written(tmp_path, text))


def test_two_boards_are_refused() -> None:
    """Boards of 25 and 30 share the points (0, 0) and (150, 0), and nothing else."""
    boards = [Board(9, 6, 25.0).points(), Board(9, 6, 30.0).points()]
    pixels = [picture(b) / 4 + 10 for b in boards]
    with pytest.raises(bc.InputError, match="views '1' and '2' show different targets"):
        Views.from_arrays(boards, pixels)


def test_parts_of_one_board_are_one_target() -> None:
    """Negative control: halves that share no corner, with and without a view that joins them."""
    w = Board(8, 4).points()
    left, right = w[w[:, 0] < 4], w[w[:, 0] >= 4]
    assert len(Views.from_arrays([left, right], [picture(left), picture(right)]).target) == 32
    third = [left, right, w]
    assert len(Views.from_arrays(third, [picture(v) for v in third]).target) == 32


def test_faces_of_a_body_are_one_target() -> None:
    face = Board(4, 4).points()
    side = face[:, [2, 0, 1]]
    assert not Views.from_arrays([face, side], [picture(face), picture(face)]).planar


def test_a_line_of_points_is_refused() -> None:
    line = np.column_stack([np.arange(5.0), np.zeros((5, 2))])
    with pytest.raises(bc.InputError, match="lie on one line of the target"):
        Views.from_arrays([line], [picture(Board(5, 2).points()[[0, 1, 2, 7, 4]])])


def test_wrong_shapes_are_refused() -> None:
    w = BOARD.points()
    for world, pixels, message in (
        ([w], [picture(w)[:5]], "view 1: 12 points in world and 5 in pixels"),
        ([w[:, :2]], [picture(w)], r"view 1: world must have shape \(n, 3\), not \(12, 2\)"),
        ([w, w], [picture(w)], "world has 2 views and pixels 1"),
        ([], [], "there are no points"),
        ([w], [picture(w) * np.nan], "pixels holds a number that is NaN"),
        (None, None, "must be lists of arrays, one of each per view"),
        ([w], ["abc"], "view 1: pixels must be an array of numbers"),
        ([w], [[[1.0], [2.0, 3.0]]], "view 1: pixels must be an array of numbers"),
    ):
        with pytest.raises(bc.InputError, match=message):
            Views.from_arrays(world, pixels)
    for width in (640.5, np.nan, -1, "640"):
        with pytest.raises(bc.InputError, match="image width must be a"):
            views(1, width=width)
    with pytest.raises(bc.InputError, match="no view is selected"):
        views(2).select([])


def test_opencvs_shapes_are_taken() -> None:
    w = BOARD.points()
    found = Views.from_arrays([w[:, None]], [picture(w)[None].astype(np.float32)])
    assert found.pixels.shape == (12, 2)


def test_odd_views_are_noted() -> None:
    w = BOARD.points()
    order = np.random.default_rng(2).permutation(12)
    mirrored = w * [-1, 1, 1] + [30, 0, 0]
    pixels = [picture(w), picture(w, 0.2), picture(mirrored, 0.1), picture(w, 0.3)[order]]
    pixels.append(pixels[0])
    notes = view_notes(Views.from_arrays([w] * 5, pixels, width=640, height=480))
    assert any("view 4 looks like no picture of a flat target" in n for n in notes)
    assert any("view 3 shows the target mirrored" in n for n in notes)
    assert any("view 5 repeats view 1 exactly" in n for n in notes)
    one = view_notes(views(1))
    assert len(one) == 1
    assert "one view only" in one[0]


def test_points_off_the_image_are_noted() -> None:
    pixels = [picture(BOARD.points()), picture(BOARD.points(), 0.1)]
    pixels[1][3] = [-4, 10]
    notes = view_notes(Views.from_arrays([BOARD.points()] * 2, pixels, width=640, height=480))
    assert any(
        "1 of 24 points lies off the image (the first at arrays, view 2, point 4" in n
        for n in notes
    )


def test_boards() -> None:
    assert board_named("9x6", 25.0) == Board(9, 6, 25.0)
    np.testing.assert_array_equal(
        Board(3, 2, 2.0).points()[:4, :2], [[0, 0], [2, 0], [4, 0], [0, 2]]
    )
    for text in ("9", "9x", "axb", "9x6x2", "1x6", "99999x99999", "٩x٦"):
        with pytest.raises(bc.InputError, match="board"):
            board_named(text)
    with pytest.raises(bc.InputError, match="square"):
        Board(9, 6, float("nan"))


def test_representation() -> None:
    assert repr(views(3)) == (
        "<Views: 3 views, 36 points of a planar target 30 by 20, image 640 by 480 px, from arrays>"
    )


def test_views_and_points_are_left_out_by_name() -> None:
    views = bc.chessboard()
    found = views.without("left03.jpg", "left05.jpg:21", "left05.jpg:1")
    assert found.names == tuple(n for n in views.names if n != "left03.jpg")
    gone = [views.slices[views.names.index("left05.jpg")].start + k for k in (0, 20)]
    kept = [i for i in range(views.n_points) if views.view[i] != 2 and i not in gone]
    assert found.pixels.tolist() == views.pixels[kept].tolist()
    assert found.lines == tuple(views.lines[i] for i in kept)
    assert found.target.tolist() == views.target.tolist()
    assert found.sha256 != views.sha256
    assert found.notes[-1].startswith("left out as asked (56 points): left03.jpg, left05.jpg:21")
    assert views.without() is views


def test_points_are_left_out_by_label_where_they_have_one() -> None:
    views = bc.load_views(pd.DataFrame({
        "view": ["a:1"] * 5 + ["b"] * 5, "label": [*"pqrst"] * 2, "x": [0, 1, 0, 1, 2] * 2,
        "y": [0, 0, 1, 1, 2] * 2, "z": 0.0, "r": np.arange(10.0) ** 2, "c": np.arange(10.0),
    }))  # fmt: skip
    assert views.without("a:1:r").labels == (*"pqst", *"pqrst")
    assert views.without("a:1").names == ("b",)
    for name, what in (("b:3", "'b' has no point '3'"), ("c", "no view is called 'c'")):
        with pytest.raises(bc.InputError, match=what):
            views.without(name)
    with pytest.raises(bc.InputError, match="no point is left"):
        views.without("a:1", "b")
    with pytest.raises(bc.InputError, match="has 3 points"):
        views.without("b:p", "b:q")
