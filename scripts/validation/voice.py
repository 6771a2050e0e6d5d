"""Counts how often the verdict is right on simulated cameras; prints a section of Markdown."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.comparison.analysis import analyse_points
from bayescal.comparison.families.hint import family_hint
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.settings import Settings
from bayescal.fleets.closed_forms import ClosedForms
from bayescal.linear.least_squares import factorise
from bayescal.polynomials.basis import legendre_design
from scripts.validation.sections import of_each, options_of, publish
from scripts.validation.voice_cameras import KINDS, Camera

HEADING = "## The verdict"
ORDERS = (1, 2, 3, 4, 5)


def main() -> int:
    """Measure, print or write; 1 where "decided" is wrong in more than 5 % of where it is said."""
    options = options_of("scripts/validate voice", __doc__, HEADING, 200, 5)
    cases = [(options.seed, kind, number) for kind in KINDS for number in range(options.sets)]
    found = of_each(counted, cases, options)
    counts = {kind: Counter[str]() for kind in KINDS}
    for (_, kind, _), outcome in zip(cases, found, strict=True):
        counts[kind].update(outcome)
    publish("\n".join(report(options, counts)) + "\n", HEADING, options.out)
    return 0


def counted(seed: int, kind: str, number: int) -> Counter[str]:
    """Count the outcomes of both axes of a camera."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), number])
    camera = KINDS[kind](rng)
    settings = dict(camera.settings)
    orders = settings.pop("orders", ORDERS)
    wanted = Settings(**settings)
    result = analyse_points(camera.points, dict.fromkeys("rc", orders), wanted, None, ClosedForms())
    if not all(axis.verdict.withheld for axis in result.axes.values()):
        result = result.with_hint(family_hint(camera.points, result, wanted))
    found: Counter[str] = Counter()
    for name, axis in result.axes.items():
        found.update(outcomes(camera, name, axis))
    return found


def outcomes(camera: Camera, name: str, axis: AxisComparison) -> Iterator[str]:
    """Name what an axis's verdict was, and whether it was right."""
    verdict, truth = axis.verdict, camera.order[name]
    yield "axes"
    right = "right" if verdict.order == truth else "wrong"
    if verdict.order == truth or (not truth and verdict.withheld):
        yield "headline right"
    if len(verdict.plausible) == 1:
        yield f"one plausible, {right}"
    yield str(verdict.outcome)
    if verdict.outcome == "decided":
        yield f"decided, {right}"
    if verdict.outcome == "suffices" and truth and verdict.enough is not None:
        holds = missed(camera, name, axis) <= verdict.enough.largest
        yield f"suffices, {'holds' if holds else 'fails'}"


def missed(camera: Camera, name: str, axis: AxisComparison) -> float:
    """Largest difference of the true curve from the recommended order that fits it best, px."""
    order, truth = axis.chosen.order, camera.order[name]
    if truth <= order:
        return 0.0
    r, q = factorise(axis.data, truth).r, order + 1
    b = camera.curve[name]
    design = legendre_design(np.linspace(-1, 1, 401), truth)
    taken_up = solve_triangular(r[:q, :q], r[:q, q:])
    return float(np.abs((design[:, q:] - design[:, :q] @ taken_up) @ b[q:]).max())


def report(options: argparse.Namespace, counts: dict[str, Counter[str]]) -> Iterator[str]:
    """Yield the lines of the section."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate voice --sets {options.sets} --seed {options.seed}`: {options.sets} "
        "simulated cameras of each kind, r and c of each, in closed form.",
        'One plausible: the plausible set has one member, which alone made a verdict "decided" '
        "before findings could withhold the word;",
        "in brackets how many of them named a wrong order (any, where no polynomial of one "
        "coordinate is true). Suffices: in brackets how",
        "often the true curve differs by more than is said. Headline right: the true order is "
        "recommended; where no order is true, nothing is",
        "called decided or enough.",
        "",
        "| cameras | axes | headline right | one plausible (wrong) | decided (wrong) | suffices "
        "(fails) | undecided | best of those compared |",
        "|" + "---|" * 8,
    )
    for name, c in counts.items():
        one = c["one plausible, right"] + c["one plausible, wrong"]
        yield (
            f"| {name} | {c['axes']} | {c['headline right']} | {one} "
            f"({c['one plausible, wrong']}) | {c['decided']} ({c['decided, wrong']}) | "
            f"{c['suffices']} ({c['suffices, fails']}) | {c['undecided']} | {c['best compared']} |"
        )


if __name__ == "__main__":
    raise SystemExit(main())
