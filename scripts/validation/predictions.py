"""Coverage of predictions and of distances over simulated calibrations, as rows of a table."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

import numpy as np

import bayescal as bc
from bayescal.prediction.locate import Surface
from bayescal.prediction.pairs import distances

NEW, AT = 20, 150.0
SETUP = bc.Setup(width=1920.0, height=1080.0)


def exact(world: np.ndarray) -> np.ndarray:
    """Pixels of a mildly curved camera, px."""
    w, u = world[:, 0] / world[:, 2], world[:, 1] / world[:, 2]
    return np.column_stack([960 + 1100 * w + 150 * w**2, 540 + 1000 * u])


def scene(rng: np.random.Generator, n: int, depth: float | None = None) -> np.ndarray:
    """Points spread over the domain, world units."""
    z = rng.uniform(100, 250, n) if depth is None else np.full(n, depth)
    return np.column_stack([rng.uniform(-0.5, 0.5, n) * z, rng.uniform(-0.4, 0.4, n) * z, z])


def calibration(rng: np.random.Generator) -> bc.Correspondences:
    """Forty points with 1 px of noise."""
    world = scene(rng, 40)
    pixels = exact(world) + rng.standard_normal((40, 2))
    return bc.Correspondences.from_arrays(world, pixels, setup=SETUP)


KINDS: dict[str, Callable[[bc.Correspondences], object]] = {
    "separable (2, 1)": lambda points: bc.fit_family(points, "separable", (2, 1)),
    "bivariate 2": lambda points: bc.fit_family(points, "bivariate", (2,)),
    "average of separable 1-3": lambda points: bc.compare_families(
        points, ["separable"], [1, 2, 3], position=["stated"]
    ),
}


def covered(kind: str, sets: int, seed: int) -> tuple[int, int, int, int]:
    """Count new pixels and distances inside their 95 %, and all of them."""
    counts = [0, 0, 0, 0]
    for i in range(sets):
        rng = np.random.default_rng([seed, i])
        camera = bc.camera(KINDS[kind](calibration(rng)), average=True)
        world = scene(rng, NEW) * np.array([0.9, 0.9, 1.0])
        pixels = exact(world) + rng.standard_normal((NEW, 2))
        found = bc.predict(camera, world)
        inside = (pixels > found.lower) & (pixels < found.upper)
        counts[0] += int(inside.sum())
        counts[1] += inside.size
        ends = scene(rng, 4, AT) * np.array([0.8, 0.8, 1.0])
        seen = exact(ends) + rng.standard_normal((4, 2))
        apart = distances(camera, seen[:2], seen[2:], Surface((0.0, 0.0, 1.0), AT))
        truth = np.linalg.norm(ends[:2] - ends[2:], axis=1)
        counts[2] += int((np.abs(apart.values - truth) < apart.expanded).sum())
        counts[3] += int(apart.found.sum())
    return counts[0], counts[1], counts[2], counts[3]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print("| model | sets | new pixels in 95 % | distances within U |\n|---|---|---|---|")
    for kind in KINDS:
        a, n, b, m = covered(kind, options.sets, options.seed)
        cells = [
            f"{100 * k / t:.1f} ± {100 * math.sqrt(k / t * (1 - k / t) / t):.1f} %"
            for k, t in ((a, n), (b, m))
        ]
        print(f"| {kind} | {options.sets} | {cells[0]} | {cells[1]} |", flush=True)


if __name__ == "__main__":
    main()
