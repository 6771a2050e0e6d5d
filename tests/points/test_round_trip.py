"""Writing points and reading them back changes nothing."""

from __future__ import annotations

import dataclasses
import os
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bayescal as bc
from bayescal.errors import OutputError
from bayescal.points.camera import StatedCamera
from bayescal.points.heading import Heading
from bayescal.points.setup import StatedPrior
from bayescal.points.setup_file import to_toml
from bayescal.points.writer import to_csv
from tests.helpers.points_files import rows

COORDINATES = st.floats(min_value=-9e99, max_value=9e99)
PIXELS = st.floats(min_value=-9e8, max_value=9e8)
SIGMAS = st.floats(min_value=1e-6, max_value=1e9)
# Anything at all, and what has a meaning in CSV, to a spreadsheet or to a shell.
LABELS = st.text(st.characters(), max_size=12)
LABELS |= st.sampled_from(['"', '""', ",", "#", "# a", "'", "\t", "\n#", "\r\n", "\\", "-", "nan"])
LABELS |= st.sampled_from(["=1+1", "@a", "\ufeff", "\u2028", "\0", "\ud800", "\x85", "x" * 9000])


@st.composite
def correspondences(draw: st.DrawFn) -> bc.Correspondences:
    n = draw(st.integers(1, 5))

    def some(values: st.SearchStrategy[float]) -> list[float]:
        return draw(st.lists(values, min_size=n, max_size=n))

    names = st.lists(LABELS, min_size=n, max_size=n).map(tuple)
    return bc.Correspondences.from_arrays(
        np.column_stack([some(COORDINATES) for _ in "xyz"]),
        np.column_stack([some(PIXELS) for _ in "rc"]),
        labels=draw(st.none() | names),
        groups=draw(st.none() | names),
        sigma_r=some(SIGMAS) if draw(st.booleans()) else None,
        sigma_c=some(SIGMAS) if draw(st.booleans()) else None,
    )


@given(points=correspondences())
@settings(deadline=None, max_examples=200)
def test_write_then_read_is_the_identity(points: bc.Correspondences) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.csv"
        bc.save(points, path)
        found = bc.load(path)
    # As bytes: -0.0 stays -0.0.
    assert found.world.tobytes() == points.world.tobytes()
    assert found.pixels.tobytes() == points.pixels.tobytes()
    assert found.labels == points.labels
    assert found.groups == points.groups
    assert {a: s.tobytes() for a, s in found.sigma.items()} == {
        a: s.tobytes() for a, s in points.sigma.items()
    }
    assert found.lines == tuple(range(2, len(points) + 2))  # one line per point


NUMBERS = st.tuples(*[COORDINATES] * 3)
PRIORS = st.integers(1, 4).flatmap(
    lambda size: st.builds(
        StatedPrior,
        *(st.lists(v, min_size=size, max_size=size).map(tuple) for v in (PIXELS, SIGMAS)),
    )
)
SD = st.floats(1e-6, 100)
PRINTABLE = st.characters().filter(str.isprintable)
CAMERA = {
    "position_sd": st.none() | st.tuples(SD, SD, SD),
    "orientation": st.none() | NUMBERS,
    "orientation_sd": st.none() | st.tuples(SD, SD, SD),
    "focal": st.none() | SD,
    "focal_log_sd": st.none() | st.floats(1e-6, 10),
    "ratio_log_sd": st.none() | st.floats(1e-6, 10),
    "centre": st.none() | st.tuples(*[COORDINATES] * 2),
    "centre_sd": st.none() | st.tuples(SD, SD),
}
SETUP = {
    "position": NUMBERS,
    "width": st.none() | st.floats(1, 1e9) | st.integers(1, 10**9),
    "height": st.floats(1, 1e9),
    "c_from_bottom": st.booleans(),
    "assumed": st.sets(st.sampled_from(["position", "width", "height", "c_from_bottom"])).map(
        tuple
    ),
    "priors": st.dictionaries(st.sampled_from(["r", "c"]), PRIORS),
    "world_sigma": st.none() | st.tuples(*[st.floats(0, 9e99)] * 3),
    "camera": st.builds(StatedCamera, **CAMERA),
    "heading": st.builds(Heading, *[st.text(PRINTABLE, max_size=9)] * 4),
}


@given(setup=st.builds(bc.Setup, **SETUP))
@settings(deadline=None, max_examples=200)
def test_a_setup_written_and_read_is_the_same(setup: bc.Setup) -> None:
    for kind, strategies in ((bc.Setup, SETUP), (StatedCamera, CAMERA)):
        assert set(strategies) == {
            field.name for field in dataclasses.fields(kind)
        }  # none forgotten
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "setup.toml"
        path.write_text(to_toml(setup), encoding="utf-8")
        found = bc.load_setup(path)
    assert found == setup
    assert repr(found) == repr(setup)  # -0.0 stays -0.0, a float a float


def test_the_thesis_survives_as_a_file(tmp_path: Path) -> None:
    path = tmp_path / "copy.csv"
    bc.save(bc.thesis(), path)
    found = bc.load(path, bc.thesis().setup)
    np.testing.assert_array_equal(found.world, bc.thesis().world)
    np.testing.assert_array_equal(found.pixels, bc.thesis().pixels)
    assert found.labels == bc.thesis().labels
    assert found.setup == bc.thesis().setup


def points() -> bc.Correspondences:
    table = np.array(rows())
    return bc.Correspondences.from_arrays(table[:, :3], table[:, 3:])


def test_a_file_that_exists_is_left_alone_without_force(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("precious")
    with pytest.raises(OutputError, match=r"exists; choose another name or add --force"):
        bc.save(points(), path)
    assert path.read_text() == "precious"
    bc.save(points(), path, force=True)
    assert path.read_text() == to_csv(points())
    assert os.listdir(tmp_path) == ["points.csv"]  # noqa: PTH208 - hidden files too


def test_only_a_regular_file_is_ever_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path, complaint in [
        (pipe, "is not a regular file"),
        (tmp_path, "is a directory"),
        (tmp_path / "none" / "points.csv", "there is no folder"),
        (tmp_path / ("n" * 300), "file name too long"),
    ]:
        with pytest.raises(OutputError, match=complaint):
            bc.save(points(), path, force=True)
    assert pipe.is_fifo()
    assert os.listdir(tmp_path) == ["pipe"]  # noqa: PTH208


def test_a_link_is_written_through_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    for target in ("new.csv", "old.csv"):
        link = tmp_path / f"link to {target}"
        link.symlink_to(tmp_path / "real" / target)
    (tmp_path / "real" / "old.csv").write_text("old")
    bc.save(points(), tmp_path / "link to new.csv")
    bc.save(points(), tmp_path / "link to old.csv", force=True)
    for target in ("new.csv", "old.csv"):
        assert (tmp_path / f"link to {target}").is_symlink()
        assert (tmp_path / "real" / target).read_text() == to_csv(points())


def test_the_longest_name_there_can_be_is_written(tmp_path: Path) -> None:
    path = tmp_path / ("é" * 127)  # 254 bytes; a file system takes 255
    bc.save(points(), path)
    assert path.read_text() == to_csv(points())


def test_new_files_have_the_usual_permissions(tmp_path: Path) -> None:
    bc.save(points(), tmp_path / "points.csv")
    (tmp_path / "usual").touch()
    assert (tmp_path / "points.csv").stat().st_mode == (tmp_path / "usual").stat().st_mode
