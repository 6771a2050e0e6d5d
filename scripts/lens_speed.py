"""The sweep of lenses over OpenCV's largest fit; effective samples a second; points and views.

Seconds are of processor time, threads of BLAS and OpenCV off.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from textwrap import fill
from typing import Any

import cv2
import emcee
import numpy as np
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1]))

import bayescal as bc
from bayescal.arrays import Array
from bayescal.calibration.fitting.stacking import residuals
from bayescal.calibration.judging.evidence import proposal, settled
from bayescal.calibration.judging.expansion import near
from bayescal.calibration.judging.laplace import degrees
from bayescal.calibration.judging.sampled import SampledLens
from bayescal.inference.sampled_posterior import Guess, sample_model
from bayescal.points.views.views import Views
from scripts.benchmark import spent
from scripts.peers.lens import LensNuts
from scripts.validation.sections import publish

HEADING = "## Lens models"
BUNDLED = Path(__file__).parents[1] / "data" / "chessboard" / "views.csv"
LARGEST = cv2.CALIB_RATIONAL_MODEL | cv2.CALIB_THIN_PRISM_MODEL
LENS = "radial 2 + p"
ESS = 4000
SIZES = ((13, 10, 10), (50, 10, 10), (186, 10, 10), (50, 10, 5), (50, 20, 10))
SIZE = (640, 480)


def timed(make: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of processor time, and what was made."""
    start = time.process_time()
    made = make()
    return time.process_time() - start, made


def sweep(views: Views) -> str:
    """Time the whole sweep over one call of OpenCV, medians of alternating calls."""
    world = [views.target[views.corner[views.view == v]] for v in range(len(views))]
    pixels = [views.pixels[views.view == v] for v in range(len(views))]
    arrays = [[np.float32(a) for a in side] for side in (world, pixels)]
    ours, theirs = [], []
    for _ in range(3):
        seconds, found = timed(lambda: bc.calibrate(views))
        ours.append(seconds)
        for _ in range(3):
            seconds, _ = timed(
                lambda: cv2.calibrateCameraExtended(
                    *arrays, (views.width, views.height), None, None, flags=LARGEST
                )
            )
            theirs.append(seconds)
    mine, other = statistics.median(ours), statistics.median(theirs)
    return (
        f"The sweep of the bundled set ({len(found.lenses)} lenses, error models, evidence, draws, "
        f"views left out) takes {mine:.1f} s, imports apart: {mine / other:.0f} times one "
        f"`cv2.calibrateCameraExtended` of opencv12 ({1e3 * other:.0f} ms)."
    )


def samplers(views: Views) -> Iterator[str]:
    """Effective samples a second of a lens under independent noise."""
    found = bc.calibrate(views, lenses=[LENS], independent=True, ess=100)
    problem = found.problem
    d, data = problem.model.dimension, problem.data

    def ours() -> float:
        own = settled(problem)
        model = SampledLens(near(own))
        drawn = sample_model(model, np.random.default_rng(0), ESS, Guess(*proposal(own)))
        return min(p.ess_bulk for p in drawn.parameters)

    def everything(z: Array) -> Array:
        """Log density of lens and poses, sigma and tau integrated out."""
        poses = problem.poses.moved(z[:, d:].reshape(len(z), -1, 6))
        misfit, possible = residuals(problem.model, data, z[:, :d], poses)
        squares = (misfit**2).sum(axis=(1, 2, 3))
        nu = degrees(data) + 6 * data.n_views
        total = problem.level.log_density(squares, nu) + problem.log_prior(z[:, :d])
        return np.where(possible, total, -np.inf)

    seconds, size = timed(ours)
    rate = size / seconds
    yield from (
        f"Effective samples a second of {LENS}, independent noise, 13 views; those of the slowest "
        "coordinate, one run each. emcee's stretch move has 4 walkers a coordinate, started about "
        "the mode; where its steps are fewer than 50 autocorrelation times the rate is too high.",
        "",
        "| | dimension | autocorrelation time | ESS/s | ours over it |",
        "|---|---|---|---|---|",
        f"| ours, ESS {ESS}, fit of the proposal counted | {d} | | {rate:.0f} | |",
    )
    rng = np.random.default_rng(0)
    marginal = near(problem).log_prob
    about = problem.x + 0.5 * rng.standard_normal((4 * d, d)) @ problem.spread.T
    yield stretch("the same density", marginal, about, 5000, rate)
    n = d + 6 * data.n_views
    many = problem.x + 0.1 * rng.standard_normal((4 * n, d)) @ problem.spread.T
    steps = 1e-5 * rng.standard_normal((4 * n, n - d))
    yield stretch("lens and poses", everything, np.concatenate([many, steps], axis=1), 1000, rate)
    nuts = LensNuts(problem)
    sampled, seconds = nuts.run(0)
    theirs = sampled.ess / seconds
    yield (
        f"| NumPyro's NUTS, all of it, whitened, its warm-up counted | {nuts.dimension} | | "
        f"{theirs:.0f} | {rate / theirs:.0f} |"
    )


def stretch(
    name: str, log_prob: Callable[[Array], Array], start: Array, steps: int, rate: float
) -> str:
    """Sample with emcee's own move: a row of Markdown."""

    def run() -> float:
        sampler = emcee.EnsembleSampler(*start.shape, log_prob, vectorize=True)
        state = sampler.run_mcmc(start, steps // 5)
        sampler.reset()
        sampler.run_mcmc(state, steps)
        return float(sampler.get_autocorr_time(quiet=True).max())

    seconds, slowest = timed(run)
    theirs = steps * len(start) / slowest / seconds
    title = f"stretch, {name}, {steps} steps"
    return f"| {title} | {start.shape[1]} | {slowest:.0f} | {theirs:.0f} | {rate / theirs:.0f} |"


def simulated(n_views: int, columns: int, rows: int) -> Views:
    """Simulate views of a board whose points all lie in the image, noise 0.1 px."""
    rng = np.random.default_rng(0)
    board = np.array([[i, j, 0.0] for j in range(rows) for i in range(columns)])
    board = (board - board.mean(axis=0)) * (200 / max(columns - 1, rows - 1))
    matrix, k = np.array([[530.0, 0, 328], [0, 531, 235], [0, 0, 1]]), np.array([-0.28, 0.07, 0, 0])
    seen: list[Array] = []
    while len(seen) < n_views:
        depth = rng.uniform(300, 600)
        place = np.array([rng.uniform(-0.25, 0.25), rng.uniform(-0.2, 0.2), 1.0]) * depth
        found = cv2.projectPoints(board, rng.normal(0, [0.4, 0.4, 0.3]), place, matrix, k)[0]
        pixels = found.reshape(-1, 2)
        if (pixels > 3).all() and (pixels < np.array(SIZE) - 4).all():
            seen.append(pixels + rng.normal(0, 0.1, pixels.shape))
    return Views.from_arrays([board] * n_views, seen, width=SIZE[0], height=SIZE[1])


def sizes() -> Iterator[str]:
    """Time and peak memory of one lens over so many views and points, each in its own process."""
    yield from (
        f"{LENS} alone, error models, draws and views left out among it; simulated boards, a "
        "process each, imports counted.",
        "",
        "| views | points of each | processor time, s | peak memory, MB |",
        "|---|---|---|---|",
    )
    for n_views, columns, rows in SIZES:
        one = [sys.executable, __file__, "--one", *map(str, (n_views, columns, rows))]
        seconds, memory = spent(one)
        yield f"| {n_views} | {columns * rows} | {seconds:.1f} | {memory:.0f} |"


def main() -> None:
    """Print the section, or put it into a file."""
    parser = argparse.ArgumentParser(prog="scripts/benchmark lenses", description=__doc__)
    parser.add_argument("--out", metavar="FILE.md", help=f"put the section {HEADING!r} there")
    parser.add_argument("--one", nargs=3, type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if options.one:
        bc.calibrate(simulated(*options.one), lenses=[LENS])
        return
    scaling = "\n".join(sizes())  # first: a process begins with the memory of the one before it
    views = bc.load_views(BUNDLED)
    with threadpool_limits(1):
        bc.calibrate(views, lenses=["pinhole"], ess=100)  # imports
        parts = [sweep(views), "\n".join(samplers(views)), scaling]
    lines = "\n\n".join(["`./scripts/benchmark lenses`, processor time.", *parts]).split("\n")
    body = "\n".join(line if line[:1] == "|" else fill(line, 100) for line in lines)
    publish(f"{HEADING}\n\n{body}\n", HEADING, options.out)


if __name__ == "__main__":
    main()
