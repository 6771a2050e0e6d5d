"""Validates picks of lens models where a test would be too slow; prints a section of Markdown."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from bayescal.arrays import Array
from bayescal.calibration.judging.averaging import ErrorAverage
from bayescal.calibration.judging.judge import Setting
from bayescal.comparison.lenses.analysis import weighed_lenses
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.settings import Settings
from bayescal.points.views.views import Views
from scripts.validation.sections import of_each, options_of, publish
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
VIEWS = {5: 1.0, 10: 1.0, 20: 0.5, 40: 0.4}  # with the share of the sets that are made of each
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
    "all": Errors(bow=0.3, offsets=0.1, shared=0.1, ripple=0.06),
}


def main() -> int:
    """Measure, and print or write; 1 where ours is right less often than AIC or BIC."""
    options = options_of("scripts/validate lenses", __doc__, HEADING, 100, 4)
    failed: list[str] = []
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
    numbers = {n: max(round(options.sets * share), 1) for n, share in VIEWS.items()}
    cases = [(options.seed, n, number) for n in VIEWS for number in range(numbers[n])]
    found = np.array(of_each(picked, cases, options))
    for n, sets in numbers.items():
        counts = found[[case[1] == n for case in cases]].sum(axis=0)
        cells = " | ".join(f"{c} ({100 * c / sets:.0f} %)" for c in counts[:4])
        yield f"| {n} | {sets} | {cells} | {counts[4]} |"
        if counts[0] < counts[2:4].max():
            failed.append(f"{n} views")
    yield from real_boards(options)


def picked(seed: int, n_views: int, number: int) -> list[bool]:
    """Whether ours, ours with independent noise, BIC and AIC are right; ours excludes the truth."""
    rng = np.random.default_rng([seed, n_views, number])
    truth = some_lens(rng)
    views, _ = views_of(truth, Errors(NOISE[number % 3]), n_views, rng)
    ours, white = both(views)
    right = [name == truth.key for name in (pick(ours), pick(white), *criteria(white))]
    return [*right, chance(ours, truth.key) < WRONG]


def real_boards(options: argparse.Namespace) -> Iterator[str]:
    """Yield the table of errors as real boards have them."""
    yield from (
        "",
        "Errors as real boards have them, of other kinds than the error models (a field over the "
        "image of each view, a cubic and",
        "uniform scatter over the board, a bend about an oblique axis, a sinusoidal ripple of the "
        "lens); white noise of 0.1 px",
        "throughout; 13 views, truth k1 k2. Wrong: the truth has P < 0.05 (by BIC and AIC: of the "
        "weights exp(-dBIC/2), exp(-dAIC/2)).",
        "z: error over the posterior's deviation under the true lens, root mean square, of focal "
        "lengths and of the centre.",
        "",
        "| errors | sets | right: bayescal | independent | BIC | AIC | wrong: bayescal "
        "| independent | BIC | AIC | z: bayescal | independent |",
        "|" + "---|" * 12,
    )
    cases = [(options.seed, name, number) for name in REAL for number in range(options.sets)]
    found = np.array(of_each(photographed, cases, options))
    for name in REAL:
        rows = found[[case[1] == name for case in cases]]
        cells = [f"{c:.0f}" for c in rows[:, :8].sum(axis=0)]
        focal, centre, focal_white, centre_white = np.sqrt(rows[:, 8:].mean(axis=0))
        cells += [f"{focal:.1f}, {centre:.1f}", f"{focal_white:.1f}, {centre_white:.1f}"]
        yield f"| {name} | {len(rows)} | " + " | ".join(cells) + " |"


def photographed(seed: int, name: str, number: int) -> list[float]:
    """Which picks are right, which exclude the truth, and mean squares of focal and centre's z."""
    rng = np.random.default_rng([seed, *name.encode(), number])
    views, intrinsics = views_of(TWO, REAL[name], 13, rng)
    ours, white = both(views)
    right = [p == TWO.key for p in (pick(ours), pick(white), *criteria(white))]
    wrong = [p < WRONG for p in (*(chance(j, TWO.key) for j in (ours, white)), *weights(white))]
    return [*right, *wrong, *(s for j in (ours, white) for s in squares(j, intrinsics))]


@dataclass(frozen=True)
class Weighed:
    """Lenses judged, and what they share."""

    lenses: dict[str, JudgedLens]
    setting: Setting


def both(views: Views) -> tuple[Weighed, Weighed]:
    """Judge the seven lenses as the program does, and under independent noise."""
    return judged(views, independent=False), judged(views, independent=True)


def judged(views: Views, *, independent: bool) -> Weighed:
    """Judge the seven lenses."""
    request = LensRequest(KEYS, independent=independent, draws=1000)
    sweep, found, _ = weighed_lenses(views, request, Settings())
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


def weights(found: Weighed) -> list[float]:
    """Weight of the true lens by BIC and by AIC."""
    names = list(found.lenses)
    values = np.array([(j.bic, j.aic) for j in found.lenses.values()])
    return [float(w) for w in softmax(-values / 2, axis=0)[names.index(TWO.key)]]


def squares(found: Weighed, intrinsics: Array) -> list[float]:
    """Mean squares of the errors of focal lengths and of centre, in posterior deviations."""
    evidence = found.lenses[TWO.key].evidence
    problem = evidence.problem
    truth = problem.model.coordinates(intrinsics, np.zeros(len(problem.model.lens.names)))[:4]
    best = (problem.x + problem.laplace.mean)[:4]
    variance = np.diag(ErrorAverage(evidence, found.setting).covariance())[:4]
    z = (best - truth) ** 2 / variance
    return [float(z[:2].mean()), float(z[2:].mean())]


if __name__ == "__main__":
    raise SystemExit(main())
