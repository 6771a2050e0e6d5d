"""Validate the pinhole where a test would be too slow; each part is a section of Markdown.

nested     evidence against dynesty (random walks, 1000 live points)
tempered   evidence under robust noise against tempering from the prior
robust     acceptance, effective samples and evidence over ten seeds under robust noise
sbc        ranks of the truth among the draws over cameras drawn from the prior
orders     how often orders to which a probability is given are the true ones
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.special import softmax
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1]))

import bayescal as bc
from bayescal.arrays import Array
from bayescal.cameras.pinhole import PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.coordinates import suited
from bayescal.density.pinholes.fit import fit_pinhole
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.proposal import ladder, weighted_evidence
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.sampled_posterior import Guess, SampledPosterior, sample_model
from bayescal.noise.level import NoiseLevel
from bayescal.points.camera import StatedCamera
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import Setup
from bayescal.prior.amplitudes import tau_bounds
from bayescal.prior.camera import PinholePrior, pinhole_prior
from scripts.validation.nested_cameras import LIVE, nested_evidence
from scripts.validation.ranks import DRAWS, holm, p_values, ranks
from scripts.validation.robust_cameras import robust
from scripts.validation.sections import publish
from scripts.validation.tempered_cameras import tempered

SETS = 128
BINS = 8
ORDERS = (0, 1, 2)
LEVEL = NoiseLevel.inferred((0.3, 5.0))
# What cameras are drawn from: a laboratory that knows its camera fairly well.
KNOWN = StatedCamera(
    position_sd=(20.0, 20.0, 20.0),
    orientation_sd=(5.0, 5.0, 5.0),
    focal=1100.0,
    focal_log_sd=0.1,
    ratio_log_sd=0.02,
    centre_sd=(40.0, 40.0),
)


def build(points: Correspondences, order: int, tau: float | None = None) -> GaussianPinhole:
    """Fit a pinhole with the levels of `points`' problem."""
    prior = pinhole_prior(points, tau)
    geometry, data = _geometry(points, prior, order), _data(points, NoiseLevel.inferred())
    fit = fit_pinhole(points, geometry, prior, data)
    geometry, fit = suited(geometry, prior.position, fit)
    return GaussianPinhole.of(geometry, prior, data, fit)


def sampled(model: GaussianPinhole, seed: int, ess: int) -> SampledPosterior:
    """Sample as the program does."""
    modes, log_mass = ladder(model)
    guess = Guess(mixture_about(modes, log_mass), modes[:1])
    return sample_model(model, np.random.default_rng(seed), ess, guess)


def nested(_: int) -> Iterator[str]:
    """Compare evidences with dynesty's."""
    yield from (
        f"dynesty with random walks and {LIVE} live points, tau a coordinate of its own:",
        "",
        "| model | ln Z | dynesty | difference, standard errors |",
        "|" + "---|" * 4,
    )
    cases = (
        ("thesis data, order 1", build(bc.thesis(), 1)),
        ("a camera drawn from the prior, 40 points, order 2", build(simulated(2, 0)[0], 2)),
    )
    for name, model in cases:
        ours, (value, error) = sampled(model, 0, 1000).estimate, nested_evidence(model)
        off = (ours.log_evidence - value) / math.hypot(error, ours.error)
        yield (
            f"| {name} | {ours.log_evidence:.3f} ± {ours.error:.3f} | {value:.2f} ± {error:.2f} "
            f"| {off:+.1f} |"
        )


def simulated(order: int, seed: int) -> tuple[Correspondences, Array, Array]:
    """Points of a camera drawn from the prior, its coordinates, and ln of its sigmas and tau."""
    rng = np.random.default_rng([order, seed])
    low, high = (math.log(bound) for bound in tau_bounds(1920.0))
    tau = math.exp(rng.uniform(low, high))
    setup = Setup(position=(0.0, 0.0, 0.0), width=1920.0, height=1080.0, camera=KNOWN)
    world = np.column_stack(
        [rng.uniform(-250, 250, 40), rng.uniform(-120, 120, 40), rng.uniform(300, 700, 40)]
    )
    blank = bc.Correspondences.from_arrays(world, np.zeros((40, 2)), setup=setup)
    prior = pinhole_prior(blank, tau)
    geometry = _geometry(blank, prior, order)
    theta = prior.draw(rng, geometry, 1)
    sigma = np.exp(rng.uniform(math.log(0.3), math.log(5.0), 2))
    pixels, depth = geometry.project(theta)
    assert (depth > 0).all(), "the prior keeps the points in front"
    noisy = pixels[0] + sigma[:, None] * rng.standard_normal((2, 40))
    hidden = np.log([*sigma, *([tau] * (order > 0))])
    return bc.Correspondences.from_arrays(world, noisy.T, setup=setup), theta, hidden


def _data(points: Correspondences, level: NoiseLevel) -> JointData:
    pixels = np.stack([points.pixel(axis) for axis in "rc"])
    return JointData(pixels, (None, None), (level, level))


def _geometry(points: Correspondences, prior: PinholePrior, order: int) -> PinholeGeometry:
    return PinholeGeometry(points.world, prior.orientation, prior.half_diagonal, order)


def model_of(points: Correspondences, order: int) -> GaussianPinhole:
    """Build the model the simulated data came from."""
    prior = pinhole_prior(points)
    geometry = _geometry(points, prior, order)
    data = _data(points, LEVEL)
    return GaussianPinhole.of(geometry, prior, data, fit_pinhole(points, geometry, prior, data))


def sbc(sets: int) -> Iterator[str]:
    """Rank every parameter's truth among its draws (Talts et al. 2018)."""
    yield from (
        f"{sets} cameras of each order, every parameter drawn from its prior (position known to 20 "
        "units, rotation to 5 degrees, focal length to 10 %,",
        "tau from {:.2g} to {:g}, sigma from 0.3 to 5 px), 40 points each, sampled as the program "
        "does. Chi-squared of the ranks in {} bins,".format(*tau_bounds(1920.0), BINS),
        "the smallest p-value of all parameters, adjusted for their number (Holm); and the same "
        "with deviations 30 % too small.",
        "",
        "| order | parameters | smallest p | of | 30 % too small |",
        "|" + "---|" * 5,
    )
    for order in ORDERS:
        found = []
        for seed in range(sets):
            points, theta, hidden = simulated(order, seed)
            model = model_of(points, order)
            draws = sampled(model, seed, 400).chain.draws
            free = model.frame.whitened(model.geometry.free(theta))
            truth = model.report(np.concatenate([free, hidden[None]], axis=1))[0]
            apart = draws.reshape(-1, draws.shape[2])
            found.append((truth, apart[:: len(apart) // DRAWS][:DRAWS]))
        raw = p_values(ranks(found), BINS)
        control = holm(p_values(ranks(found, 0.7), BINS)).min()
        worst = model.names[int(raw.argmin())]
        yield f"| {order} | {len(raw)} | {holm(raw).min():.3f} | {worst} | {control:.1g} |"


def orders(sets: int) -> Iterator[str]:
    """Compare probabilities of orders with how often they are true."""
    given, true, right = [], [], 0
    for order in ORDERS:
        for seed in range(sets):
            points, _, _ = simulated(order, 1000 + seed)
            logs = np.array([_log_evidence(points, k, seed) for k in ORDERS])
            chance = softmax(logs)
            right += int(np.argmax(chance) == order)
            given += chance.tolist()
            true += [k == order for k in ORDERS]
    p, hit = np.array(given), np.array(true, dtype=float)
    yield from (
        f"{len(p) // len(ORDERS)} cameras as below, a third of each order from {ORDERS[0]} to "
        f"{ORDERS[-1]}; the evidence of each order by importance sampling. The most",
        f"probable order is the true one {right} times.",
        "",
        "| probability given | pairs | expected true | true | standard errors |",
        "|" + "---|" * 5,
    )
    for low, high in pairwise([0, 0.01, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0001]):
        part = (p >= low) & (p < high)
        if part.any():
            mean, count = float(p[part].sum()), float(hit[part].sum())
            error = math.sqrt(max(float((p[part] * (1 - p[part])).sum()), 1e-9))
            off = (count - mean) / error
            yield (
                f"| {low:g} to {min(high, 1):g} | {int(part.sum())} | {mean:.1f} | {count:.0f} "
                f"| {off:+.1f} |"
            )


def _log_evidence(points: Correspondences, order: int, seed: int) -> float:
    rng = np.random.default_rng(seed)
    return weighted_evidence(model_of(points, order), rng, 2000).log_evidence


PARTS: dict[str, tuple[str, Callable[[int], Iterator[str]]]] = {
    "nested": ("## Camera families: evidence against nested sampling", nested),
    "tempered": ("## Camera families: evidence under robust noise", tempered),
    "robust": ("## Camera families: robust noise over seeds", robust),
    "sbc": ("## Camera families: simulation-based calibration", sbc),
    "orders": ("## Camera families: probabilities of orders", orders),
}


def main() -> None:
    """Run the parts asked for, or all."""
    parser = argparse.ArgumentParser(
        prog="scripts/validate families",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (all)")
    parser.add_argument("--sets", type=int, default=SETS, help=f"cameras of each order ({SETS})")
    parser.add_argument("--out", metavar="FILE.md", help="put the sections into this file")
    options = parser.parse_args()
    if options.sets < 5 * BINS:
        parser.error(f"--sets must be at least {5 * BINS}")
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    with threadpool_limits(1):
        for part in options.parts or PARTS:
            heading, lines = PARTS[part]
            asked = f"`scripts/validate families {part} --sets {options.sets}`."
            section = "\n".join([heading, "", asked, "", *lines(options.sets)]) + "\n"
            publish(section, heading, options.out)


if __name__ == "__main__":
    main()
