"""Draws of every kind of posterior, as what a camera keeps: amplitudes, poses, noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, solve_triangular

from bayescal.arrays import Array
from bayescal.density.drawn import DrawnAxis
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.posterior import Posterior
from bayescal.inference.weighting import WeightedDraws
from bayescal.linear.closed_form import ExactPosterior
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.noise.model import NoiseModel
from bayescal.prediction.calibrated.members import KEPT, Estimate, Parameters
from bayescal.prediction.calibrated.noise import NewNoise


@dataclass(frozen=True, eq=False)
class AxisDraws:
    """One axis of a linear family.

    Attributes
    ----------
    parameters : Parameters
        Of the Legendre amplitudes, px.
    log_sigma : Array
        ``(n_draws,)``; of a scale where points have deviations of their own.
    eta : Array
        Coordinates of the noise model, ``(n_draws, dimension)``.
    sd : Array or None
        The points' own deviations, ``(n_points,)``, px.
    estimate : Estimate or None
        Of the amplitudes by the data alone, where it has a closed form.
    """

    parameters: Parameters
    log_sigma: Array
    eta: Array
    noise: NoiseModel
    sd: Array | None
    estimate: Estimate | None = None

    @classmethod
    def of(cls, drawn: DrawnAxis) -> AxisDraws:
        """Take mean and covariance from the draws."""
        parameters = Parameters.of_draws(drawn.amplitudes)
        return cls(parameters, drawn.log_sigma, drawn.eta, drawn.noise, drawn.sd)


def thinned(draws: Array, n: int = KEPT) -> Array:
    """Evenly spaced rows of draws, `n` of them; all, again and again, where there are fewer."""
    if len(draws) < n:
        return draws[np.arange(n) % len(draws)]
    return draws[np.linspace(0, len(draws) - 1, n).round().astype(np.intp)]


def completed(kept: Posterior | WeightedDraws) -> Array:
    """Completed draws of a sampled or weighted model, ``(n_draws, n_full)``."""
    full = kept.full
    return thinned(full.reshape(-1, full.shape[-1]))


def of_posterior(posterior: Posterior, sd: Array | None) -> AxisDraws:
    """Draws of one order of one axis, whose points have deviations `sd` of their own."""
    exact = posterior.exact
    if exact is not None:
        model = exact.model
        theta = thinned(posterior.chain.theta.reshape(-1, model.dimension))
        log_sigma = theta[:, model.size] if model.infers_sigma else np.full(KEPT, _known(exact))
        return _of_exact(exact, theta[:, : model.size], log_sigma, sd)
    robust, full = posterior.model, completed(posterior)
    assert isinstance(robust, RobustLinearModel), "what one axis is sampled as"
    return AxisDraws.of(robust.drawn(full))


def of_exact(exact: ExactPosterior, rng: np.random.Generator, sd: Array | None) -> AxisDraws:
    """Draws of a closed form: a node of its quadrature by weight, then a normal."""
    share = exact.weights.ravel()
    nodes = rng.choice(share.size, size=KEPT, p=share / share.sum())
    tau, sigma = np.divmod(nodes, exact.weights.shape[1])
    level = exact.sigma[sigma]
    conditional = exact.conditional
    d, w = conditional.d[tau], conditional.w[tau]
    total = conditional.precision * level[:, None] ** 2 + d**2
    a = d * w / total + level[:, None] / np.sqrt(total) * rng.standard_normal(d.shape)
    b = exact.model.prior.mean + np.einsum("npq,nq->np", conditional.to_b[tau], a)
    return _of_exact(exact, b, np.log(level), sd)


def _of_exact(
    exact: ExactPosterior, amplitudes: Array, log_sigma: Array, sd: Array | None
) -> AxisDraws:
    parameters = Parameters(exact.mean, exact.root, amplitudes, True)
    none = np.empty((len(log_sigma), 0))
    return AxisDraws(parameters, log_sigma, none, GAUSSIAN, sd, _estimate(exact))


def _estimate(exact: ExactPosterior) -> Estimate:
    """Least squares, which every order that is taken determines.

    1 / sigma^2 has by its posterior a gamma distribution, or nearly so, whose mean and variance
    say the noise and its degrees of freedom.
    """
    model = exact.model
    inverse = solve_triangular(model.reduced.r, np.eye(model.size))
    share, precision = exact.weights.sum(axis=0), exact.sigma**-2.0
    mean = float(share @ precision)
    variance = float(share @ (precision - mean) ** 2)
    dof = 2 * mean**2 / variance if model.infers_sigma else np.inf
    value = inverse @ model.reduced.qt
    return Estimate(value, inverse / math.sqrt(mean), ((model.size, dof),))


def _known(exact: ExactPosterior) -> float:
    value = exact.model.noise.value
    assert value is not None, "sigma is inferred"
    return math.log(value)


def new_noise(
    log_sigma: Array, eta: Array, model: NoiseModel, deviations: tuple[Array | None, Array | None]
) -> NewNoise:
    """Noise of a new measurement, whose own deviation is the median of those of the points.

    Parameters
    ----------
    log_sigma : Array
        ``(n_draws, 2)``.
    eta : Array
        ``(n_draws, 2, dimension)``.
    deviations : tuple of Array or None
        The points' own deviations of r and of c, ``(n_points,)``, px.
    """
    usual = [0.0 if sd is None else math.log(float(np.median(sd))) for sd in deviations]
    return NewNoise(
        log_sigma + np.array(usual),
        eta,
        model.name,
        **model.chosen,
    )


def joined(r: Parameters, c: Parameters) -> Parameters:
    """Parameters of r and c, independent a posteriori, one after the other."""
    root = np.zeros((len(r.mean) + len(c.mean),) * 2)
    root[: len(r.mean), : len(r.mean)], root[len(r.mean) :, len(r.mean) :] = r.root, c.root
    return Parameters(
        np.concatenate([r.mean, c.mean]),
        root,
        np.concatenate([r.draws, c.draws], axis=1),
        r.exact and c.exact,
    )


def joined_estimates(r: Estimate | None, c: Estimate | None) -> Estimate | None:
    """Estimates of r and c, of independent noise, one after the other."""
    if r is None or c is None:
        return None
    return Estimate(
        np.concatenate([r.value, c.value]), block_diag(r.root, c.root), r.levels + c.levels
    )


def mapped(estimate: Estimate, coordinates: Callable[[Array], Array]) -> Estimate:
    """Carry an estimate to other coordinates, by one-sd steps.

    Parameters
    ----------
    coordinates : callable
        The new ones, ``(m, d)``, of the old.
    """
    steps = np.concatenate([estimate.value + estimate.root.T, estimate.value - estimate.root.T])
    up, down = np.split(coordinates(steps), 2)
    value = coordinates(estimate.value[None])[0]
    return Estimate(value, (up - down).T / 2, estimate.levels)
