"""How far apart two nested orders lie over the domain, from draws of the larger one's posterior."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.linear.closed_form import ExactPosterior
from bayescal.polynomials.basis import legendre_design

# Places of the domain at which curves are compared, and draws: 95 % quantiles to about 2 %.
PLACES, DRAWS = 201, 4000


def amplitude_draws(exact: ExactPosterior, rng: np.random.Generator, size: int = DRAWS) -> Array:
    """Draw Legendre amplitudes from the closed form, ``(size, p)``, px.

    Sigma and tau are drawn among the quadrature's nodes, the amplitudes given them.
    """
    shares = exact.weights.ravel()
    nodes = rng.choice(shares.size, size=size, p=shares / shares.sum())
    tau, sigma = np.unravel_index(nodes, exact.weights.shape)
    mean, variance = exact.conditional.moments(exact.sigma**2)
    a = mean[tau, sigma] + np.sqrt(variance[tau, sigma]) * rng.standard_normal(
        (size, mean.shape[-1])
    )
    draws = np.einsum("npq,nq->np", exact.conditional.to_b[tau], a)
    return np.asarray(exact.model.prior.mean + draws)


def largest_differences(triangle: Array, amplitudes: Array, smaller: int) -> Array:
    """Largest distance between each drawn curve and the lower order that fits it best, px.

    The lower order's curve is the one that the same points would give without noise: the
    difference is what leaving out the higher orders costs, not what noise adds.

    Parameters
    ----------
    triangle : Array
        R of the weighted design at the larger order or above, upper triangle.
    amplitudes : Array
        Draws of the larger order, ``(n_draws, p)``, px.
    smaller : int
        The lower order.

    Returns
    -------
    Array
        ``(n_draws,)``.
    """
    p, q = amplitudes.shape[1], smaller + 1
    if p <= q:
        return np.zeros(len(amplitudes))
    design = legendre_design(np.linspace(-1, 1, PLACES), p - 1)
    taken_up = solve_triangular(triangle[:q, :q], triangle[:q, q:p])
    left = design[:, q:] - design[:, :q] @ taken_up
    return np.asarray(np.abs(amplitudes[:, q:] @ left.T).max(axis=1))
