"""Validates picks of lens models where a test would be too slow; prints a section of Markdown."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.arrays import Array
from bayescal.calibration.averaging import ErrorAverage
from bayescal.calibration.judge import Setting
from bayescal.calibration.laplace import INFERRED
from bayescal.comparison.judging import judge_all
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.points.views.views import Views
from scripts.validation.sections import options_of, publish
from scripts.validation.simulated_boards import HEIGHT, WIDTH, Errors, Truth, some_lens, views_of

HEADING = "## Lens models over many views"
KEYS = (
    "pinhole",
    "radial 1",
    "radial 1 + p",
    "radial 2",
    "radial 2 + p",
    "radial 3",
    "radial 3 + p",
)
VIEWS = (5, 10, 20, 40)
NOISE = (0.1, 0.3, 1.0)
WRONG = 0.05  # a lens of less probability counts as excluded
TWO = Truth((-60.0, 15.0), None)
REAL = {
    "white noise": Errors(),
    "bow 0.3 mm": Errors(bow=0.3),
    "points off by 0.1 px": Errors(offsets=0.1),
    "shared noise 0.1 px": Errors(shared=0.1),
    "lens ripple 0.06 px": Errors(ripple=0.06),
    "all but the ripple": Errors(bow=0.3, offsets=0.1, shared=0.1),
}


def main() -> int:
    """Measure, and print or write; 1 where ours is right less often than AIC or BIC."""
    options = options_of("scripts/validate lenses", __doc__, HEADING, 30, 4)
    failed: list[str] = []
    with threadpool_limits(1):
        section = "\n".join(report(options, failed)) + "\n"
    publish(section, HEADING, options.out)
    return bool(failed)


def report(options: argparse.Namespace, failed: list[str]) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate lenses --sets {options.sets} --seed {options.seed}`. A 9 x 6 board, "
        f"images of {WIDTH} by {HEIGHT} px, pixel",
        "errors independent. Lenses of order 0 to 3 with and without tangential terms, "
        "displacements at the corner from 3 to",
        "150 px (tangential 0.5 to 8 px), drawn anew for each set; noise of 0.1, 0.3 and 1 px in "
        "turn. Right picks among seven lenses;",
        "AIC and BIC from the likelihood of independent noise (counting the poses adds the same to "
        "every lens):",
        "",
        "| views | sets | bayescal | with --independent | BIC | AIC | truth at P < 0.05 |",
        "|" + "---|" * 7,
    )
    for n_views in VIEWS:
        rng = np.random.default_rng([options.seed, n_views])
        counts, lost = np.zeros(4), 0
        for number in range(options.sets):
            truth, child = some_lens(rng), rng.spawn(1)[0]
            views, _ = views_of(truth, Errors(NOISE[number % 3]), n_views, child)
            ours, white = (judged(views, independent=one) for one in (False, True))
            counts += [p == truth.key for p in (pick(ours), pick(white), *criteria(white))]
            lost += chance(ours, truth.key) < WRONG
        cells = " | ".join(f"{c:.0f} ({100 * c / options.sets:.0f} %)" for c in counts)
        yield f"| {n_views} | {options.sets} | {cells} | {lost} |"
        if counts[0] < counts[2:].max():
            failed.append(f"{n_views} views")
    yield from real_boards(options)


def real_boards(options: argparse.Namespace) -> Iterator[str]:
    """Yield the table of errors as real boards have them."""
    yield from (
        "",
        "Errors as real boards have them, of other kinds than the error models (a field over the "
        "image of each view, a cubic and",
        "uniform scatter over the board, a bend about an oblique axis, a sinusoidal ripple of the "
        "lens); white noise of 0.1 px",
        "throughout; 13 views, truth k1 k2. Wrong: the truth has P < 0.05. z: error of fx, fy, cx, "
        "cy over the posterior's deviation",
        "under the true lens, root mean square.",
        "",
        "| errors | sets | right: bayescal | independent | BIC | AIC | wrong: bayescal "
        "| independent | z: bayescal | independent |",
        "|" + "---|" * 10,
    )
    for name, errors in REAL.items():
        rng = np.random.default_rng([options.seed, *name.encode()])
        right, wrong, squares = np.zeros(4), np.zeros(2), np.zeros(2)
        for _ in range(options.sets):
            child = rng.spawn(1)[0]
            views, intrinsics = views_of(TWO, errors, 13, child)
            both = tuple(judged(views, independent=one) for one in (False, True))
            right += [p == TWO.key for p in (*map(pick, both), *criteria(both[1]))]
            wrong += [chance(j, TWO.key) < WRONG for j in both]
            squares += [mean_square(j, intrinsics) for j in both]
        cells = [f"{c:.0f}" for c in (*right, *wrong)]
        cells += [f"{math.sqrt(s / options.sets):.1f}" for s in squares]
        yield f"| {name} | {options.sets} | " + " | ".join(cells) + " |"


@dataclass(frozen=True)
class Weighed:
    """Lenses judged, and what they share."""

    lenses: dict[str, JudgedLens]
    setting: Setting


def judged(views: Views, *, independent: bool) -> Weighed:
    """Judge the seven lenses."""
    sweep = Sweep(views, LensRequest(KEYS, independent=independent, draws=1000), INFERRED)
    found = judge_all(sweep, Store(), Settings())
    return Weighed({j.name: j for j in found}, sweep.setting)


def pick(found: Weighed) -> str:
    """Take the most probable lens."""
    return max(found.lenses.values(), key=lambda j: j.log_evidence).name


def chance(found: Weighed, name: str) -> float:
    """Probability of a lens."""
    return found.lenses[name].probability if name in found.lenses else 0.0


def criteria(found: Weighed) -> tuple[str, str]:
    """Give the picks of BIC and AIC."""
    lenses = found.lenses.values()
    return min(lenses, key=lambda j: j.bic).name, min(lenses, key=lambda j: j.aic).name


def mean_square(found: Weighed, intrinsics: Array) -> float:
    """Mean square of the errors of focal lengths and centre, in posterior deviations."""
    evidence = found.lenses[TWO.key].evidence
    problem = evidence.problem
    truth = problem.model.coordinates(intrinsics, np.zeros(len(problem.model.lens.names)))[:4]
    best = (problem.x + problem.laplace.mean)[:4]
    variance = np.diag(ErrorAverage(evidence, found.setting).covariance())[:4]
    return float(((best - truth) ** 2 / variance).mean())


if __name__ == "__main__":
    raise SystemExit(main())
