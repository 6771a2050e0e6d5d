"""Evidence of pinholes under robust noise by tempering from the prior, which knows no proposal.

Sequential Monte Carlo (Del Moral, Doucet & Jasra 2006, J. R. Stat. Soc. B 68, 411): draws of the
prior are weighted and resampled by small powers of the likelihood, and moved by differential
evolution between two halves of the population (ter Braak 2006, Stat. Comput. 16, 239).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq
from scipy.special import gammaincinv, logsumexp, ndtr, softmax

import bayescal as bc
from bayescal.arrays import Array
from bayescal.cameras.pinhole import POSE
from bayescal.density.pinholes.robust import RobustPinhole
from bayescal.inference.sampled_posterior import sample_model
from bayescal.noise.student_t import RATE, SHAPE
from bayescal.points.camera import StatedCamera
from bayescal.prior.amplitudes import tau_bounds
from bayescal.prior.probit import log_prior, log_value
from scripts.validation.robust_cameras import robust_model

PARTICLES, SEEDS = 4000, 4
SHARE = 0.9  # of the particles stays effective from one power to the next
ACCEPTED, MOST_MOVES = 8.0, 80  # moves of each particle at each power
IMPOSSIBLE = -1e30
LOG_TAU = tuple(math.log(bound) for bound in tau_bounds(1920.0))
# The thesis's camera as a laboratory may know it: under the default priors, 20 nat wider,
# tempering with so few particles comes out nats too low.
KNOWN = StatedCamera(
    position_sd=(10.0, 10.0, 10.0),
    orientation_sd=(2.0, 2.0, 2.0),
    focal=1080.0,
    focal_log_sd=0.03,
    ratio_log_sd=0.03,
    centre_sd=(30.0, 30.0),
)
POSITION = (328.0, 56.5, -16.0)


def tempered(_: int) -> Iterator[str]:
    """Compare evidences under robust noise with tempering's."""
    yield from (
        f"Thesis data, with a camera known better than by default; {PARTICLES} particles, "
        f"{SEEDS} seeds, mean and its standard error:",
        "",
        "| pinhole, noise | ln Z | tempering | difference, standard errors |",
        "|" + "---|" * 4,
    )
    thesis = bc.thesis()
    points = replace(thesis, setup=replace(thesis.setup, camera=KNOWN, position=POSITION))
    for order, noise in ((0, "student-t"), (0, "outlier-mixture"), (1, "student-t")):
        model = robust_model(points, order, noise)
        ours = sample_model(model, np.random.default_rng(0), 400).estimate
        found = [_evidence(model, np.random.default_rng(seed)) for seed in range(SEEDS)]
        mean, error = float(np.mean(found)), float(np.std(found, ddof=1)) / math.sqrt(SEEDS)
        off = (ours.log_evidence - mean) / math.hypot(error, ours.error)
        yield (
            f"| order {order}, {noise} | {ours.log_evidence:.3f} ± {ours.error:.3f} "
            f"| {mean:.2f} ± {error:.2f} | {off:+.1f} |"
        )


def _evidence(model: RobustPinhole, rng: np.random.Generator) -> float:
    drawn = _from_prior(model, rng, PARTICLES)
    # Of a camera with the points' centroid behind it there is no anchor, and no likelihood.
    y = drawn[np.isfinite(drawn).all(axis=1)]
    total = math.log(len(y) / len(drawn))
    prior, likelihood = _densities(model, y)
    power = 0.0
    while power < 1:
        step = _step(likelihood, 1 - power)
        power += step
        total += float(logsumexp(step * likelihood)) - math.log(len(y))
        places = (np.arange(len(y)) + rng.random()) / len(y)
        taken = np.searchsorted(np.cumsum(softmax(step * likelihood)), places)
        taken = rng.permutation(np.minimum(taken, len(y) - 1))
        y, prior, likelihood = y[taken], prior[taken], likelihood[taken]
        _move(model, y, prior, likelihood, power, rng)
    return total


def _step(likelihood: Array, most: float) -> float:
    """Change of the power at which the share `SHARE` of the possible particles is effective."""

    def lacking(log_step: float) -> float:
        w = softmax(math.exp(log_step) * likelihood)
        possible = float((likelihood > IMPOSSIBLE / 2).mean())
        return 1 / float(w @ w) / len(w) - SHARE * possible

    if lacking(math.log(most)) >= 0:
        return most
    return math.exp(brentq(lacking, math.log(1e-15), math.log(most)))


def _move(
    model: RobustPinhole,
    y: Array,
    prior: Array,
    likelihood: Array,
    power: float,
    rng: np.random.Generator,
) -> None:
    """Move every particle by Metropolis until enough moves are accepted; in place."""
    n, d = y.shape
    accepted = 0.0
    for move in range(1, MOST_MOVES + 1):
        for half in (0, 1):
            own, others = np.arange(half, n, 2), np.arange(1 - half, n, 2)
            one, two = rng.choice(others, len(own)), rng.choice(others, len(own))
            # Whole differences jump between modes.
            length = 1.0 if move % 7 == 0 else 2.38 / math.sqrt(2 * d) * rng.choice([0.3, 0.6, 1.0])
            jitter = 1 + 1e-3 * rng.standard_normal((len(own), d))
            proposed = y[own] + length * (y[one] - y[two]) * jitter
            p, q = _densities(model, proposed)
            ratio = power * (q - likelihood[own]) + p - prior[own]
            ok = np.log(rng.random(len(own))) < ratio
            kept = own[ok]
            y[kept], prior[kept], likelihood[kept] = proposed[ok], p[ok], q[ok]
            accepted += float(ok.mean()) / 2
        if accepted > ACCEPTED:
            return


def _from_prior(model: RobustPinhole, rng: np.random.Generator, size: int) -> Array:
    """Coordinates of the geometry, the probit of tau, and sigma's probit and eta of each axis."""
    prior, geometry = model.prior, model.geometry
    tau = rng.standard_normal((size, int(model.infers_tau)))
    theta = prior.draw(rng, geometry, size)
    noise = rng.standard_normal((size, 2 * (1 + model.noise.dimension)))
    if model.infers_tau:
        spread = prior.width * np.exp(log_value(tau, LOG_TAU))
        theta[:, POSE:] = spread * rng.standard_normal((size, geometry.order))
    if model.noise.name == "student-t":
        noise[:, 1::2] = np.log(gammaincinv(SHAPE, ndtr(noise[:, 1::2])) / RATE)
    return np.concatenate([theta, tau, noise], axis=1)


def _densities(model: RobustPinhole, y: Array) -> tuple[Array, Array]:
    """Log of prior and of likelihood at coordinates as `_from_prior` gives them."""
    after, q = POSE + model.geometry.order, model.noise.dimension
    theta, at = y[:, :after], after + model.infers_tau
    with np.errstate(all="ignore"):
        log_tau = log_value(y[:, after], LOG_TAU) if model.infers_tau else None
        prior = model.prior.log_density(model.geometry, theta, log_tau)
        prior = prior + log_prior(y[:, after:at]).sum(axis=1)
        residuals, possible = model.residuals(theta)
        likelihood = np.zeros(len(y))
        for i, level in enumerate(model.data.levels):
            probit, eta = y[:, at], y[:, at + 1 : at + 1 + q]
            at += 1 + q
            prior = prior + log_prior(probit) + model.noise.log_prior(eta)
            density = model.noise.log_density(
                residuals[:, i], level.log_sigma(probit), eta, model.data.sd[i]
            )
            likelihood += density.sum(axis=1) + math.log(level.mass)
    possible &= np.isfinite(likelihood) & np.isfinite(prior)
    return np.where(possible, prior, IMPOSSIBLE), np.where(possible, likelihood, IMPOSSIBLE)
