"""Simulation-based calibration of lenses drawn from the prior; prints a section of Markdown."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.special import logsumexp, softmax

from bayescal.arrays import Array
from bayescal.calibration.fitting.least_squares import rms
from bayescal.calibration.judging.averaging import ErrorAverage
from bayescal.calibration.judging.evidence import DRAWS as IMPORTANCE
from bayescal.calibration.judging.laplace import INFERRED
from bayescal.calibration.judging.sampled import SampledLens
from bayescal.comparison.judging import judge_all
from bayescal.comparison.lenses.analysis import weighed_lenses
from bayescal.comparison.lenses.request import LensRequest
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.lenses.sweep import Sweep
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.inference.weighting import resampled
from scripts.validation.lenses import KEYS
from scripts.validation.prior_boards import N_VIEWS, Case, drawn_cases, log_pose_density
from scripts.validation.ranks import DRAWS, holm, p_values, ranks
from scripts.validation.sections import of_each, options_of, publish

HEADING = "## Lens models over many views: lenses from the prior"
BINS = 8
LARGEST_RMS = 2.0  # px: sets that fit worse are drawn anew
EDGES = (0, 0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0001)
RANKED = {
    "radial 2 + p, independent noise": ("radial 2 + p", True),
    "fisheye 2, independent noise": ("fisheye 2", True),
    "radial 2 + p, error models": ("radial 2 + p", False),
}


def main() -> int:
    """Measure, and print or write the section."""
    options = options_of("scripts/validate lens-sbc", __doc__, HEADING, 384, 5 * BINS)
    publish("\n".join(report(options)) + "\n", HEADING, options.out)
    return 0


def report(options: argparse.Namespace) -> Iterator[str]:
    """Yield the section's lines."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate lens-sbc --sets {options.sets} --seed {options.seed}`. Every parameter "
        f"of the lens, sigma and the taus drawn from the program's prior,",
        f"{N_VIEWS} views of a 9 x 6 board, poses from a density of which the analysis is told "
        "(its draws are weighted by it). Sets with a",
        f"measured point outside the image, or whose fit leaves more than {LARGEST_RMS:g} px, are "
        "drawn anew as a whole: chosen by the data, ranks stay",
        f"uniform. Chi-squared of the truths' ranks in {BINS} bins, the smallest p-value of all "
        "parameters, adjusted for their number (Holm);",
        "and the same with deviations 30 % too small:",
        "",
        "| lens | sets | parameters | smallest p | of | 30 % too small |",
        "|" + "---|" * 6,
    )
    cases = [(options.seed, name, number) for name in RANKED for number in range(options.sets)]
    outcomes = of_each(simulated, cases, options)
    for name in RANKED:
        found = [o for o, case in zip(outcomes, cases, strict=True) if case[1] == name]
        names = list(found[0][0])
        sets = [(np.array(list(truth.values())), draws) for truth, draws in found]
        raw = p_values(ranks(sets), BINS)
        control = holm(p_values(ranks(sets, 0.7), BINS)).min()
        worst = names[int(raw.argmin())]
        yield (
            f"| {name} | {len(sets)} | {len(raw)} | {holm(raw).min():.3f} | {worst} "
            f"| {control:.1g} |"
        )
    yield from orders(options)


def simulated(seed: int, name: str, number: int) -> tuple[dict[str, float], Array]:
    """Truths, and ``(DRAWS, n)`` draws of them."""
    rng = np.random.default_rng([seed, *name.encode(), number])
    key, exact = RANKED[name]
    case = next(c for c in drawn_cases((key,), rng, exact=exact) if fits(c, key))
    sweep = Sweep(case.views, LensRequest((key,), exact, draws=IMPORTANCE), INFERRED)
    (judged,) = judge_all(sweep, Store(), Settings())
    names = SampledLens(judged.evidence.problem).names
    draws, log_weights = told(judged, sweep, rng)
    return {n: case.truth[n] for n in names}, draws[resampled(softmax(log_weights), DRAWS, rng)]


def fits(case: Case, key: str) -> bool:
    """Whether the residuals of a lens are small."""
    sweep = Sweep(case.views, LensRequest((key,), independent=True), INFERRED)
    return any(rms(sweep.data, f.fit.sum_of_squares) < LARGEST_RMS for f in sweep)


def told(judged: JudgedLens, sweep: Sweep, rng: np.random.Generator) -> tuple[Array, Array]:
    """Draw all that is inferred, error models averaged; log weights by the poses' density.

    Returns
    -------
    draws : Array
        ``(n_draws, n_names)``.
    log_weights : Array
        ``(n_draws,)``.
    """
    parts, logs = [], []
    for density, draws in ErrorAverage(judged.evidence, sweep.setting).parts(rng, IMPORTANCE):
        sampled = SampledLens(density)
        parts.append(sampled.report(sampled.complete(draws, rng)))
        focal = sampled.problem.model.physical(draws)[0][:, 0]
        logs.append(log_pose_density(focal, sampled.problem.poses_at(draws)))
    return np.concatenate(parts), np.concatenate(logs)


def orders(options: argparse.Namespace) -> Iterator[str]:
    """Yield the table of probabilities of lenses."""
    cases = [(options.seed, number) for number in range(options.sets)]
    found = np.array(of_each(probabilities, cases, options))
    p, hit = found[:, 0].ravel(), found[:, 1].ravel()
    right = int((found[:, 0].argmax(axis=1) == found[:, 1].argmax(axis=1)).sum())
    yield from (
        "",
        f"Probabilities of the lenses of order 0 to 3 with and without tangential terms "
        f"({len(KEYS)}), on {len(found)} sets each made by one of them,",
        f"independent noise. The most probable lens is the true one {right} times, "
        f"{found[:, 0].max(axis=1).sum():.1f} expected by its probabilities.",
        "",
        "| probability given | pairs | expected true | true | standard errors |",
        "|" + "---|" * 5,
    )
    for low, high in pairwise(EDGES):
        part = (p >= low) & (p < high)
        if part.any():
            mean, count = float(p[part].sum()), float(hit[part].sum())
            error = max(float((p[part] * (1 - p[part])).sum()), 1e-9) ** 0.5
            yield (
                f"| {low:g} to {min(high, 1):g} | {int(part.sum())} | {mean:.1f} | {count:.0f} "
                f"| {(count - mean) / error:+.1f} |"
            )


def probabilities(seed: int, number: int) -> list[list[float]]:
    """Probabilities of the lenses, and which is the true one."""
    rng = np.random.default_rng([seed, 1, number])
    case = next(c for c in drawn_cases(KEYS, rng, exact=True) if fits(c, KEYS[-1]))
    request = LensRequest(KEYS, independent=True, draws=IMPORTANCE)
    sweep, lenses, _ = weighed_lenses(case.views, request, Settings())
    logs = dict.fromkeys(KEYS, -np.inf)
    for judged in lenses:
        _, log_weights = told(judged, sweep, rng)
        mean = logsumexp(log_weights) - np.log(len(log_weights))
        logs[judged.name] = judged.log_evidence + mean
    return [softmax(list(logs.values())).tolist(), [float(key == case.key) for key in KEYS]]


if __name__ == "__main__":
    raise SystemExit(main())
