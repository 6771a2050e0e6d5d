"""What is found of a target in a photograph.

Truth: photographs rendered by a known homography, so that every point's place is known.
Tolerance: corners at the noise and sharpness of these pictures are found to 0.03 px by
cornerSubPix (the windows hold some 200 pixels with a slope across two edges); a systematic
half-pixel origin or a swapped order would be ten times that and more.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest

import bayescal as bc
from bayescal.detection.charuco import Charuco
from bayescal.detection.chessboard import Chessboard
from bayescal.detection.circles import Circles
from bayescal.detection.opencv import pixels_of
from bayescal.detection.pattern import Sighting
from bayescal.points.views.board import Board
from tests.helpers.renders import chessboard_texture, homography, photograph, seen_at, to_units

TILTS = ((0.0, 0.0), (0.02, -0.01), (-0.015, 0.02))


def errors(found: Sighting | None, target: np.ndarray, side: float, shown) -> np.ndarray:
    assert found is not None
    return found.pixels - seen_at(target[found.points] / side, shown)


@pytest.mark.parametrize("turn", [0.3, -0.4, np.pi + 0.2, np.pi / 2, 4.5])
def test_chessboard(turn: float) -> None:
    """The same corner is first however the board is turned, and every one at its place."""
    rng = np.random.default_rng(1)
    pattern = Chessboard(Board(9, 6, 25.0))
    texture, units = chessboard_texture(9, 6, 40)
    found = []
    for tilt in TILTS:
        shown = homography(32.0, turn, tilt, middle=(4.0, 2.5))
        image = photograph(texture, units, shown, rng)
        found.append(errors(pattern.find(image), pattern.target(), 25.0, shown))
    rest = np.concatenate(found)
    assert np.sqrt((rest**2).mean()) < 0.04
    # 162 corners that share no direction of error: a common offset is that of the origin.
    assert np.abs(rest.mean(axis=0)).max() < 0.02


def test_chessboard_whose_ends_look_alike() -> None:
    assert "turned by half" in Chessboard(Board(8, 6)).caution
    assert Chessboard(Board(9, 6)).caution == ""
    with pytest.raises(bc.InputError, match="3x3"):
        Chessboard(Board(9, 2))


def test_nothing_is_found_where_nothing_is() -> None:
    rng = np.random.default_rng(2)
    noise = rng.integers(0, 255, (240, 320), dtype=np.uint8)
    texture, units = chessboard_texture(9, 6, 40)
    board = photograph(texture, units, homography(30.0, middle=(4.0, 2.5)), rng)
    assert Chessboard(Board(9, 6)).find(noise) is None
    assert Chessboard(Board(7, 7)).find(board) is None
    assert Circles(Board(4, 4)).find(noise) is None
    assert Charuco(Board(4, 6), 0.7, "4x4_50").find(noise) is None


def charuco_picture(pattern: Charuco, shown: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    px = 60
    columns, rows = pattern.board.columns + 1, pattern.board.rows + 1
    texture = pattern._made().generateImage((columns * px, rows * px), marginSize=0)
    texture = cv2.copyMakeBorder(texture, px, px, px, px, cv2.BORDER_CONSTANT, value=255)
    return photograph(texture, to_units(px, 1, 1), shown, rng)


@pytest.mark.parametrize("legacy", [False, True])
def test_charuco(legacy: bool) -> None:
    """Corners are those that the markers say, also where a part of the board is out of sight."""
    rng = np.random.default_rng(3)
    pattern = Charuco(Board(4, 5, 30.0), 22.0, "4x4_50", legacy)
    for at, fewest in (((320.0, 240.0), 20), ((320.0, 20.0), 6)):
        shown = homography(60.0, 0.2, (0.0005, -0.0004), at, middle=(2.5, 3.0))
        found = pattern.find(charuco_picture(pattern, shown, rng))
        rest = errors(found, pattern.target(), 30.0, shown)
        assert len(rest) >= fewest
        assert np.abs(rest).max() < 0.25
        assert len(rest) == 20 or fewest < 20


def test_charuco_is_asked_for_by_names_that_opencv_has() -> None:
    with pytest.raises(bc.InputError, match="'9x9_1' is no dictionary of OpenCV's; it has 4X4_100"):
        Charuco(Board(4, 6), 0.7, "9x9_1").target()
    with pytest.raises(bc.InputError, match="4X4_50 has 50 markers and this board 220"):
        Charuco(Board(20, 20), 0.7, "DICT_4X4_50").target()
    with pytest.raises(bc.InputError, match="marker's side must be above 0 and below"):
        Charuco(Board(4, 6), 1.0, "4x4_50")


@pytest.mark.parametrize("asymmetric", [False, True])
def test_circles(asymmetric: bool) -> None:
    """Centres of small circles seen nearly straight: their pictures' middles are theirs."""
    rng = np.random.default_rng(4)
    board = Board(4, 11, 10.0) if asymmetric else Board(7, 5, 10.0)
    pattern = Circles(board, asymmetric)
    places, px = pattern.target()[:, :2] / 10.0, 40
    extent = np.ceil(places.max(axis=0)).astype(int)
    texture = np.full(tuple(((extent + 4) * px)[::-1].tolist()), 255, dtype=np.uint8)
    for x, y in ((places + 2) * px - 0.5) * 16:
        radius = round(0.3 * px * 16)
        cv2.circle(texture, (round(x), round(y)), radius, 0, -1, cv2.LINE_AA, shift=4)
    shown = homography(36.0, 0.1, (0.0005, 0.0003), middle=(extent[0] / 2, extent[1] / 2))
    found = pattern.find(photograph(texture, to_units(px, 2, 2), shown, rng))
    rest = errors(found, pattern.target(), 10.0, shown)
    assert len(rest) == board.n_points
    assert np.abs(rest).max() < 0.2


def test_shapes_of_opencv_4_and_5() -> None:
    corners = np.arange(8.0, dtype=np.float32).reshape(4, 2)
    np.testing.assert_array_equal(pixels_of(corners[:, None]), corners)
    np.testing.assert_array_equal(pixels_of(corners), corners)
