"""Data sets whose order is known, what is claimed of them, and whether the claims are calibrated.

The truths are drawn from the prior as docs/method.md states it, written here apart from the
program, so that a prior the program gets wrong shows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

import bayescal as bc
from bayescal.arrays import Array, IntArray
from bayescal.linear.evidence import Projection, Reduced, log_joint, tau_rule
from bayescal.linear.quadrature import FINE, Accuracy
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.basis import Domain, legendre_design
from bayescal.polynomials.separable import axis_data
from bayescal.prior.amplitudes import PriorRule

ORDERS = (1, 2, 3, 4, 5)
WIDTH = 1920.0  # px
BINS = 10
# A bin may be off by this many standard errors.
STANDARD_ERRORS = 4.0
# Kass & Raftery 1995: very strong.
VERY_STRONG = 10.0
# Sums of probabilities differ from whole numbers by less where only rounding does it.
_ROUNDING = 1e-9
# Data sets whose evidence is integrated at once.
_TOGETHER = 40


def regressors(n: int, rng: np.random.Generator) -> Array:
    """Values of x/z, ``(n,)``: the thesis's own 57, fewer of them, or uniform on their domain."""
    thesis = axis_data(bc.thesis(), "r").x
    if n > len(thesis):
        return np.asarray(rng.uniform(thesis.min(), thesis.max(), n))
    return np.asarray(thesis[np.sort(rng.permutation(len(thesis))[:n])])


@dataclass(frozen=True, eq=False)
class Problem:
    """Data sets on one design, with the order that each was made with.

    Attributes
    ----------
    design : Array
        Legendre polynomials up to the highest order, ``(n_points, 6)``.
    t : Array
        Pixels, ``(n_sets, n_points)``.
    order : IntArray
        The true order, ``(n_sets,)``.
    """

    design: Array
    t: Array
    order: IntArray


def draw(
    n: int,
    sets: int,
    rng: np.random.Generator,
    tau: float | None = None,
    sigma: float | None = None,
) -> Problem:
    """Draw the order and every parameter from the prior, then the pixels.

    Parameters
    ----------
    n, sets : int
        Points of a data set; data sets.
    rng : numpy.random.Generator
    tau, sigma : float, optional
        Fixed where given (sigma in px), else from the prior too.
    """
    x = regressors(n, rng)
    design = legendre_design(Domain.of(x).scale(x), ORDERS[-1])
    order = rng.choice(ORDERS, size=sets)
    low = 0.01 / WIDTH  # a hundredth of a pixel
    taus = np.exp(rng.uniform(np.log(low), np.log(0.5), sets)) if tau is None else tau
    sigmas = np.exp(rng.uniform(np.log(0.01), np.log(1000.0), sets)) if sigma is None else sigma
    b = rng.normal(size=(sets, ORDERS[-1] + 1))
    b[:, :2] *= WIDTH / 2
    b[:, 0] += WIDTH / 2
    b[:, 2:] *= np.broadcast_to(taus, sets)[:, None] * WIDTH
    b[np.arange(b.shape[1]) > order[:, None]] = 0.0
    noise = np.broadcast_to(sigmas, sets)[:, None] * rng.normal(size=(sets, n))
    return Problem(design, b @ design.T + noise, order)


def log_evidences(problem: Problem, tau: float | None = None, accuracy: Accuracy = FINE) -> Array:
    """Exact log evidence of every order on every data set, ``(n_sets, n_orders)``.

    sigma is inferred, the prior is `field`. The design is the same for all sets, so one
    singular value decomposition per tau serves them all. They are taken in order of their
    residuals: neighbours need the same nodes in ln sigma.

    Parameters
    ----------
    problem : Problem
    tau : float, optional
        Fixed in the prior where given, else inferred.
    accuracy : Accuracy, optional
        Of the quadrature.
    """
    q, r = np.linalg.qr(problem.design)
    qt = problem.t @ q
    tail = ((problem.t - qt @ q.T) ** 2).sum(axis=1)
    sets, n = problem.t.shape
    rule = PriorRule("field", WIDTH, WIDTH / 2, tau)
    out = np.empty((sets, len(ORDERS)))
    for column, order in enumerate(ORDERS):
        p = order + 1
        rss = tail + (qt[:, p:] ** 2).sum(axis=1)
        prior, noise = rule.of_order(order), NoiseLevel.inferred()
        tau_nodes, log_tau = tau_rule(prior, accuracy)
        ranked = np.argsort(rss)
        for part in np.array_split(ranked, -(-sets // _TOGETHER)):
            data = Reduced(
                r[None, :p, :p],
                qt[part, :p],
                rss[part],
                np.full(len(part), float(n)),
                np.zeros(len(part)),
            )
            projection = Projection.of(data, prior, log_tau)
            sigma_nodes, values = log_joint(data, projection, noise, prior, accuracy)
            weights = tau_nodes.weights[:, None] * sigma_nodes.weights
            out[part, column] = logsumexp(values, axis=(-2, -1), b=weights)
    return out


@dataclass(frozen=True, eq=False)
class Claims:
    """What is claimed of data sets of known order.

    Attributes
    ----------
    probability : Array
        Of every order, ``(n_sets, n_orders)``.
    strength : Array
        2 ln B of the most probable order against the runner-up, ``(n_sets,)``.
    claimed, order : IntArray
        The most probable and the true order, ``(n_sets,)``.
    """

    probability: Array
    strength: Array
    claimed: IntArray
    order: IntArray

    @classmethod
    def of(cls, log_evidence: Array, order: IntArray) -> Claims:
        """Form the probabilities, equal before the data, and the claims."""
        second, first = np.sort(log_evidence, axis=1)[:, -2:].T
        probability = np.exp(log_evidence - logsumexp(log_evidence, axis=1, keepdims=True))
        claimed = np.array(ORDERS)[log_evidence.argmax(axis=1)]
        return cls(probability, 2 * (first - second), claimed, order)

    @property
    def confidence(self) -> Array:
        """Probability of the claimed order, ``(n_sets,)``."""
        return np.asarray(self.probability.max(axis=1))

    def bins(self) -> list[Bin]:
        """All pairs (probability, truth) in ten bins of equal count, by probability."""
        p = self.probability.ravel()
        true = (np.array(ORDERS) == self.order[:, None]).ravel()
        parts = np.array_split(np.argsort(p, kind="stable"), BINS)
        return [Bin.of(p[part], part // len(ORDERS), int(true[part].sum())) for part in parts]

    def very_strong(self) -> VeryStrong:
        """Count very strong claims, and the wrong ones among them."""
        kept = self.strength > VERY_STRONG
        risk = 1 - self.confidence[kept]
        wrong = int((self.claimed != self.order)[kept].sum())
        limit = poisson_binomial_quantile(risk, 0.999)
        return VeryStrong(int(kept.sum()), wrong, float(risk.sum()), limit)


@dataclass(frozen=True)
class Bin:
    """Pairs of about the same probability: how many are true, how many should be.

    Attributes
    ----------
    lower, upper : float
        Range of the probabilities.
    expected : float
        Their sum.
    observed : int
        How many of the orders are the true ones.
    binomial_error : float
        Standard error of that number were the pairs independent, sqrt(sum p (1 - p)).
    exact_error : float
        Only one order of a data set is true: sqrt(sum q (1 - q)), q the sum of a data set's
        probabilities in the bin. Never more than the binomial one.
    """

    lower: float
    upper: float
    expected: float
    observed: int
    binomial_error: float
    exact_error: float

    @classmethod
    def of(cls, p: Array, data_set: IntArray, observed: int) -> Bin:
        """Sum up a bin's probabilities and the data set of each, both ``(n_pairs,)``."""
        q = np.minimum(np.bincount(data_set, weights=p), 1.0)
        errors = (float(np.sqrt((x * (1 - x)).sum())) for x in (p, q))
        return cls(float(p.min()), float(p.max()), float(p.sum()), observed, *errors)

    @property
    def deviations(self) -> tuple[float, float]:
        """Observed less expected, in binomial and in exact standard errors."""
        difference = self.observed - self.expected
        if abs(difference) < _ROUNDING:
            return 0.0, 0.0
        errors = self.binomial_error, self.exact_error
        binomial, exact = (difference / error if error else math.inf for error in errors)
        return binomial, exact

    @property
    def calibrated(self) -> bool:
        """Whether they agree within four standard errors, of either kind."""
        return max(map(abs, self.deviations)) <= STANDARD_ERRORS


@dataclass(frozen=True)
class VeryStrong:
    """Very strong claims: how many, how many wrong, the expected number and its 99.9 % quantile."""

    claims: int
    wrong: int
    expected: float
    limit: int

    @property
    def honest(self) -> bool:
        """Whether no more are wrong than their own probabilities allow."""
        return self.wrong <= self.limit


def poisson_binomial_quantile(p: Array, level: float) -> int:
    """Smallest k with P(number of events <= k) >= level, for events of probabilities `p`."""
    mass = np.array([1.0])
    for chance in p:
        mass = np.append(mass * (1 - chance), 0.0) + np.append(0.0, mass * chance)
    reached = np.flatnonzero(np.cumsum(mass) >= level)
    return int(reached[0]) if reached.size else len(p)
