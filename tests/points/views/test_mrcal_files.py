"""Views as mrcal keeps them: corners.vnl, and the observations within a .cameramodel.

Truth: views written by hand in its documented form.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from tests.helpers.view_files import (
    BOARD,
    IMAGES,
    VIEWS,
    N,
    cameramodel,
    corners_vnl,
    observations,
    packed,
    same,
)


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
