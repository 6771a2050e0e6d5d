"""Effective samples a second of a pinhole's posterior, over those of other samplers.

Seconds are of processor time; the effective samples are those of the slowest parameter; fit,
adaptation, burn-in, compilation and warm-up are counted. The peers:

NUTS        NumPyro's, on the same density (sigmas and tau integrated out) and in the same
            whitened coordinates as ours, 4 chains of 1000 draws after 1000 of warm-up
stretch     emcee's own move in plain parameters (logs of focal lengths, sigmas and tau;
            camera position), 4 walkers a coordinate
stretch 512 the same move on our marginal density in our coordinates, evaluated for 512
            walkers at once
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import emcee
import numpy as np
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1]))

import bayescal as bc
from bayescal.arrays import Array
from bayescal.cameras.pinhole import ANCHOR, POSE
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.inference.chains.diagnostics import diagnose
from bayescal.prior.amplitudes import tau_bounds
from bayescal.prior.camera import log_normal
from scripts.validation.families import build, sampled
from scripts.validation.sections import publish
from scripts.validation.turned_camera import turned_points

HEADING = "## Camera families: against other samplers"
ESS = 4000
CHAINS, WARM_UP, DRAWS = 4, 1000, 1000
STEPS = 10_000  # some 50 autocorrelation times, after a fifth more that is thrown away
LIMITS = {"NUTS": 15, "stretch": 50}
LOG_TAU = tuple(math.log(bound) for bound in tau_bounds(1920.0))
CASES = (
    ("thesis data, order 0", bc.thesis, 0),
    ("thesis data, order 1", bc.thesis, 1),
    ("thesis data, order 2", bc.thesis, 2),
    ("turned camera, 300 points, order 1", lambda: turned_points(0.06), 1),
)


def ours(points: bc.Correspondences, order: int) -> tuple[float, str]:
    """Effective samples a second as the program has them, and how the chain did."""
    start = time.process_time()
    found = sampled(build(points, order), 0, ESS).chain
    seconds = time.process_time() - start
    size = min(d.ess_bulk for d in found.diagnostics)
    per_draw = size / found.draws[:, :, 0].size
    worst = max(d.rhat for d in found.diagnostics)
    return size / seconds, f"{found.acceptance:.2f} | {per_draw:.2f} | {worst:.4f}"


def nuts(model: GaussianPinhole) -> tuple[float, str]:
    """Effective samples a second of NumPyro's NUTS."""
    import jax
    from numpyro.infer import MCMC, NUTS

    jax.config.update("jax_enable_x64", True)
    density = jax_density(model)
    start = 0.3 * np.random.default_rng(0).standard_normal((CHAINS, model.dimension))
    theirs = np.asarray(jax.vmap(density)(start))
    if not np.allclose(theirs, model.log_prob(start), rtol=0, atol=1e-8):
        raise RuntimeError("the density for JAX is not ours")
    jax.clear_caches()
    begin = time.process_time()
    kernel = NUTS(potential_fn=lambda u: -density(u))
    options: dict[str, Any] = {"chain_method": "vectorized", "progress_bar": False}
    mcmc = MCMC(kernel, num_warmup=WARM_UP, num_samples=DRAWS, num_chains=CHAINS, **options)
    mcmc.run(jax.random.PRNGKey(0), init_params=start)
    draws = np.asarray(mcmc.get_samples(group_by_chain=True))
    seconds = time.process_time() - begin
    theta = draws.reshape(-1, model.dimension)
    reported = model.report(model.complete(theta, np.random.default_rng(0)))
    chains = reported.reshape(CHAINS, DRAWS, -1)
    found = diagnose(chains)
    return min(d.ess_bulk for d in found) / seconds, f"R-hat {max(d.rhat for d in found):.3f}"


def jax_density(model: GaussianPinhole) -> Callable[[Any], Any]:
    """`GaussianPinhole.log_prob` of one draw, written for JAX."""
    import jax.numpy as jnp
    from jax.scipy.special import gammainc, gammaincc, gammaln

    geometry, prior, data = model.geometry, model.prior, model.data
    world = (geometry.world - geometry.centroid).T
    log_frame = float(np.log(np.diag(model.frame.root)).sum())

    def strength(q: Any, log_bounds: tuple[float, float], size: int) -> Any:
        a, (low, high) = size / 2, log_bounds
        most, least = q / 2 * math.exp(-2 * low), q / 2 * math.exp(-2 * high)
        lower = gammainc(a, most) - gammainc(a, least)
        upper = gammaincc(a, least) - gammaincc(a, most)
        mass = jnp.log(jnp.where(least <= a, lower, upper)) + gammaln(a)
        return mass - a * jnp.log(math.pi * q) - math.log(2 * (high - low))

    def normal(x: Any, mean: Any, sd: Any) -> Any:
        return -jnp.sum(((x - mean) / sd) ** 2 / 2 + jnp.log(sd * math.sqrt(2 * math.pi)))

    def density(u: Any) -> Any:
        theta = model.frame.mean + jnp.asarray(model.frame.root) @ u
        focal, centre, w = jnp.exp(theta[:2]), theta[2:4], theta[4:7]
        angle = jnp.sqrt(w @ w)
        cross = jnp.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) / angle
        turn = jnp.eye(3) + jnp.sin(angle) * cross + (1 - jnp.cos(angle)) * cross @ cross
        rotation = turn @ geometry.orientation
        depth = focal[0] * jnp.exp(-theta[9])
        anchor = jnp.append((theta[7:9] - centre) / focal, 1) * depth
        x, y, z = rotation @ world + anchor[:, None]
        image = jnp.stack([x, y]) / z
        square = (image**2).sum(axis=0) * focal[0] * focal[1] / geometry.half_diagonal**2
        terms = theta[POSE:] / geometry.half_diagonal
        gain = 1 + sum(term * square ** (j + 1) for j, term in enumerate(terms))
        residual = data.pixels - centre[:, None] - focal[:, None] * image * gain
        total = log_frame + 3 * jnp.log(depth) - theta[0] - theta[1]
        for level, rss in zip(data.levels, (residual**2).sum(axis=1), strict=True):
            total += strength(rss, level.log_bounds, data.n)
        total += normal(theta[0], math.log(prior.focal), prior.focal_log_sd)
        total += normal(theta[1] - theta[0], 0.0, prior.ratio_log_sd)
        total += normal(centre, prior.centre, prior.centre_sd)
        total += normal(w, 0.0, prior.rotation_sd)
        position = geometry.centroid - rotation.T @ anchor
        total += normal(position, prior.position.mean, prior.position.sd)
        if geometry.order:
            q = ((theta[POSE:] / prior.width) ** 2).sum()
            total += strength(q, LOG_TAU, geometry.order) - geometry.order * math.log(prior.width)
        return jnp.where((z > 0).all(), total, -jnp.inf)

    return density


def plain(model: GaussianPinhole) -> tuple[Callable[[Array], Array], Array]:
    """Density in the parameters one would write down, and the posterior mode in them.

    ln f_r, ln f_c, the principal point, rotation, camera position, displacements, ln sigma
    of r and of c, ln tau.
    """
    geometry, prior, data = model.geometry, model.prior, model.data
    last = POSE + geometry.order

    def log_prob(x: Array) -> Array:
        theta = geometry.to_anchor(x[:, :last], x[:, ANCHOR])
        seen = np.isfinite(theta).all(axis=1)
        theta[~seen] = model.frame.mean
        with np.errstate(all="ignore"):
            pixels, depth = geometry.project(theta)
            rss = ((data.pixels - pixels) ** 2).sum(axis=2)
            displacement = theta[:, POSE:]
            total = prior.log_density(geometry, theta) - geometry.log_volume(theta)
            total -= prior.log_distortion(displacement)
        inside = seen & (depth > 0).all(axis=1)
        for i, level in enumerate(data.levels):
            low, high = level.log_bounds
            log_sigma = x[:, last + i]
            inside &= (low < log_sigma) & (log_sigma < high)
            total -= data.n * (log_sigma + math.log(2 * math.pi) / 2)
            total -= rss[:, i] * np.exp(-2 * log_sigma) / 2 + math.log(high - low)
        if geometry.order:
            low, high = LOG_TAU
            log_sd = x[:, -1:] + math.log(prior.width)
            inside &= (low < x[:, -1]) & (x[:, -1] < high)
            z = displacement * np.exp(-log_sd)
            total += log_normal(z, np.zeros(geometry.order), np.ones(geometry.order))
            total -= geometry.order * log_sd[:, 0] + math.log(high - low)
        return np.where(inside & np.isfinite(total), total, -np.inf)

    mode = model.frame.mean[None].copy()
    mode[:, ANCHOR] = geometry.position(mode)
    hidden = [*np.log(model.fit.sigma), *([math.log(0.02)] * (geometry.order > 0))]
    return log_prob, np.append(mode[0], hidden)


def stretch(log_prob: Callable[[Array], Array], start: Array) -> tuple[float, str]:
    """Effective samples a second of emcee's stretch move, of the slowest coordinate."""
    walkers, dimension = start.shape
    begin = time.process_time()
    sampler = emcee.EnsembleSampler(walkers, dimension, log_prob, vectorize=True)
    state = sampler.run_mcmc(start, STEPS // 5)
    sampler.reset()
    sampler.run_mcmc(state, STEPS)
    slowest = float(sampler.get_autocorr_time(quiet=True).max())
    seconds = time.process_time() - begin
    return STEPS * walkers / slowest / seconds, f"tau {slowest:.0f}"


def rows() -> Iterator[str]:
    """Measure every case, a row of Markdown for each."""
    yield from (
        f"`scripts/benchmark samplers`: effective samples a second of processor time, {ESS} of "
        "ours or more, one run each; in brackets ours over the peer's.",
        "",
        "| pinhole | acceptance | ESS a draw | R-hat | ours | NUTS | stretch | stretch 512 |",
        "|" + "---|" * 8,
    )
    sampled(build(bc.thesis(), 0), 0, 100)  # imports
    missed = []
    for name, points_of, order in CASES:
        points = points_of()
        speed, how = ours(points, order)
        model = build(points, order)
        rng = np.random.default_rng(0)
        density, mode = plain(model)
        start = mode + 1e-3 * rng.standard_normal((4 * len(mode), len(mode)))
        many = 0.5 * rng.standard_normal((512, model.dimension))
        found = {
            "NUTS": nuts(model),
            "stretch": stretch(density, start),
            "stretch 512": stretch(model.log_prob, many),
        }
        cells = []
        for peer, (theirs, note) in found.items():
            ratio = speed / theirs
            cells.append(f"{theirs:.0f}, {note} ({ratio:.0f})")
            if ratio < LIMITS.get(peer, 0):
                missed.append(f"{name}: {ratio:.0f} times {peer}, below {LIMITS[peer]}")
        yield f"| {name} | {how} | {speed:.0f} | {' | '.join(cells)} |"
    yield from ("", *(f"- {line}." for line in missed))


def main() -> None:
    """Print the section, or put it into a file."""
    parser = argparse.ArgumentParser(
        prog="scripts/benchmark samplers",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", metavar="FILE.md", help=f"put the section {HEADING!r} there")
    options = parser.parse_args()
    with threadpool_limits(1):
        body = "\n".join(rows())
    publish(f"{HEADING}\n\n{body.rstrip()}\n\n{peers()}\n", HEADING, options.out)


def peers() -> str:
    """Describe the peers, a line of Markdown each, from the docstring above."""
    listed = (__doc__ or "").split("The peers:\n\n")[1].replace("\n            ", " ").strip()
    return re.sub(r"^(stretch 512|\w+) +", r"- \1: ", listed, flags=re.MULTILINE)


if __name__ == "__main__":
    main()
