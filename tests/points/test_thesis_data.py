"""The bundled thesis data are the numbers of its Appendix A."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc

S = 150
# Appendix A: P1 = [1*S, 130, 2*S] with S1 = [390, 337] is (1, 130, 2, 390, 337), and so on.
APPENDIX_A = [
    (1, 130, 2, 390, 337), (1, 96, 2, 385, 455), (1, 0, 2, 381, 788), (3, 135, 2, 1400, 315),
    (3, 0, 2, 1404, 792), (1, 135, 3, 579, 404), (1, 0, 3, 567, 724), (3, 130, 3, 1266, 418),
    (3, 95, 3, 1265, 499), (3, 0, 3, 1265, 724), (4, 137, 3, 1622, 402), (4, 89, 3, 1622, 514),
    (4, 0, 3, 1626, 727), (2, 137, 4, 937, 450), (2, 89, 4, 936, 533), (2, 0, 4, 936, 675),
    (4, 137, 4, 1462, 449), (4, 89, 4, 1465, 532), (4, 0, 4, 1466, 676), (4, 130, 5, 1367, 488),
    (4, 96, 5, 1368, 534), (4, 0, 5, 1368, 672), (0, 108, 6, 596, 531), (0, 32, 6, 595, 619),
    (1, 108, 6, 773, 530), (1, 32, 6, 773, 619), (2, 108, 6, 947, 532), (2, 32, 6, 947, 619),
    (3, 108, 6, 1124, 531), (3, 32, 6, 1124, 619), (4, 108, 6, 1302, 530), (4, 32, 6, 1301, 619),
    (1, 131, 8, 828, 524), (1, 96, 8, 828, 554), (1, 0, 8, 828, 643), (3, 131, 9, 1078, 532),
    (3, 96, 9, 1079, 559), (3, 0, 9, 1079, 635), (1, 131, 10, 858, 537), (1, 96, 10, 858, 561),
    (1, 0, 10, 857, 631), (4, 137, 10, 1179, 531), (4, 89, 10, 1180, 564), (4, 0, 10, 1190, 635),
    (1, 1 * S, 11, 870, 529), (2, 1 * S, 11, 966, 529), (3, 1 * S, 11, 1065, 529),
    (4, 1 * S, 11, 1163, 529), (1, 2 * S, 11, 870, 431), (2, 2 * S, 11, 967, 431),
    (3, 2 * S, 11, 1064, 431), (4, 2 * S, 11, 1162, 431), (1, 3 * S, 11, 870, 334),
    (2, 3 * S, 11, 967, 334), (3, 3 * S, 11, 1064, 334), (4, 3 * S, 11, 1162, 334),
    (5, 3 * S, 11, 1260, 332),
]  # fmt: skip


def test_points_are_those_of_the_appendix() -> None:
    points = bc.thesis()
    printed = np.array(APPENDIX_A)
    assert printed.shape == (57, 5)  # the text says 50
    np.testing.assert_array_equal(points.world, printed[:, :3] * [S, 1, S])
    np.testing.assert_array_equal(points.pixels, printed[:, 3:])
    assert points.labels == tuple(str(i) for i in range(1, 58))
    assert points.groups is None
    assert points.sigma == {}
    assert points.source == "thesis"


def test_setup_is_that_of_the_listing() -> None:
    setup = bc.thesis().setup
    assert setup.position == (330, 57, 0)  # x = Cdd(:,1)-330; y = Cdd(:,2)-57; z = Cdd(:,3)-0
    assert setup.height == 1080  # c = 1080-R(:,2)
    assert setup.c_from_bottom
    assert setup.width == 1920
    assert setup.assumed == ("width",)  # nowhere stated
    assert setup.priors == {}


def test_pixels_and_camera_frame_follow_the_listing() -> None:
    points = bc.thesis()
    x, y, z, r, row = np.array(APPENDIX_A).T
    np.testing.assert_array_equal(points.pixel("r"), r)
    np.testing.assert_array_equal(points.pixel("c"), 1080 - row)
    np.testing.assert_array_equal(
        points.camera_frame(), np.column_stack([S * x - 330, y - 57, S * z])
    )


def test_points_can_not_be_changed() -> None:
    points = bc.thesis()
    for array in (points.world, points.pixels, points.pixel("r")):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("place", ["/", "somewhere"])
def test_found_from_any_working_directory(place: str, tmp_path: Path) -> None:
    folder = Path(place) if place == "/" else tmp_path / place
    folder.mkdir(exist_ok=True)
    root = Path(bc.__file__).resolve().parents[1]
    found = subprocess.run(
        [sys.executable, "-c", "import bayescal as bc; p = bc.thesis(); print(len(p), p.sha256)"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout.split() == ["57", bc.thesis().sha256]
