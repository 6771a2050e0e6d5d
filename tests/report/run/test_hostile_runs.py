"""Files of a run that never end, are no files, or hold nothing: one line each, and soon.

Truth: the file named, and that what is read is bounded.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

import bayescal as bc
from bayescal.report.run import bounded
from tests.helpers.command import here
from tests.helpers.spoilt import forge

FILES = ("result.json", "run.json", "points.csv", "setup.toml", "derived.npz", "draws/r-order-1.nc")


@pytest.fixture
def copy(run: Path, tmp_path: Path) -> Path:
    """A run to spoil."""
    return Path(shutil.copytree(run, tmp_path / "run"))


def refused(folder: Path) -> str:
    with pytest.raises(bc.InputError) as caught:
        bc.open_run(folder)
    said = str(caught.value)
    assert "\n" not in said
    assert said.startswith(str(folder))
    return said


@pytest.mark.parametrize("name", FILES)
def test_a_device_and_a_pipe_are_not_read(name: str, copy: Path) -> None:
    path = copy / name
    path.unlink()
    path.symlink_to("/dev/zero")
    refused(copy)
    path.unlink()
    os.mkfifo(path)
    refused(copy)


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_a_terabyte_is_not_read(
    name: str, copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounded, "LARGEST", 20_000_000)
    with (copy / name).open("wb") as file:
        file.truncate(10**12)
    assert f"{name}: holds more than 0.02 GB, the most that is read" in refused(copy)


def test_an_empty_file_is_damaged(copy: Path) -> None:
    (copy / "derived.npz").write_bytes(b"")
    forge(copy, "derived.npz")
    assert "derived.npz: " in refused(copy)


def test_a_camera_without_end_is_not_read(copy: Path, tmp_path: Path) -> None:
    (copy / "camera.npz").unlink()
    (copy / "camera.npz").symlink_to("/dev/zero")
    points = tmp_path / "points.csv"
    points.write_text("x,y,z\n100,50,300\n")
    done = here("predict", copy, points)  # made anew of the run's draws
    assert done.code in (0, 2)
    assert "Traceback" not in done.err
