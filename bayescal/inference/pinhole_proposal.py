r"""A proposal for a pinhole's posterior: one t for each strength of the distortion.

With tau integrated out, the displacements' density is a spike on a plateau, which no few
components learnt from draws follow (2 % of them effective at order 2 of the thesis data).
Given tau it is nearly normal: the proposal is a mixture over a ladder of tau of the Laplace
approximations, weighted by their masses, with a broad defensive component.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from bayescal.arrays import Array
from bayescal.inference.optimum import Mode
from bayescal.inference.pinhole import PinholeModel
from bayescal.inference.pinhole_laplace import laplace
from bayescal.inference.t_mixture import TMixture, cholesky
from bayescal.models.priors import TAU_BOUNDS

RUNGS = 10  # of the ladder of tau
DOF, BROAD_DOF = 25.0, 3.0
INFLATED = 1.05  # over the Laplace approximation, in deviations
BROAD, DEFENSIVE = 2.0, 0.05
NEGLIGIBLE = 1e-5  # share of a component that is left out


def ladder(model: PinholeModel) -> tuple[tuple[Mode, ...], Array]:
    """Laplace approximation at each tau of a ladder, and the log of its share of the evidence.

    Parameters
    ----------
    model : PinholeModel
        With Gaussian noise.

    Returns
    -------
    modes : tuple of Mode
        In sampled coordinates; one where tau is no parameter.
    log_mass : Array
        Their logs sum to the Laplace approximation of the log evidence, ``(n_modes,)``.
    """
    prior, frame = model.prior, model.frame
    if model.infers_tau:
        edges = np.linspace(*np.log(TAU_BOUNDS), RUNGS + 1)
        rungs = np.exp((edges[1:] + edges[:-1]) / 2).tolist()
    else:
        rungs = [prior.tau if prior.tau is not None else 1.0]
    modes, start = [], model.fit.free
    for tau in rungs[::-1]:
        found = laplace(model.geometry, prior, model.data, start, tau)
        fixed = replace(model, prior=replace(prior, tau=tau))
        theta = solve_triangular(frame.root, found.mean - frame.mean, lower=True)
        root = solve_triangular(frame.root, found.root, lower=True)
        modes.append(Mode(theta, float(fixed.log_prob(theta[None])[0]), root))
        start = found.mean
    return tuple(modes), np.array([m.log_mass for m in modes]) - np.log(len(rungs))


def pinhole_proposal(modes: tuple[Mode, ...], log_mass: Array) -> TMixture:
    """Mixture of t about the modes of a ladder, and a broad one about them all.

    Parameters
    ----------
    modes : tuple of Mode
        At least one.
    log_mass : Array
        ``(n_modes,)``.
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
