"""Counts corners taken for gross errors on clean views, and those found when one is off."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

import bayescal as bc
from bayescal.calibration.judging.density import Problem
from bayescal.calibration.judging.free_points import FreePoints
from bayescal.comparison.lenses.gross_errors import LEVEL
from scripts.validation.sections import of_each, options_of, publish
from scripts.validation.simulated_boards import Errors, Truth, views_of

HEADING = "## Gross errors of corners"
LENS = Truth((-60.0, 20.0), None)
VIEWS = 10
KINDS = {
    "0.1 px of white noise": Errors(0.1),
    "the same, shared by neighbours, board not flat": Errors(0.1, 0.05, 0.05, 0.1),
}
SHIFTS = 0.5, 0.7, 1.0  # px
TRIES = 10  # corners of a set that are shifted, one at a time


@dataclass(frozen=True)
class Found:
    """Of one calibration: clean corners called bad, and how many shifted ones are found."""

    alarms: int
    hits: tuple[int, ...]


def main() -> None:
    """Simulate, print or write."""
    options = options_of("scripts/validate gross-corners", __doc__, HEADING, 40, 2)
    cases = [(options.seed, kind, number) for kind in KINDS for number in range(options.sets)]
    found = of_each(counted, cases, options)
    by_kind = {
        kind: [one for (_, k, _), one in zip(cases, found, strict=True) if k == kind]
        for kind in KINDS
    }
    publish("\n".join(report(options, by_kind)) + "\n", HEADING, options.out)


def counted(seed: int, kind: str, number: int) -> Found:
    """Calibrate clean views, then look at each of some corners shifted in a random direction."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), number])
    views, _ = views_of(LENS, KINDS[kind], VIEWS, rng)
    result = bc.calibrate(views, lenses=[LENS.key], ess=200)
    problem = result.best.evidence.problem
    hits = tuple(sum(seen(problem, size, rng) for _ in range(TRIES)) for size in SHIFTS)
    return Found(len(result.gross), hits)


def seen(problem: Problem, size: float, rng: np.random.Generator) -> bool:
    """Whether a corner that is shifted so far, px, is the one found, lens and errors chosen."""
    n_views, n_places = problem.data.which.shape
    at, angle = (rng.integers(n_views), rng.integers(n_places)), rng.uniform(0, 2 * np.pi)
    pixels = problem.data.pixels.copy()
    pixels[at] += size * np.array([np.cos(angle), np.sin(angle)])
    free = FreePoints(replace(problem, data=replace(problem.data, pixels=pixels)))
    worst = free.least_probable()
    assert worst is not None, "ten views leave degrees of freedom"
    return (worst.view, worst.place) == at and worst.log_p + np.log(free.left.sum()) < np.log(LEVEL)


def report(options: argparse.Namespace, found: dict[str, Sequence[Found]]) -> Iterator[str]:
    """Yield the lines of the section."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate gross-corners --sets {options.sets} --seed {options.seed}`: "
        f"{options.sets} calibrations of {VIEWS} views of 54 corners of each",
        "kind, clean; a calibration that calls any corner a gross error is a false alarm, of "
        f"which {100 * LEVEL:g} % are",
        f"allowed. Then {TRIES} of its corners are shifted one at a time in a random direction, "
        "lens and error model kept.",
        "",
        "| errors | calibrations | false alarms | "
        + " | ".join(f"found at {size:g} px" for size in SHIFTS)
        + " |",
        "|" + "---|" * (3 + len(SHIFTS)),
    )
    for kind, sets in found.items():
        alarms = sum(one.alarms > 0 for one in sets)
        tried = TRIES * len(sets)
        shares = [100 * sum(hits) / tried for hits in zip(*(o.hits for o in sets), strict=True)]
        cells = " | ".join(f"{share:.0f} %" for share in shares)
        yield f"| {kind} | {len(sets)} | {alarms} | {cells} |"


if __name__ == "__main__":
    main()
