"""What the public functions take for points: a file, a data frame, arrays; else one clear line.

Truth: the same comparison from Correspondences.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import bayescal as bc
from bayescal.points.setup_file import to_toml
from bayescal.points.writer import to_csv

POINTS = bc.thesis()
TABLE = np.hstack([POINTS.world, POINTS.pixels])
FRAME = pd.DataFrame(TABLE, columns=["E", "N", "h", "col", "row"])
FAST = {"axis": "r", "ess": 100, "hint": False}


@pytest.fixture(scope="module")
def probability() -> float | None:
    return bc.compare(POINTS, [4, 5], **FAST).axes["r"][4].probability


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("given")
    (made / "points.csv").write_text(to_csv(POINTS))
    (made / "setup.toml").write_text(to_toml(POINTS.setup))
    return made


def test_a_path_a_frame_and_an_array_give_the_same(folder: Path, probability: float | None) -> None:
    for given in (folder / "points.csv", str(folder / "points.csv"), FRAME, TABLE, TABLE.tolist()):
        found = bc.compare(given, [4, 5], setup=folder / "setup.toml", **FAST)
        assert found.axes["r"][4].probability == probability
        assert found.points is not None
        assert found.points.setup == POINTS.setup


def test_a_setup_goes_before_that_of_the_points() -> None:
    wide = bc.Setup(POINTS.setup.position, 4000, 1080, c_from_bottom=True)
    found = bc.fit(POINTS, 1, setup=wide, ess=100)
    assert found.points is not None
    assert found.points.setup == wide


EVERY: list[Callable[[Any], object]] = [
    bc.load,
    bc.compare,
    lambda given: bc.fit(given, 1),
    bc.compare_families,
    lambda given: bc.fit_family(given, "pinhole", (0,)),
    bc.outliers,
    bc.reproduce,
]


@pytest.mark.parametrize("wrong", [5, None, {"x": [1.0]}, ["x", "y"], np.zeros((4, 3)), object()])
@pytest.mark.parametrize("function", EVERY)
def test_what_is_no_points_gets_one_line(function: Callable[[Any], object], wrong: object) -> None:
    with pytest.raises(bc.InputError, match="points must be Correspondences, a file, a data") as e:
        function(wrong)
    assert "\n" not in str(e.value)


def test_a_frame_without_the_columns_says_which() -> None:
    with pytest.raises(bc.InputError, match=r"no column 'r', 'c' among 'E,N,h'"):
        bc.compare(FRAME[["E", "N", "h"]])


def test_correspondences_built_of_columns_are_refused() -> None:
    with pytest.raises(bc.InputError, match=r"build it with bc.load\(...\) or Correspondences"):
        bc.Correspondences(FRAME.E, FRAME.N, FRAME.h, FRAME.col)
    with pytest.raises(bc.InputError, match=r"world \(n, 3\) and pixels \(n, 2\) and n labels"):
        bc.Correspondences(POINTS.pixels, POINTS.world, POINTS.labels)


def test_simulated_points_are_public() -> None:
    points, truth = bc.simulate({"r": 2, "c": 1}, 0.5, np.random.default_rng(1))
    assert len(points) == 57
    assert truth.axes["r"].order == 2


@pytest.mark.parametrize("orders", [["a"], [2.5], 3, None, [[1, 2]]])
def test_orders_that_are_no_whole_numbers_are_refused(orders: object) -> None:
    """2.5 was taken for 2, the others ended in a traceback."""
    with pytest.raises(bc.InputError, match="orders must be whole numbers"):
        bc.compare(bc.thesis(), orders)
