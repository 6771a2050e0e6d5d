"""Coverage of what calibrated cameras answer over simulated calibrations; prints Markdown."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

import bayescal as bc
from bayescal.arrays import Array
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import rotation_vectors, rotations
from bayescal.prediction.calibrated.alignment import absorbed_turns
from bayescal.prediction.sights import image_grid, sights
from scripts.validation.sections import of_each, options_of, publish_as_made
from scripts.validation.simulated_boards import Errors, Truth, some_intrinsics, views_of
from scripts.validation.turned_camera import TURNED, projected, turned_points

HEADING = "## Predictions, distances, poses, changes"
NEW, PAIRS, LEVEL = 20, 2, 0.95
BODY = np.random.default_rng(3).uniform(-1, 1, (12, 3))
SETUP = bc.Setup(width=1920.0, height=1080.0)
POSE = float(stats.chi2.ppf(LEVEL, 6))
See = Callable[[Array], Array]


def as_it_was(pixels: Array) -> Array:
    """Leave pixels as they are: nothing happened to the camera."""
    return pixels


@dataclass(frozen=True)
class Calibrated:
    """A camera, and the truth that it was calibrated from.

    Attributes
    ----------
    camera : CalibratedCamera
    see : callable
        True pixels of points in the frame that the camera predicts in.
    see_target : callable
        The same in the frame that poses are given in.
    """

    camera: bc.CalibratedCamera
    see: See
    see_target: See


@dataclass(frozen=True)
class Kind:
    """One kind of camera.

    Attributes
    ----------
    calibrated : callable
        Simulate a calibration, with pixels moved as by what happened to the camera.
    centre : tuple of float
        Principal point, px.
    scene : callable
        Points well inside what it was calibrated with, ``(n, 3)``, at a z where one is given.
    depth : float
        z of the distances.
    target : tuple
        Size of the target, and where it is.
    noise : float
        Px.
    """

    calibrated: Callable[[np.random.Generator, See], Calibrated]
    centre: tuple[float, float]
    scene: Callable[[np.random.Generator, int, float | None], Array]
    depth: float
    target: tuple[float, tuple[float, float, float]]
    noise: float


def bent(world: Array) -> Array:
    """Pixels of a mildly curved camera, px."""
    w, u = world[:, 0] / world[:, 2], world[:, 1] / world[:, 2]
    return np.column_stack([960 + 1100 * w + 150 * w**2, 540 + 1000 * u])


def before(
    rng: np.random.Generator, n: int, depth: float | None, wide: tuple[float, float, float, float]
) -> Array:
    """Points in a cone before the camera: half of x/z and of y/z, and ends of z."""
    z = rng.uniform(*wide[2:], n) if depth is None else np.full(n, depth)
    return np.column_stack([rng.uniform(-s, s, n) * z for s in wide[:2]] + [z])


def polynomial(fit: Callable[[bc.Correspondences], object]) -> Kind:
    """Fit polynomials to forty points with 1 px of noise."""

    def calibrated(rng: np.random.Generator, moved: See) -> Calibrated:
        world = before(rng, 40, None, (0.5, 0.4, 100, 250))
        pixels = bent(world) + rng.standard_normal((40, 2))
        points = bc.Correspondences.from_arrays(world, moved(pixels), setup=SETUP)
        return Calibrated(bc.camera(fit(points), average=True), bent, bent)

    def scene(rng: np.random.Generator, n: int, depth: float | None) -> Array:
        return before(rng, n, depth, (0.4, 0.32, 100, 250))

    return Kind(calibrated, (960.0, 540.0), scene, 150.0, (20.0, (0.0, 0.0, 150.0)), 1.0)


def pinhole() -> Kind:
    """Turn a pinhole of one radial coefficient: 300 points with 0.3 px of noise."""

    def see(world: Array) -> Array:
        return projected(world, **TURNED)

    def calibrated(rng: np.random.Generator, moved: See) -> Calibrated:
        points = turned_points(0.3, int(rng.integers(2**31)))
        points = replace(points, pixels=moved(points.pixels))
        return Calibrated(bc.camera(bc.fit_family(points, "pinhole", (1,), ess=100)), see, see)

    def scene(rng: np.random.Generator, n: int, depth: float | None) -> Array:
        z = rng.uniform(10, 150, n) if depth is None else np.full(n, depth)
        return np.column_stack([rng.uniform(30, 170, n), rng.uniform(30, 190, n), z])

    return Kind(calibrated, (300.0, 200.0), scene, 80.0, (30.0, (100.0, 110.0, 80.0)), 0.3)


def lens() -> Kind:
    """Show a board to a radial lens of order 1 in six views with 0.3 px of noise."""
    truth, intrinsics = Truth((-60.0,), None), some_intrinsics(np.random.default_rng(0))

    def calibrated(rng: np.random.Generator, moved: See) -> Calibrated:
        views, _ = views_of(truth, Errors(0.3), 6, rng, intrinsics)
        views = replace(views, pixels=moved(views.pixels))
        camera = bc.camera(bc.calibrate(views, lenses=[truth.key], independent=True, ess=100))
        one = lens_named("radial", order=1, tangential=False)
        radius = float(np.hypot(*(camera.size or (0, 0)))) / 2
        k = np.array([truth.radial[0] * intrinsics[0] ** 2 / radius**3])

        def see(world: Array) -> Array:
            return np.asarray(intrinsics[2:] + intrinsics[:2] * one.distort(world, k))

        # The camera's frame is its mean lens's: the true lens stands turned in it.
        grid = sights(camera, image_grid(camera, 9, 7))
        common = grid.world[grid.inside], grid.pixels[grid.inside]
        turn = rotations(absorbed_turns(one, intrinsics[None], k[None], *common)[0])
        return Calibrated(camera, lambda world: see(world @ turn.T), see)

    def scene(rng: np.random.Generator, n: int, depth: float | None) -> Array:
        return before(rng, n, depth, (0.25, 0.18, 400, 700))

    middle = (float(intrinsics[2]), float(intrinsics[3]))
    return Kind(calibrated, middle, scene, 500.0, (60.0, (0.0, 0.0, 500.0)), 0.3)


KINDS = {
    "separable (2, 1)": polynomial(lambda p: bc.fit_family(p, "separable", (2, 1))),
    "bivariate 2": polynomial(lambda p: bc.fit_family(p, "bivariate", (2,))),
    "average of separable 1-3": polynomial(
        lambda p: bc.compare_families(p, ["separable"], [1, 2, 3], position=["stated"])
    ),
    "pinhole, one radial term": pinhole(),
    "lens of many views, radial 1": lens(),
}


def pair(name: str, seed: int, number: int) -> tuple[Array, float]:
    """Shares of pixels, distances and poses inside, ``(2, 3)``; whether the two seem changed."""
    shares, made = [], []
    for one in (2 * number, 2 * number + 1):
        rng = np.random.default_rng([seed, one])
        made.append(KINDS[name].calibrated(rng, as_it_was))
        each = (pixels_inside, distances_inside, pose_inside)
        shares.append([share(KINDS[name], made[-1], rng) for share in each])
    return np.array(shares), float(bc.changed(made[0].camera, made[1].camera).changed)


def pixels_inside(kind: Kind, made: Calibrated, rng: np.random.Generator) -> float:
    """Share of new measurements inside their interval."""
    world = kind.scene(rng, NEW, None)
    pixels = made.see(world) + kind.noise * rng.standard_normal((NEW, 2))
    found = bc.predict(made.camera, world)
    return float(((pixels > found.lower) & (pixels < found.upper)).mean())


def distances_inside(kind: Kind, made: Calibrated, rng: np.random.Generator) -> float:
    """Share of distances within their expanded uncertainty."""
    ends = kind.scene(rng, 2 * PAIRS, kind.depth)
    pixels = made.see(ends) + kind.noise * rng.standard_normal((2 * PAIRS, 2))
    pairs = np.column_stack([pixels[:PAIRS], pixels[PAIRS:]])
    found = bc.distances(made.camera, pairs, depth=kind.depth)
    truth = np.linalg.norm(ends[:PAIRS] - ends[PAIRS:], axis=1)
    return float((np.abs(found.values - truth) < found.expanded).mean())


def pose_inside(kind: Kind, made: Calibrated, rng: np.random.Generator) -> float:
    """Whether a target's pose lies in the 95 % ellipsoid of its covariance."""
    size, middle = kind.target
    turn = rng.normal(0, 0.3, 3)
    at = np.array(middle) + size / 2 * rng.uniform(-1, 1, 3)
    body = size * BODY
    pixels = made.see_target(body @ rotations(turn).T + at)
    found = bc.locate_target(
        made.camera, body, pixels + kind.noise * rng.standard_normal(pixels.shape)
    )
    spin = rotation_vectors(rotations(turn) @ found.matrix.T)
    away = np.array([*(at - found.position), *spin])
    return float(away @ np.linalg.solve(found.linear_covariance, away) < POSE)


def report(options: argparse.Namespace) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        f"`./scripts/validate predictions --sets {options.sets} --seed {options.seed}`. "
        "Polynomials from 40 points with 1 px of noise, a turned",
        "pinhole from 300 points with 0.3 px, a lens from six views of a board with 0.3 px (its "
        "truth turned into the camera's frame). Each",
        f"calibration predicts {NEW} new measurements inside the domain, measures {PAIRS} "
        "distances at a known depth and places a target of",
        f"{len(BODY)} points; disjoint pairs of calibrations are compared. Per cent inside the "
        "stated 95 %, and pairs called changed at 5 %,",
        "with standard errors over the calibrations:",
        "",
        "| model | sets | new pixels in 95 % | distances within U | poses in 95 % | changed |",
        "|---|---|---|---|---|---|",
    )
    for name in KINDS:
        cases = [(name, options.seed, number) for number in range((options.sets + 1) // 2)]
        found = of_each(pair, cases, options)
        inside = np.concatenate([shares for shares, _ in found])
        columns = [*inside.T, np.array([alarm for _, alarm in found])]
        yield f"| {name} | {len(inside)} | {' | '.join(map(_percent, columns))} |"


def _percent(values: Array) -> str:
    se = float(values.std(ddof=1)) / len(values) ** 0.5
    return f"{100 * float(values.mean()):.1f} ± {100 * se:.1f} %"


def main() -> None:
    """Measure, and print or write."""
    options = options_of("scripts/validate predictions", __doc__, HEADING, 1000, 4)
    publish_as_made(report(options), HEADING, options.out)


if __name__ == "__main__":
    main()
