"""Counts corners taken for gross errors on clean views, and those found when some are off.

Lenses are compared with gross errors among the corners, by Gaussian noise and by the mixture, and
without these corners: the truth that the mixture should come up to.
"""

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
from scripts.validation.simulated_boards import HEIGHT, WIDTH, Errors, Truth, views_of

HEADING = "## Gross errors of corners"
LENS = Truth((-60.0, 20.0), None)
VIEWS = 10
KINDS = {
    "0.1 px of white noise": Errors(0.1),
    "the same, shared by neighbours, board not flat": Errors(0.1, 0.05, 0.05, 0.1),
}
SHIFTS = 0.5, 0.7, 1.0  # px
TRIES = 10  # corners of a set that are shifted, one at a time
GROSS = 0, 1, 5, 16  # corners that are gross errors: up to 3 %
MIXED = 8  # sets of them each
SIZES = 1.0, 30.0  # px, log-uniform
LENSES = "pinhole", "radial 1", "radial 1 + p", "radial 2", "radial 2 + p", "radial 3"
RIVALS = 10.0  # nat below the best: lenses whose evidence is compared


@dataclass(frozen=True)
class Found:
    """Of one calibration: clean corners called bad, and how many shifted ones are found."""

    alarms: int
    hits: tuple[int, ...]


@dataclass(frozen=True)
class Mixed:
    """Of one set with gross errors.

    Attributes
    ----------
    right : tuple of bool
        Whether the true lens is the most probable: without the gross errors, with them by Gaussian
        noise, and by the mixture.
    gross, found, taken : int
        Gross errors, those taken for bad, and good corners taken for bad.
    off : float
        Largest error of a difference of log evidences, rivals against the best, nat.
    """

    right: tuple[bool, ...]
    gross: int
    found: int
    taken: int
    off: float


def main() -> None:
    """Simulate, print or write."""
    options = options_of("scripts/validate gross-corners", __doc__, HEADING, 40, 2)
    cases = [(options.seed, kind, number) for kind in KINDS for number in range(options.sets)]
    found = of_each(counted, cases, options)
    by_kind = {
        kind: [one for (_, k, _), one in zip(cases, found, strict=True) if k == kind]
        for kind in KINDS
    }
    mixtures = [(options.seed, number, n) for number in range(MIXED) for n in GROSS]
    mixed = of_each(compared, mixtures, options)
    lines = (*report(options, by_kind), *mixture_report(mixed))
    publish("\n".join(lines) + "\n", HEADING, options.out)


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


def compared(seed: int, number: int, gross: int) -> Mixed:
    """Compare lenses with gross errors among the corners, and without them."""
    rng = np.random.default_rng([seed, number])  # the same boards whatever is wrong with them
    truth = Truth((-40.0, 15.0)[: 1 + number % 2], None if number % 4 < 2 else (1.0, -0.6))
    views, _ = views_of(truth, list(KINDS.values())[1], VIEWS, rng)
    bad = rng.choice(views.n_points, gross, replace=False)
    size, angle = np.exp(rng.uniform(*np.log(SIZES), len(bad))), rng.uniform(0, 2 * np.pi, len(bad))
    pixels = views.pixels.copy()
    pixels[bad] += (size * np.array([np.cos(angle), np.sin(angle)])).T
    spoilt = replace(views, pixels=pixels.clip(0, np.array([WIDTH, HEIGHT]) - 1))
    names = [f"{views.names[views.view[i]]}:{views.label(i)}" for i in bad]
    clean, gaussian, mixture = (
        bc.calibrate(v, lenses=LENSES, noise=noise, ess=200)
        for v, noise in (
            (views.without(*names), "gaussian"),
            (spoilt, "gaussian"),
            (spoilt, "outlier-mixture"),
        )
    )
    assert mixture.bad is not None
    taken = {point.point for point in mixture.bad.left_out}
    best = clean.best
    off = [
        (mixture[j.name].log_evidence - mixture[best.name].log_evidence)
        - (j.log_evidence - best.log_evidence)
        for j in clean.lenses
        if j.log_evidence > best.log_evidence - RIVALS
    ]
    return Mixed(
        tuple(r.best.name == truth.key for r in (clean, gaussian, mixture)),
        len(bad),
        len(taken & set(bad.tolist())),
        len(taken - set(bad.tolist())),
        float(np.abs(off).max()),
    )


def mixture_report(found: Sequence[Mixed]) -> Iterator[str]:
    """Yield the lines on the mixture."""
    low, high = SIZES
    yield from (
        "",
        f"Lenses compared with gross errors of {low:g} to {high:g} px (log-uniform) among the "
        f"corners: {MIXED} sets each of",
        "the second kind, radial 1 or 2 with or without tangential terms in truth, "
        f"{len(LENSES)} lenses. Right: how often",
        "the true lens is the most probable, of the same views without the gross errors, with them "
        "by Gaussian noise,",
        "and by `--noise outlier-mixture`; corners taken for bad by the mixture; how far its "
        "differences of ln Z are from those",
        f"without the gross errors (lenses within {RIVALS:g} nat of the best, nat): median over "
        "the sets and largest.",
        "",
        "| gross errors | right without | Gaussian | mixture | found | good ones taken for bad | "
        "off, median | largest |",
        "|" + "---|" * 8,
    )
    for each in GROSS:
        sets = [one for one in found if one.gross == each]
        right = [sum(column) for column in zip(*(o.right for o in sets), strict=True)]
        gross, hits, taken = (sum(getattr(o, n) for o in sets) for n in ("gross", "found", "taken"))
        off = np.array([o.off for o in sets])
        yield (
            f"| {each} of {VIEWS * 54} | {right[0]} | {right[1]} | {right[2]} | {hits} of {gross} "
            f"| {taken} | {np.median(off):.3f} | {off.max():.2f} |"
        )


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
