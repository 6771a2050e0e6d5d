"""Validates intervals of lenses over many views: parameters, sigma, and the projection."""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from scipy.stats import kstest

from bayescal.arrays import Array
from bayescal.calibration.judging.averaging import ErrorAverage
from bayescal.calibration.judging.laplace import INFERRED
from bayescal.calibration.judging.sampled import SampledLens
from bayescal.comparison.judging import judge_all
from bayescal.comparison.lenses.prediction import (
    View,
    covered,
    difference,
    image_grid,
    observed_sample,
    response,
)
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from scripts.validation.sections import of_each, options_of, publish
from scripts.validation.simulated_boards import HEIGHT, WIDTH, Errors, Truth, views_of

HEADING = "## Intervals of lenses over many views"
N_VIEWS = 10
DRAWS = 1000
REGIMES = {
    "white noise 0.2 px": Errors(0.2),
    "white noise 0.1 px, bow 0.3 mm, points off by 0.1 px, shared noise 0.1 px": Errors(
        bow=0.3, offsets=0.1, shared=0.1
    ),
}
PLACES = ("projection, where there are points", "projection, at the corners")


def main() -> int:
    """Measure, and print or write the section."""
    options = options_of("scripts/validate lens-intervals", __doc__, HEADING, 100, 4)
    publish("\n".join(report(options)) + "\n", HEADING, options.out)
    return 0


def report(options: argparse.Namespace) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate lens-intervals --sets {options.sets} --seed {options.seed}`. A 9 x 6 "
        f"board in {N_VIEWS} views, images of {WIDTH} by",
        f"{HEIGHT} px, lenses k1 k2 whose displacements at the corner are 10 to 150 and 3 to 60 "
        "px, drawn anew for each set and judged",
        "as radial 2, error models averaged. Per cent of truths within central intervals of 50 and "
        "95 %, with standard errors over the",
        "sets; p: ranks of the truth among the draws against uniform ones (Kolmogorov-Smirnov). "
        "Truths are not drawn from the prior:",
        "ranks are uniform as far as the data outweigh it. Projections are at infinity, the turn "
        "that poses absorb taken out, r and c apart; corners that a lens can't see, since it folds "
        "before them, are not counted.",
    )
    cases = [(options.seed, name, number) for name in REGIMES for number in range(options.sets)]
    found = of_each(calibrated, cases, options)
    for name in REGIMES:
        ranks: dict[str, list[float]] = defaultdict(list)
        scores: dict[str, list[Array]] = defaultdict(list)
        for one, two in (found[i] for i, case in enumerate(cases) if case[1] == name):
            for place, rank in one.items():
                ranks[place].append(rank)
            for place, z in two.items():
                scores[place].append(z)
        yield from ("", f"| {name} | sets | in 50 % | in 95 % | p |", "|" + "---|" * 5)
        for place, values in ranks.items():
            inside = [np.abs(np.array(values) - 0.5) < half for half in (0.25, 0.475)]
            p = kstest(values, "uniform").pvalue
            yield row(place, [i.astype(np.float64) for i in inside], f"{p:.2f}")
        for place, sets in scores.items():
            seen = [z[np.isfinite(z)] for z in sets if np.isfinite(z).any()]
            shares = [np.array([(np.abs(z) < at).mean() for z in seen]) for at in (0.6745, 1.96)]
            yield row(place, shares, "")


def row(name: str, shares: list[Array], p: str) -> str:
    """Write what share of each set's truths lay inside, ``(n_sets,)``, as a line of the table."""
    n = len(shares[0])
    cells = [f"{100 * s.mean():.1f} ± {100 * s.std(ddof=1) / math.sqrt(n):.1f}" for s in shares]
    return f"| {name} | {n} | {' | '.join(cells)} | {p} |"


def calibrated(seed: int, name: str, number: int) -> tuple[dict[str, float], dict[str, Array]]:
    """Ranks of the true parameters, and errors of the projection in deviations, by place."""
    rng, errors = np.random.default_rng([seed, *name.encode(), number]), REGIMES[name]
    sizes = [np.exp(rng.uniform(*np.log(b))) * rng.choice([-1, 1]) for b in ((10, 150), (3, 60))]
    truth = Truth((float(sizes[0]), float(sizes[1])), None)
    views, intrinsics = views_of(truth, errors, N_VIEWS, rng)
    _, k = truth.lens(float(intrinsics[0]))
    sweep = Sweep(views, LensRequest((truth.key,), draws=DRAWS), INFERRED)
    (judged,) = judge_all(sweep, Store(), Settings())
    average = ErrorAverage(judged.evidence, sweep.setting)
    problem, draws = judged.evidence.problem, average.draws(rng, DRAWS)
    true = np.concatenate([intrinsics, k])
    reported = problem.model.report(draws, 1.0)[:, : len(true)]
    ranks = dict(zip(problem.model.names, (reported < true).mean(axis=0).tolist(), strict=False))
    if not (errors.shared or errors.offsets or errors.bow or errors.ripple):
        column = problem.model.dimension
        log_sigma = SampledLens(problem).complete(draws, rng)[:, column]
        ranks["sigma"] = float((np.exp(log_sigma) < errors.sigma).mean())
    data, plain = sweep.data, judged.model
    mean = draws.mean(axis=0)
    ours = View(problem.model, mean)
    theirs = View(plain, plain.coordinates(intrinsics, k))
    pixels, sample = image_grid(data.size), observed_sample(data)
    apart = difference(ours, theirs, pixels, sample, None)
    maps = response(ours, pixels, sample, None)
    sd = np.sqrt(np.einsum("nai,ij,naj->na", maps, average.covariance(), maps))
    z, within = apart / sd, covered(pixels, data)
    corner = np.isin(pixels[:, 0], (0, data.size[0] - 1)) & np.isin(
        pixels[:, 1], (0, data.size[1] - 1)
    )
    return ranks, dict(zip(PLACES, (z[within].ravel(), z[corner].ravel()), strict=True))


if __name__ == "__main__":
    raise SystemExit(main())
