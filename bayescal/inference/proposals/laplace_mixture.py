"""A proposal made of Laplace approximations, for posteriors known to be nearly their mixture."""

from __future__ import annotations

import numpy as np
from scipy.special import logsumexp

from bayescal.arrays import Array
from bayescal.inference.optimum import Mode
from bayescal.inference.t_mixture import TMixture, cholesky

DOF, BROAD_DOF = 25.0, 3.0
INFLATED = 1.05  # over the Laplace approximation, in deviations
BROAD, DEFENSIVE = 2.0, 0.05
NEGLIGIBLE = 1e-5  # share of a component that is left out


def mixture_about(modes: tuple[Mode, ...], log_mass: Array) -> TMixture:
    """Mix t about Laplace approximations, and a broad one about them all.

    Parameters
    ----------
    modes : tuple of Mode
        At least one.
    log_mass : Array
        Log of the mass of each, ``(n_modes,)``.
    """
    shares = np.exp(log_mass - logsumexp(log_mass))
    kept = np.flatnonzero(shares > NEGLIGIBLE)
    shares = shares[kept] / shares[kept].sum()
    means = np.array([modes[k].theta for k in kept])
    roots = np.array([modes[k].root for k in kept])
    centre = shares @ means
    within = np.einsum("k,kij,klj->il", shares, roots, roots)
    between = np.einsum("k,ki,kj->ij", shares, means - centre, means - centre)
    broad = BROAD * cholesky(within + between)
    return TMixture(
        np.append((1 - DEFENSIVE) * shares, DEFENSIVE),
        np.concatenate([means, centre[None]]),
        np.concatenate([INFLATED * roots, broad[None]]),
        np.append(np.full(len(kept), DOF), BROAD_DOF),
    )
