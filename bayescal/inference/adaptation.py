r"""A proposal adapted to a posterior by importance sampling.

From the Laplace approximations of the modes, rounds of draws refit a mixture of
multivariate t distributions to the weighted draws of *all* rounds, each weighted by the
mixture of all rounds' proposals (deterministic mixture: Owen & Zhou 2000, J. Am. Stat.
Assoc. 95, 135; Cornuet, Marin, Mira & Robert 2012, Scand. J. Stat. 39, 798). Weights are
tempered until enough draws are effective, and truncated (Ionides 2008, J. Comput. Graph.
Stat. 17, 295); a broad component stays in the proposal whatever the draws say. At the end
the degrees of freedom are those whose importance weights vary least.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, softmax

from bayescal.arrays import Array
from bayescal.inference.optimum import LogDensity, Mode
from bayescal.inference.t_mixture import TMixture, cholesky

ROUNDS = 12
DRAWS = 2000  # of each round
COMPONENTS = 6
MORE = 3  # components added when the proposal is refined
DOF, BROAD_DOF = 8.0, 3.0  # while adapting; the final tails are chosen
TAILS = (4.0, 8.0, 16.0, 32.0)
INFLATED = 1.5  # first guess over the Laplace approximation, in deviations
BROAD = 3.0  # the defensive component over all draws, in deviations
DEFENSIVE = 0.05
EFFECTIVE = 0.1  # share of draws that tempering keeps effective
STEPS = 8
FLOOR = 0.02
SETTLED = 0.03  # rounds stop when the effective fraction gains less than this


@dataclass(frozen=True, eq=False)
class Adapted:
    """A proposal and how well it fits.

    Attributes
    ----------
    proposal : TMixture
        Its last component is the broad one.
    mean : Array
        Of the weighted draws, ``(dimension,)``.
    covariance : Array
        Their covariance, ``(dimension, dimension)``.
    """

    proposal: TMixture
    mean: Array
    covariance: Array


def adapt(log_density: LogDensity, modes: tuple[Mode, ...], rng: np.random.Generator) -> Adapted:
    """Adapt a proposal to a density, starting from its modes.

    Parameters
    ----------
    log_density : callable
        From ``(n, dimension)`` to ``(n,)``.
    modes : tuple of Mode
        At least one.
    rng : numpy.random.Generator
    """
    mixture = _from_modes(modes)
    proposals, thetas, densities = [], [], []
    before, volume = 0.0, -np.inf
    for number in range(ROUNDS):
        theta = mixture.draw(rng, DRAWS)
        proposals.append(mixture)
        thetas.append(theta)
        densities.append(log_density(theta))
        everything = np.concatenate(thetas)
        log_q = logsumexp([p.log_density(everything) for p in proposals], axis=0)
        log_w = np.concatenate(densities) - log_q
        weights, cold = _tempered(log_w)
        mean, covariance = _moments(everything, weights)
        mixture = _refit(mixture, everything, weights, mean, covariance, rng, first=number == 0)
        fraction = effective_fraction(densities[-1] - proposals[-1].log_density(theta))
        # Weights alone look well where the proposal is too narrow: its volume must settle too.
        grown = abs(float(np.linalg.slogdet(covariance)[1]) / 2 - volume) / len(mean)
        if cold and number > 1 and fraction < before + SETTLED and grown < SETTLED:
            break
        before = max(before, fraction) if cold else 0.0
        volume = float(np.linalg.slogdet(covariance)[1]) / 2
    return Adapted(_best_tails(mixture, everything, weights, log_w + log_q), mean, covariance)


def refine(adapted: Adapted, theta: Array, log_density: Array) -> Adapted:
    """Fit the proposal once more, to draws of the posterior itself.

    Draws of a chain go where the proposal was too thin; new components start there. Bridge
    sampling's proposals are made so too (Gronau et al. 2017, J. Math. Psychol. 81, 80).

    Parameters
    ----------
    adapted : Adapted
    theta : Array
        Draws of the posterior, ``(n, dimension)``.
    log_density : Array
        The density there, ``(n,)``.
    """
    old = adapted.proposal
    weights = np.full(len(theta), 1 / len(theta))
    mean, covariance = _moments(theta, weights)
    root = cholesky(covariance)
    # Spread over the thinnest hundredth of the draws, which lie close together.
    thin = np.argsort(old.log_density(theta) - log_density, kind="stable")
    seeds = theta[thin[:: max(1, len(thin) // (100 * MORE))][:MORE]]
    shares = np.append(0.9 * old.weights[:-1] / old.weights[:-1].sum(), np.full(MORE, 0.1 / MORE))
    narrow = TMixture(
        shares,
        np.concatenate([old.means[:-1], seeds]),
        np.concatenate([old.roots[:-1], np.repeat(root[None], MORE, axis=0)]),
        np.full(len(shares), DOF),
    ).refitted(theta, weights, 3 * STEPS, FLOOR)
    mixture = _with_broad(narrow, mean, BROAD * root)
    return Adapted(_best_tails(mixture, theta, weights, log_density), mean, covariance)


def _best_tails(mixture: TMixture, theta: Array, weights: Array, log_density: Array) -> TMixture:
    """Give the narrow components the degrees of freedom whose weights vary least.

    The second moment of p / q over draws of q is the mean of p / q over draws of p. On
    a nine-dimensional normal it raises the effective fraction from 0.78 to 0.92.
    """
    best, least = mixture, np.inf
    for dof in TAILS:
        narrow = TMixture(
            mixture.weights[:-1] / mixture.weights[:-1].sum(),
            mixture.means[:-1],
            mixture.roots[:-1],
            np.full(len(mixture.weights) - 1, dof),
        ).refitted(theta, weights, STEPS, FLOOR)
        candidate = _with_broad(narrow, mixture.means[-1], mixture.roots[-1])
        with np.errstate(divide="ignore"):
            log_terms = np.log(weights) + log_density - candidate.log_density(theta)
        variation = float(logsumexp(log_terms))
        if variation < least:
            best, least = candidate, variation
    return best


def _with_broad(narrow: TMixture, mean: Array, root: Array) -> TMixture:
    """Add the defensive component."""
    return TMixture(
        np.append((1 - DEFENSIVE) * narrow.weights, DEFENSIVE),
        np.concatenate([narrow.means, mean[None]]),
        np.concatenate([narrow.roots, root[None]]),
        np.append(narrow.dof, BROAD_DOF),
    )


def effective_fraction(log_w: Array) -> float:
    """(sum w)^2 / (n sum w^2)."""
    top = float(log_w.max())
    if not np.isfinite(top):
        return 0.0
    w = np.exp(log_w - top)
    return float(w.sum() ** 2 / (w @ w) / len(w))


def _tempered(log_w: Array) -> tuple[Array, bool]:
    """Normalised weights, raised to the power at which enough are effective; then truncated."""
    power, cold = 1.0, True
    while effective_fraction(power * log_w) < EFFECTIVE and power > 1e-6:
        power, cold = 0.7 * power, False
    weights = np.asarray(softmax(power * log_w))
    limit = weights.mean() * np.sqrt(len(weights))
    weights = np.minimum(weights, limit)
    return weights / weights.sum(), cold


def _moments(theta: Array, weights: Array) -> tuple[Array, Array]:
    mean = weights @ theta
    offset = theta - mean
    return mean, offset.T @ (weights[:, None] * offset)


def _from_modes(modes: tuple[Mode, ...]) -> TMixture:
    """Laplace approximations, inflated, and a broad one over the best of them."""
    log_mass = np.array([m.log_mass for m in modes])
    shares = (1 - DEFENSIVE) * softmax(log_mass / 4)  # a mode's mass is only guessed
    roots = [INFLATED * m.root for m in modes]
    return TMixture(
        np.append(shares, DEFENSIVE),
        np.array([*(m.theta for m in modes), modes[0].theta]),
        np.array([*roots, BROAD * INFLATED * modes[0].root]),
        np.array([*[DOF] * len(modes), BROAD_DOF]),
    )


def _refit(
    mixture: TMixture,
    theta: Array,
    weights: Array,
    mean: Array,
    covariance: Array,
    rng: np.random.Generator,
    *,
    first: bool,
) -> TMixture:
    """Refit all but the broad component, which follows the draws' covariance."""
    root = cholesky(covariance)
    narrow = len(mixture.weights) - 1
    means, roots = mixture.means[:-1], mixture.roots[:-1]
    if first and narrow < COMPONENTS:
        more = COMPONENTS - narrow
        seeds = rng.choice(len(theta), more, p=weights)
        means = np.concatenate([means, theta[seeds]])
        roots = np.concatenate([roots, np.repeat(root[None], more, axis=0)])
    shares = np.full(len(means), 1 / len(means)) if first else mixture.weights[:-1]
    part = TMixture(shares / shares.sum(), means, roots, np.full(len(means), DOF))
    part = part.refitted(theta, weights, STEPS, FLOOR)
    return _with_broad(part, mean, BROAD * root)
