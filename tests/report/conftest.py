from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.helpers.command import here


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the thesis, as the command writes it."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    done = here("compare", "--orders", "1-2", "--out", folder, "--quiet")
    assert done == (0, "", "")
    return folder


FAMILIES = (
    *("compare", "--family", "separable,pinhole", "--position", "stated,free"),
    *("--orders", "1-2", "--radial-orders", "0", "--tau", "0.05", "--ess", "100"),
)


@pytest.fixture(scope="session")
def families_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of families of the thesis: closed forms, weighted draws and sampled models."""
    folder = tmp_path_factory.mktemp("families") / "run"
    done = here(*FAMILIES, "--out", folder, "--quiet")
    assert done == (0, "", "")
    return folder


@pytest.fixture
def families_copy(families_run: Path, tmp_path: Path) -> Path:
    """A run of families to spoil."""
    return Path(shutil.copytree(families_run, tmp_path / "run"))
