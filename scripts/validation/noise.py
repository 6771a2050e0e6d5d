"""Validates robust noise where a test would be too slow; prints a section of Markdown."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator

import dynesty
import numpy as np
from scipy.special import gammaincinv, ndtri
from threadpoolctl import threadpool_limits

import bayescal as bc
from bayescal.arrays import Array
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.sampled_posterior import sample_model
from bayescal.noise.level import NoiseLevel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.polynomials.axis_data import generic_axis
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule
from scripts.validation.ranks import holm, p_values, ranks
from scripts.validation.sections import options_of, publish
from scripts.validation.simulated_noise import NOISES, Design, X, posteriors

HEADING = "## Robust noise"
LIVE = 1000
SEEDS = 10
DESIGN = Design()
BINS = 8
LEVEL = 1e-3  # of all ranks of a noise model together


def main() -> int:
    """Measure, print or write; 1 where something is not as it should be."""
    options = options_of("scripts/validate noise", __doc__, HEADING, 128, 64)
    failed: list[str] = []
    with threadpool_limits(1):
        section = "\n".join(report(options, failed)) + "\n"
    publish(section, HEADING, options.out)
    return bool(failed)


def report(options: argparse.Namespace, failed: list[str]) -> Iterator[str]:
    """Yield the section's lines; what is not as it should be is added to `failed`."""
    yield from (
        HEADING,
        "",
        f"`scripts/validate noise --sets {options.sets} --seed {options.seed}`.",
        "",
        f"Log evidence against nested sampling (dynesty, random walks, {LIVE} live points, the "
        "priors of amplitudes, tau and nu written",
        f"apart from the program's), and over {SEEDS} seeds; sigma and tau inferred:",
        "",
        "| model | ln Z | dynesty | difference, standard errors | sd over seeds, nat "
        "| largest bridge less importance, nat |",
        "|" + "---|" * 6,
    )
    for name, model in cases():
        row, well = nested(name, model, options.seed)
        failed += [name] * (not well)
        yield row
    points = len(X)
    yield from (
        "",
        f"Simulation-based calibration: {options.sets} data sets of {points} points for each noise "
        f"model, order {DESIGN.order}, every parameter",
        "drawn from its prior (sigma from 0.01 to 1000 px), sampled as the program does. "
        f"Chi-squared of the ranks in {BINS} bins,",
        "the smallest p-value of all parameters, adjusted for their number (Holm); and the same "
        "with the deviations 30 % too small.",
        "",
        "| noise | parameters | smallest p | of | 30 % too small |",
        "|" + "---|" * 5,
    )
    for i, (name, noise) in enumerate(NOISES.items()):
        rng = np.random.default_rng([options.seed, i])
        names, found = posteriors(noise, DESIGN, options.sets, rng)
        raw = p_values(ranks(found), BINS)
        p, control = holm(raw).min(), holm(p_values(ranks(found, 0.7), BINS)).min()
        failed += [name] * bool(p < LEVEL or control > LEVEL)
        yield f"| {name} | {len(names)} | {p:.3f} | {names[int(raw.argmin())]} | {control:.1g} |"
    yield ""
    yield f"Not as it should be: {', '.join(failed)}." if failed else "All as it should be."


def cases() -> list[tuple[str, RobustLinearModel]]:
    """Three data sets: both axes of the thesis, and simulated points with three gross errors."""
    rng = np.random.default_rng(5)
    x = np.linspace(-0.5, 0.5, 40)
    t = 400 + 900 * x + 60 * x**2 + rng.normal(0, 1.3, 40)
    t[[3, 17, 30]] += (40, -25, 80)
    simulated = generic_axis(x, t)
    thesis = bc.thesis()
    out = []
    for label, data, order, noise in (
        ("thesis, r, order 4, Student-t", axis_data(thesis, "r"), 4, StudentT()),
        ("thesis, r, order 4, mixture", axis_data(thesis, "r"), 4, OutlierMixture()),
        ("thesis, c, order 1, Student-t", axis_data(thesis, "c"), 1, StudentT()),
        ("thesis, c, order 1, mixture", axis_data(thesis, "c"), 1, OutlierMixture()),
        ("simulated, order 2, Student-t", simulated, 2, StudentT()),
        ("simulated, order 2, mixture", simulated, 2, OutlierMixture()),
    ):
        prior = PriorRule("field", data.size, data.size / 2).of_order(order)
        level = NoiseLevel.inferred()
        out.append((label, RobustLinearModel.of_order(data, order, level, prior, noise)))
    return out


def nested(name: str, model: RobustLinearModel, seed: int) -> tuple[str, bool]:
    """Compare the evidence of several seeds with dynesty's; a row, and whether all is well."""
    found = [
        sample_model(model, np.random.default_rng([seed, i]), 1000).estimate for i in range(SEEDS)
    ]
    sampler = dynesty.NestedSampler(
        lambda cube: float(model.log_likelihood(cube[None, :-1]).sum()),
        from_cube(model),
        model.dimension + 1,
        nlive=LIVE,
        sample="rwalk",
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(dlogz=0.01, print_progress=False)
    peer, error = float(sampler.results.logz[-1]), float(sampler.results.logzerr[-1])
    values = [e.log_evidence for e in found]  # dynesty's prior lies within sigma's bounds
    peer += math.log(model.level.mass)
    off = (values[0] - peer) / math.hypot(error, found[0].error)
    spread = float(np.std(values, ddof=1))
    bridge = max(abs(e.bridge - e.log_evidence) for e in found)
    well = abs(off) < 3 and spread < 0.03 and bridge < 0.05
    return (
        f"| {name} | {values[0]:.3f} ± {found[0].error:.3f} | {peer:.2f} ± {error:.2f} "
        f"| {off:+.1f} | {spread:.3f} | {bridge:.3f} |",
        well,
    )


def from_cube(model: RobustLinearModel) -> Callable[[Array], Array]:
    """From the unit cube to theta and ln tau, by the priors as docs/method.md states them."""
    size = model.prior.size

    def transform(u: Array) -> Array:
        theta = ndtri(u)  # standard normal, as the probits of sigma, fraction and width are
        low = 0.01 / size  # a hundredth of a pixel
        log_tau = math.log(low) + u[-1] * math.log(0.5 / low)
        theta[0] = model.prior.mean[0] + size / 2 * theta[0]
        theta[1] *= size / 2
        theta[2 : model.size] *= math.exp(log_tau) * size
        if model.noise.parameters == ("nu",):
            theta[-2] = math.log(10 * gammaincinv(2, u[-2]))
        theta[-1] = log_tau
        return np.asarray(theta)

    return transform


if __name__ == "__main__":
    sys.exit(main())
