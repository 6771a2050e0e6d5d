"""Whole-process times of bayescal over those of a named peer, run in turn."""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

PYTHON = sys.executable
COMPARISONS = [
    (
        "cold `compare --orders 1-5` over importing emcee and arviz_stats",
        [PYTHON, "-m", "bayescal", "compare", "--orders", "1-5"],
        [PYTHON, "-c", "import emcee, arviz_stats"],
        1.3,
    ),
    (
        "`--help` over an empty Python",
        [PYTHON, "-m", "bayescal", "--help"],
        [PYTHON, "-c", "pass"],
        4.0,
    ),
]


# Runs, by what makes them, and a figure of each.
RUNS = {
    "orders, defended": (["compare", "--defend"], ["loo", "--axis", "r"]),
    "families": (
        ["compare", "--family", "separable,pinhole", "--position", "stated,free"],
        ["correlation"],
    ),
    "bad points": (["outliers"], ["bad-points", "--axis", "r"]),
}
MATPLOTLIB = [PYTHON, "-c", "import matplotlib.figure, matplotlib.backends.backend_svg"]
STATS = [PYTHON, "-c", "import scipy.stats"]
PROJECTIONS = 5  # of OpenCV, averaged over


def spent(command: list[str]) -> tuple[float, float]:
    """Run a command: seconds of processor time, peak memory in MB."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed with exit code {process.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


def report() -> str:
    """Time a report's making over the analysis it contains, in this process."""
    import bayescal
    from bayescal.report.page.page import html, page_of

    start = time.process_time()
    found = bayescal.compare(bayescal.thesis(), defend=True)
    analysed = time.process_time()
    page = html(page_of(found, "benchmark"))
    made = time.process_time()
    analysis, making = analysed - start, made - analysed
    return (
        f"making a report ({len(page) / 1e6:.1f} MB) over the analysis it contains: "
        f"{making / analysis:.2f} ({making:.1f} s over {analysis:.1f} s of processor time, one run)"
    )


def predictions(points: int = 1_000_000) -> str:
    """Time predictions with uncertainty over OpenCV's of the same points, times the draws."""
    import cv2
    import numpy as np

    import bayescal

    camera = bayescal.camera(bayescal.fit_family(bayescal.thesis(), "pinhole", (1,), ess=400))
    world = np.resize(bayescal.thesis().world, (points, 3))
    start = time.process_time()
    bayescal.predict(camera, world)
    ours = time.process_time() - start
    pose, matrix = np.zeros(3), np.array([[1e3, 0, 960], [0, 1e3, 540], [0, 0, 1.0]])
    start = time.process_time()
    for _ in range(PROJECTIONS):
        cv2.projectPoints(world, pose, pose, matrix, np.array([0.1, 0, 0, 0]))
    theirs = (time.process_time() - start) / PROJECTIONS
    draws = len(camera.chosen.parameters.draws)
    return (
        f"{points:,} predictions with uncertainty over cv2.projectPoints times {draws} draws: "
        f"{ours / (theirs * draws):.3f} ({ours:.2f} s of processor time, one run; limit 1)"
    )


def reopened(folder: Path) -> Iterator[tuple[str, list[str], list[str], float]]:
    """Make runs; compare reopening each, and a figure of it, with importing matplotlib."""
    for number, (name, (made, figure)) in enumerate(RUNS.items()):
        run = str(folder / str(number))
        spent([PYTHON, "-m", "bayescal", *made, "--orders", "1-3", "--out", run, "--quiet"])
        opening = [PYTHON, "-c", f"import bayescal; bayescal.open_run({run!r})"]
        yield f"reopening a run of {name} over importing matplotlib", opening, MATPLOTLIB, 5.0
        plotting = [PYTHON, "-m", "bayescal", "plot", figure[0], run, *figure[1:], "--force"]
        plotting += ["--out", str(folder / "figure.svg")]
        yield f"`plot {figure[0]}` of it over importing matplotlib", plotting, MATPLOTLIB, 8.0


def first_answers(folder: Path) -> Iterator[tuple[str, list[str], list[str], float]]:
    """Make a run; compare `predict` from it, and from its camera, with importing scipy.stats."""
    command, run, points = [PYTHON, "-m", "bayescal"], folder / "predicted", folder / "points.csv"
    spent([*command, "compare", "--out", str(run), "--quiet"])
    points.write_text("x,y,z\n330,56,500\n", encoding="utf-8")
    for name, source in (("a run", run), ("a saved camera", run / "camera.npz")):
        ours = [*command, "predict", str(source), str(points)]
        yield f"first answer of `predict` from {name} over importing scipy.stats", ours, STATS, 1.5


def main() -> None:
    """Print a row per comparison."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    with TemporaryDirectory() as folder:
        compared(reopened(Path(folder)), runs)
        compared(first_answers(Path(folder)), runs)
    print(predictions())
    print(report())
    compared(COMPARISONS, runs)


def compared(commands: Iterable[tuple[str, list[str], list[str], float]], runs: int) -> None:
    """Print the ratio of each command's processor time to its peer's."""
    for name, ours, peer, limit in commands:
        for command in (ours, peer):
            spent(command)  # warm the disk's cache
        pairs = [(spent(ours)[0], spent(peer)[0]) for _ in range(runs)]
        ratio = statistics.median(a / b for a, b in pairs)
        mine, other = (statistics.median(side) for side in zip(*pairs, strict=True))
        verdict = "meets" if ratio <= limit else "MISSES"
        print(
            f"{name}: {ratio:.2f} ({mine:.3f} over {other:.3f} s of processor time; "
            f"median of {runs} pairs; {verdict} the limit of {limit:g})"
        )


if __name__ == "__main__":
    main()
