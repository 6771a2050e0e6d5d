"""Measures what errors of the world coordinates do to slopes and intervals; prints a section."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator

import numpy as np
from threadpoolctl import threadpool_limits

import bayescal as bc
from bayescal.arrays import Array
from bayescal.comparison.choosing import noise_level, prior_rule
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.least_squares import factorise
from bayescal.linear.model import LinearModel
from bayescal.polynomials.separable import axis_data
from scripts.validation.sections import options_of, publish

HEADING = "## Errors of the world coordinates"
PIXEL_SIGMA = 0.5  # px
WORLD_ERRORS = (0.5, 2.0, 7.5, 15.0, 30.0, 60.0)  # px, times the slope of the straight line
# Coefficients of r in powers of x/z, px: a straight line, and one like the thesis's r.
TRUTHS = {1: np.array([986.0, 1066.0]), 4: np.array([986.0, 1066.0, -23.0, -96.0, 203.0])}
EDGE = 0.6


def main() -> int:
    """Measure, print or write."""
    options = options_of("scripts/validate world-errors", __doc__, HEADING, 1000, 100)
    with threadpool_limits(1):
        section = "\n".join(report(options.sets, options.seed)) + "\n"
    publish(section, HEADING, options.out)
    return 0


def report(sets: int, seed: int) -> Iterator[str]:
    """Yield the section's lines."""
    true_place = axis_data(bc.thesis(), "r").x
    variance = float(true_place.var())
    yield from (
        HEADING,
        "",
        f"`scripts/validate world-errors --sets {sets} --seed {seed}`: x/z of the thesis's "
        f"{len(true_place)} points,",
        f"pixels with {PIXEL_SIGMA:g} px of noise, x read with an error worth so many px (error "
        "times slope); both are",
        "stated. How much smaller the slope is than the truth, expected of least squares "
        "(attenuation) and found,",
        "and how often central 95 % intervals hold the truth: of the slope, of the highest "
        "coefficient, of the",
        f"mapping at x/z = {EDGE:g}.",
        "",
        "| order | world error, px | slope smaller by | found | slope held | highest held "
        "| edge held | refused |",
        "|" + "---|" * 8,
    )
    for order, truth in TRUTHS.items():
        for error in WORLD_ERRORS:
            rng = np.random.default_rng([seed, order, round(10 * error)])
            sd = error / truth[1]
            judged = [one_set(true_place, truth, sd, rng) for _ in range(sets)]
            found = np.array([one for one in judged if one is not None])
            loss = 1 - found[:, 0].mean() / truth[1]
            own = found[:, 0].std() / truth[1] / math.sqrt(len(found))
            expected = f"{100 * sd**2 / (variance + sd**2):.2f} %" if order == 1 else ""
            yield (
                f"| {order} | {error:g} | {expected} | {100 * loss:.2f} ± {100 * own:.2f} % | "
                + " | ".join(f"{100 * held:.1f} %" for held in found[:, 1:].mean(axis=0))
                + f" | {sets - len(found)} |"
            )
    yield ""
    yield f"Binomial error of {sets} sets at 95 %: {100 * math.sqrt(0.95 * 0.05 / sets):.1f} %."


def one_set(
    true_place: Array, truth: Array, sd: float, rng: np.random.Generator
) -> list[float] | None:
    """Simulate and fit one set: the slope, and whether each interval holds the truth.

    None where fit and slope do not settle, which bayescal refuses.
    """
    n, order = len(true_place), len(truth) - 1
    row = np.polynomial.polynomial.polyval(true_place, truth) + rng.normal(0, PIXEL_SIGMA, n)
    read = true_place + rng.normal(0, sd, n)
    setup = bc.Setup(width=1920.0, height=1080.0, world_sigma=(sd, 0.0, 0.0))
    points = bc.Correspondences.from_arrays(
        np.column_stack([read, np.zeros(n), np.ones(n)]),
        np.column_stack([row, np.zeros(n)]),
        setup=setup,
    )
    settings = Settings(sigma=PIXEL_SIGMA)
    try:
        data, level, *_ = noise_level(axis_data(points, "r"), settings, None, order)
    except InputError:
        return None
    factors = factorise(data, order)
    prior = prior_rule(data, settings, None).of_order(order)
    exact = exact_posterior(LinearModel(factors, order, level, prior))
    powers = factors.monomials.lead(order)
    edge = EDGE ** np.arange(order + 1)
    wanted = np.array([powers[1], powers[order], edge @ powers])
    target = np.array([truth[1], truth[order], edge @ truth])
    low, middle, high = exact.quantiles(wanted, np.array([0.025, 0.5, 0.975])).T
    return [float(middle[0]), *((low < target) & (target < high)).astype(float)]


if __name__ == "__main__":
    sys.exit(main())
