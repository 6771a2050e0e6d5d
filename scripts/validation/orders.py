"""Measures whether probabilities of orders are what they say; prints a section of Markdown."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.linear.quadrature import COARSE
from scripts.validation.sections import options_of, publish
from scripts.validation.simulated_orders import STANDARD_ERRORS, Claims, draw, log_evidences

HEADING = "## Calibrated probabilities"
SIZES = (30, 57, 200)
# True strengths, fractions of the image, where sigma is from its prior or a detector's.
STRENGTHS = ((None, (0.0005, 0.002, 0.05)), (1.0, (0.0005, 0.001, 0.05)), (0.05, (0.00003, 0.0001)))
# Confident claims are those above these; 0.95 is what the verdict calls decided.
LEVELS = (0.9, 0.95, 0.99)
# Good to 0.0002 nat, in a fiftieth of the time of FINE.
QUICK = dataclasses.replace(COARSE, tau_nodes=25)


def main() -> int:
    """Measure, print or write; 1 where a probability is not what it says."""
    options = options_of("scripts/validate orders", __doc__, HEADING, 5000, 10)
    with threadpool_limits(1):
        from_prior = {n: measured(options, n) for n in SIZES}
        fixed = {
            (sigma, tau, n): measured(options, n, tau, sigma)
            for sigma, strengths in STRENGTHS
            for tau in strengths
            for n in SIZES
        }
    section = "\n".join(report(options, from_prior, fixed)) + "\n"
    publish(section, HEADING, options.out)
    return 0 if all(honest(claims) for claims in from_prior.values()) else 1


def measured(
    options: argparse.Namespace, n: int, tau: float | None = None, sigma: float | None = None
) -> Claims:
    """Claims of all data sets of one kind: exact where every parameter is from the prior."""
    print(f"calibrate: n {n}, tau {tau or 'prior'}, sigma {sigma or 'prior'}", file=sys.stderr)
    kind = (n, round(1e6 * (tau or 0)), round(1e6 * (sigma or 0)))
    rng = np.random.default_rng(np.random.SeedSequence(options.seed, spawn_key=kind))
    problem = draw(n, options.sets, rng, tau, sigma)
    return Claims.of(log_evidences(problem, accuracy=QUICK), problem.order)


def honest(claims: Claims) -> bool:
    """Whether every bin is calibrated and the very strong claims are not wrong too often."""
    return all(b.calibrated for b in claims.bins()) and claims.very_strong().honest


def report(
    options: argparse.Namespace,
    from_prior: dict[int, Claims],
    fixed: dict[tuple[float | None, float, int], Claims],
) -> Iterator[str]:
    """Yield the lines of the section."""
    seed = f" --seed {options.seed}" if options.seed else ""
    yield from (
        HEADING,
        "",
        "Measured, and written here, by",
        "",
        "```console",
        f"$ ./scripts/validate orders --sets {options.sets}{seed} --out docs/validation.md",
        "```",
        "",
        f"{options.sets} data sets for each n, the order (1-5) and every parameter (coefficients, "
        "tau, sigma) drawn from",
        "the default prior on an image 1920 px wide. Regressors: x/z of the thesis's 57 points, 30 "
        "of them, or 200 uniform",
        "on their domain. Evidence of every order in closed form, to 0.0002 nat. All pairs "
        "(probability, whether the order is",
        "the true one) in ten bins of equal count: how many should be true by their own "
        "probabilities, how many are, and",
        "the difference in standard errors: binomial ones, sqrt(sum p (1 - p)), and exact ones, "
        "which are smaller because",
        "only one order of a data set is true. The limit is 4 of either.",
    )
    for n, claims in from_prior.items():
        yield from bin_table(n, claims)
    bins = [b for claims in from_prior.values() for b in claims.bins()]
    off = sum(not b.calibrated for b in bins)
    binomial, exact = (max(abs(b.deviations[i]) for b in bins) for i in (0, 1))
    yield from (
        "",
        f"Largest difference: {binomial:.1f} binomial, {exact:.1f} exact standard errors; {off} "
        f"of {len(bins)} bins are off by more than {STANDARD_ERRORS:g}.",
        "",
        "Very strong claims (2 ln B > 10 against the runner-up) of the same data sets, and the "
        "number of wrong ones that",
        "their own probabilities imply, with its 99.9 % quantile (Poisson-binomial):",
        "",
        "| n | very strong | wrong | implied | 99.9 % quantile |",
        "|---|---|---|---|---|",
    )
    for n, claims in from_prior.items():
        v = claims.very_strong()
        yield f"| {n} | {v.claims} | {v.wrong} | {v.expected:.1f} | {v.limit} |"
    yield from (
        "",
        "### Where the true strength is fixed",
        "",
        "b_j ~ N(0, (tau size)²) for j >= 2 at one tau. No probability is bound to be right here: "
        "the prior spreads tau from",
        "0.01 px to half the image. The order is still drawn from 1-5; sigma from its prior, or "
        "always 1 or 0.05 px. The",
        "analysis is the default one, which infers tau and sigma (evidence to 0.0002 nat). Numbers "
        f"are data sets of {options.sets}:",
        "the most probable order right, and how many should be by their own probabilities; claims "
        "of an order at more than",
        "0.9, 0.95 (the verdict's *decided*) and 0.99, with those too low and too high; very "
        "strong claims, those wrong, and",
        "the 99.9 % quantile implied.",
        "",
        "| sigma, px | tau | n | right | implied "
        + "".join(f"| > {level:g} | low | high " for level in LEVELS)
        + "| very strong | wrong | quantile |",
        "|" + "---|" * (8 + 3 * len(LEVELS)),
    )
    for (sigma, tau, n), claims in fixed.items():
        yield strength_row("prior" if sigma is None else f"{sigma:g}", tau, n, claims)
    yield ""
    for level in LEVELS:
        yield worst_case(level, fixed)


def bin_table(n: int, claims: Claims) -> Iterator[str]:
    """Yield a table with a row for each bin."""
    yield from (
        "",
        f"| n = {n}: probability | expected | true | binomial errors | exact errors |",
        "|---|---|---|---|---|",
    )
    for b in claims.bins():
        binomial, exact = (round(d, 1) + 0.0 for d in b.deviations)  # no -0.0
        yield (
            f"| {b.lower:.2g} to {b.upper:.2g} | {b.expected:.4g} | {b.observed} "
            f"| {binomial:+.1f} | {exact:+.1f} |"
        )


def strength_row(sigma: str, tau: float, n: int, claims: Claims) -> str:
    """Row of a fixed strength: how often right, and confident claims gone wrong."""
    right = int((claims.claimed == claims.order).sum())
    cells = [sigma, f"{tau:g}", str(n), str(right), f"{claims.confidence.sum():.0f}"]
    for level in LEVELS:
        cells += map(str, confident(claims, level))
    v = claims.very_strong()
    cells += [str(v.claims), str(v.wrong), str(v.limit)]
    return "| " + " | ".join(cells) + " |"


def confident(claims: Claims, level: float) -> tuple[int, int, int]:
    """Claims of an order at more than a probability; those too low, those too high."""
    above = claims.confidence > level
    low, high = claims.claimed < claims.order, claims.claimed > claims.order
    return int(above.sum()), int(low[above].sum()), int(high[above].sum())


def worst_case(level: float, fixed: dict[tuple[float | None, float, int], Claims]) -> str:
    """Say where the largest share of confident claims was of too low an order."""
    counts = {kind: confident(claims, level) for kind, claims in fixed.items()}
    kind = max(counts, key=lambda k: counts[k][1] / max(counts[k][0], 1))
    (sigma, tau, n), (claims, low, _) = kind, counts[kind]
    noise = "sigma from its prior" if sigma is None else f"sigma {sigma:g} px"
    return (
        f"- Worst above {level:g}: {low} of {claims} claims ({100 * low / max(claims, 1):.1f} %) "
        f"of too low an order, at tau {tau:g}, {noise}, n = {n}."
    )


if __name__ == "__main__":
    sys.exit(main())
