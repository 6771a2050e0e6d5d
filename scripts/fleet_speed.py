"""Cameras a second of a fleet on one and two workers against a plain loop; a worker is killed."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
from threadpoolctl import threadpool_limits

import bayescal as bc
from bayescal.api.fleet import judge
from bayescal.fleets.journal import NAME
from bayescal.fleets.judging import digest_of, seed_of
from bayescal.fleets.record import Record
from bayescal.rounding import counted
from bayescal.simulation import simulate

SETTINGS = {"judged by": "compare", "seed": 0}
# Coefficients of r and c, px; which of so many cameras is stretched, which noisy.
CAMERA = {"r": [960.0, 1250.0, 40.0, -90.0], "c": [540.0, 1270.0]}
EVERY, STRETCHED, NOISY = 500, 7, 8
TIMED = 10  # one of so many cameras is judged by the loop and by workers in turn


class Rate(NamedTuple):
    """Seconds until the first camera was done, cameras a second and processor time each since."""

    first: float
    rate: float
    cost: float

    @classmethod
    def of(cls, start: float, done: list[tuple[float, float]]) -> Rate:
        """Of the moments at which cameras were done, and the processor time used until then."""
        (begin, used), (end, spent) = done[0], done[-1]
        n = len(done) - 1
        return cls(begin - start, n / (end - begin), (spent - used) / n)

    def row(self, name: str, plain: Rate) -> str:
        """Line of the table, beside the plain loop."""
        cells = (f"{self.first:.1f}", f"{self.rate:.2f}", f"{self.rate / plain.rate:.2f}")
        return f"| {name} | {' | '.join(cells)} | {self.cost:.3f} | {plain.cost / self.cost:.2f} |"


def cameras(count: int) -> dict[str, bc.Correspondences]:
    """Simulate cameras of 57 points, alike but for a few noisy and a few stretched ones."""
    made = {}
    for i in range(count):
        rng = np.random.default_rng([0, i])
        stretch = (1.2 if i % EVERY == STRETCHED else 1.0) * (1 + 0.01 * rng.standard_normal())
        coefficients = {name: [v * stretch for v in values] for name, values in CAMERA.items()}
        sigma = 5.0 if i % EVERY == NOISY else 1.0
        points, _ = simulate({}, sigma, rng, coefficients=coefficients)
        made[f"camera {i:05d}"] = points
    return made


def moment() -> tuple[float, float]:
    """Wall time, and the processor time of this process and of all it has started."""
    tree = [psutil.Process(), *psutil.Process().children(recursive=True)]
    used = 0.0
    for process in tree:
        with contextlib.suppress(psutil.NoSuchProcess):
            used += sum(process.cpu_times()[:4])  # those of children that ended among them
    return time.perf_counter(), used


def loop(given: dict[str, bc.Correspondences]) -> tuple[Rate, dict[str, Record]]:
    """Judge one after the other in this process."""
    start, done, found = time.perf_counter(), [], {}
    with threadpool_limits(1):
        for name, points in given.items():
            found[name] = judge(points, seed_of(digest_of(points), SETTINGS), SETTINGS)
            done.append(moment())
    return Rate.of(start, done), found


def spread(
    given: dict[str, bc.Correspondences],
    workers: int,
    truth: dict[str, Record],
    folder: Path,
    meanwhile: Callable[[int], None] = lambda _: None,
) -> Rate:
    """Judge by workers; raise where a camera is lost, judged twice, or judged otherwise."""
    done: list[tuple[float, float]] = []

    def progress(_: str) -> None:
        done.append(moment())
        meanwhile(len(done))

    start = time.perf_counter()
    found = bc.fleet(given, workers=workers, folder=folder, progress=progress)
    lines = (folder / NAME).read_text().splitlines()
    if found.records != {name: truth.get(name, record) for name, record in found.records.items()}:
        raise RuntimeError("a worker says something else than this process")
    keys = {json.loads(line)["key"] for line in lines}
    if not len(found.records) == len(keys) == len(lines) == len(given):
        raise RuntimeError("a camera was lost, or judged twice")
    return Rate.of(start, done)


def kill_one() -> None:
    """Kill a worker that this process has started."""
    children = psutil.Process(os.getpid()).children(recursive=True)
    workers = [c for c in children if any("spawn_main" in word for word in c.cmdline())]
    max(workers, key=lambda c: c.cpu_times().user).kill()


def main() -> None:
    """Print a row for each way."""
    parser = argparse.ArgumentParser(prog="scripts/benchmark fleet", description=__doc__)
    parser.add_argument("cameras", nargs="?", type=int, default=2000, help="how many (2000)")
    parser.add_argument("--out", type=Path, help="keep the folder of all cameras there")
    options = parser.parse_args()
    count, given = options.cameras, cameras(options.cameras)
    some = dict(list(given.items())[: max(count // TIMED, 3)])
    loop(dict(list(given.items())[:2]))  # imports
    print(f"{count} cameras of 57 points, orders 1-5 of r and c, as `bayescal compare`\n")
    heads = "s to the first | cameras a second | of the loop | processor s a camera | of the loop"
    print(f"| | {heads} |\n|---|---|---|---|---|---|")
    plain, truth = loop(some)
    print(plain.row(f"plain loop, {len(some)} cameras", plain), flush=True)

    def meanwhile(done: int) -> None:
        if done == count // 2:
            kill_one()

    with tempfile.TemporaryDirectory() as folder:
        for workers in (1, 2):
            found = spread(some, workers, truth, Path(folder) / str(workers))
            print(found.row(f"{counted(workers, 'worker')}, {len(some)}", plain), flush=True)
        found = spread(given, 2, truth, options.out or Path(folder) / "all", meanwhile)
    print(found.row(f"2 workers, {count}, one killed half-way", plain))
    print("\nEvery record is that of the plain loop; none was lost and none judged twice.")


if __name__ == "__main__":
    main()
