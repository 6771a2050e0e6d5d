"""Cameras a second of a fleet on one and two workers against a plain loop; a worker is killed."""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

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


def cameras(count: int) -> dict[str, bc.Correspondences]:
    """Simulate cameras of 57 points, r of order 3 and c of order 1, alike but for their noise."""
    made = {}
    for i in range(count):
        rng = np.random.default_rng([0, i])
        points, _ = simulate({"r": 3, "c": 1}, 1.0, rng)
        made[f"camera {i:05d}"] = points
    return made


def loop(given: dict[str, bc.Correspondences]) -> tuple[float, dict[str, Record]]:
    """Judge one after the other in this process; cameras a second."""
    start = time.perf_counter()
    found = {}
    with threadpool_limits(1):
        for name, points in given.items():
            found[name] = judge(points, seed_of(digest_of(points), SETTINGS), SETTINGS)
    return len(found) / (time.perf_counter() - start), found


def spread(
    given: dict[str, bc.Correspondences],
    workers: int,
    truth: dict[str, Record],
    meanwhile: Callable[[int], None] = lambda _: None,
) -> tuple[float, float]:
    """Judge by workers: seconds until the first camera is done, cameras a second from then on."""
    done: list[float] = []

    def progress(_: str) -> None:
        done.append(time.perf_counter())
        meanwhile(len(done))

    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        found = bc.fleet(given, workers=workers, folder=folder, progress=progress)
        lines = (Path(folder) / NAME).read_text().splitlines()
    if found.records != {name: truth.get(name, record) for name, record in found.records.items()}:
        raise RuntimeError("a worker says something else than this process")
    keys = {json.loads(line)["key"] for line in lines}
    if not len(found.records) == len(keys) == len(lines) == len(given):
        raise RuntimeError("a camera was lost, or judged twice")
    return done[0] - start, (len(done) - 1) / (done[-1] - done[0])


def kill_one() -> None:
    """Kill a worker that this process has started."""
    children = psutil.Process(os.getpid()).children(recursive=True)
    workers = [c for c in children if any("spawn_main" in word for word in c.cmdline())]
    max(workers, key=lambda c: c.cpu_times().user).kill()


def main() -> None:
    """Print a row for each way."""
    parser = argparse.ArgumentParser(prog="scripts/benchmark fleet", description=__doc__)
    parser.add_argument("cameras", nargs="?", type=int, default=2000, help="how many (2000)")
    count = parser.parse_args().cameras
    given = cameras(count)
    warm = dict(list(given.items())[:2])
    loop(warm)  # imports
    plain, truth = loop(dict(list(given.items())[: max(count // 10, 2)]))
    print(f"{count} cameras of 57 points, orders 1-5 of r and c, as `bayescal compare`\n")
    print("| | s to the first | cameras a second | of the plain loop |\n|---|---|---|---|")
    print(f"| plain loop, {len(truth)} of them | | {plain:.2f} | |")
    for workers in (1, 2):
        first, rate = spread(given, workers, truth)
        times = rate / plain
        print(
            f"| {counted(workers, 'worker')} | {first:.1f} | {rate:.2f} | {times:.2f} |", flush=True
        )

    def meanwhile(done: int) -> None:
        if done == count // 2:
            kill_one()

    first, rate = spread(given, 2, truth, meanwhile)
    how = "2 workers, one killed half-way"
    print(f"| {how} | {first:.1f} | {rate:.2f} | {rate / plain:.2f} |\n")
    print("Every record is that of the plain loop; none was lost and none judged twice.")


if __name__ == "__main__":
    main()
