"""A real Dask cluster, and a fleet of simulated cameras."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.points.heading import Heading
from bayescal.points.setup_file import to_toml
from bayescal.simulation import simulate
from tests.helpers.command import environment

OPTIONS = {"orders": [1, 2], "axis": "c", "ess": 100, "hint": False}


@dataclass(frozen=True)
class Cluster:
    """A scheduler's address, and its worker processes."""

    address: str
    workers: list[subprocess.Popen[bytes]]


@pytest.fixture(scope="session")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler and two workers, each a process without a nanny: what is killed stays dead."""
    from distributed import Client

    folder = tmp_path_factory.mktemp("dask")
    where = folder / "scheduler.json"
    given = [f"--scheduler-file={where}", "--no-dashboard"]
    variables = environment(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

    def start(*words: str) -> subprocess.Popen[bytes]:
        with (folder / "log").open("ab") as log:
            command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
            return subprocess.Popen(command, cwd=folder, env=variables, stdout=log, stderr=log)

    processes = [start("dask_scheduler", "--port=0", "--host=127.0.0.1", *given)]
    options = ["--no-nanny", "--nthreads=1", "--local-directory", str(folder), *given]
    try:
        processes += [start("dask_worker", *options) for _ in range(2)]
        with Client(scheduler_file=str(where), timeout=60, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        yield Cluster(address, processes[1:])
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


@pytest.fixture(scope="session")
def cameras() -> dict[str, bc.Correspondences]:
    """Twelve cameras alike, but that one is stretched and one is noisy."""
    found = {}
    for i in range(12):
        rng = np.random.default_rng([7, i])
        sigma = 5.0 if i == 4 else 1.0
        beta = np.array([540.0, 1300.0]) + rng.standard_normal(2) * [4, 8] + [0, 200 * (i == 2)]
        coefficients = {"r": [960.0, 1300.0], "c": beta.tolist()}
        points, _ = simulate({"r": 1, "c": 1}, sigma, rng, n=20, coefficients=coefficients)
        found[f"camera {i:02d}"] = points
    return found


@pytest.fixture
def files(cameras: dict[str, bc.Correspondences], tmp_path: Path) -> Path:
    """Four cameras' files, a setup, and a file that is none."""
    (tmp_path / "cameras").mkdir()
    for name, points in list(cameras.items())[:4]:
        bc.save(points, tmp_path / "cameras" / f"{name}.csv")
    (tmp_path / "setup.toml").write_text(to_toml(replace(points.setup, heading=Heading("Line 3"))))
    (tmp_path / "cameras" / "bad.csv").write_text("x,y,z,r,c\n1,2,3,4\n")
    return tmp_path
